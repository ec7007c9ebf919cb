//! How `discover` grows with rows: the plant of examples/01 with more poses and a smaller gear error, which is hidden.
//!
//! ```text
//! a(N) = a_0 √(N_0/N)      as large at every size beside what N rows can show
//! ```

use crate::workload::Failure;
use crate::{clock, say};
use std::path::Path;
use truepose_discover::{DiscoverOptions, diagnose};
use truepose_errormodel::EffectRegistry;
use truepose_io::{RobotOptions, read_model, read_robot, read_text};
use truepose_simulate::PlantDescription;
use truepose_solvers::PivotedQr;

/// Rows of a run.
const ROWS: [usize; 4] = [1_000, 10_000, 100_000, 1_000_000];
/// Rows of a configuration of the plant: three targets, twice.
const OF_CONFIGURATION: usize = 6;
/// Amplitude of the gear error at the first size, mrad.
const AMPLITUDE: f64 = 0.03;

/// Measures, searches and prints size after size.
pub fn run(most: usize, threads: usize) -> Result<(), Failure> {
    let folder = Path::new("examples/01_identify");
    let (chain, _) = read_robot(folder.join("robot.toml"), &RobotOptions::default())?;
    let effects = read_model(folder.join("model.toml"), &chain, &EffectRegistry::builtin())?;
    let text = read_text(folder.join("plant.toml"))?;
    let load = clock::load();
    for rows in ROWS.into_iter().filter(|rows| *rows <= most) {
        let mut description = PlantDescription::from_toml(&text)?;
        description.campaign.visits = rows.div_ceil(OF_CONFIGURATION);
        let amplitude = AMPLITUDE * (ROWS[0] as f64 / rows as f64).sqrt();
        for gear in &mut description.errors.transmission {
            gear.amplitude_mrad = amplitude;
        }
        let seed = description.seed;
        let plant = description.plant(&chain)?;
        let data = plant.measure(&description.campaign.on(&chain, seed)?, seed)?;
        let options = DiscoverOptions::default();
        let (cpu, wall, found) =
            clock::timed(|| diagnose(&chain, &effects, &data, &PivotedQr::default(), &options, &|_| ()));
        let found = found?;
        let names: Vec<String> = found.findings.iter().map(|finding| finding.candidate.words()).collect();
        // Sizes ascend, so that the peak of the process is that of the last one.
        say(&format!(
            "{:>9} rows: {cpu:.1} s CPU, {wall:.1} s, {:.0} MB; gear error {:.2} µrad: {}",
            data.len(),
            clock::memory_mb("VmHWM:"),
            1e3 * amplitude,
            if names.is_empty() { "nothing found".into() } else { names.join(", ") },
        ));
    }
    say(&format!(
        "{}, {threads} threads; load {load:.1} at the beginning, {:.1} at the end",
        clock::processor(),
        clock::load()
    ));
    Ok(())
}
