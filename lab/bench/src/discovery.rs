//! How `discover` grows: with rows, and with joints and channels.
//!
//! Rows: the plant of examples/01 with more poses and a smaller gear error, which is hidden.
//!
//! ```text
//! a(N) = a_0 √(N_0/N)      as large at every size beside what N rows can show
//! ```
//!
//! Breadth: arms of 3 to 30 joints, without channels and beside fifty thermometers of which none matters, with a gear error in the
//! middle joint that the model lacks.

use crate::prelude::*;
use std::fmt::Write;
use truepose_discover::{DiscoverOptions, diagnose};
use truepose_errormodel::{Channel, EffectRegistry};
use truepose_io::{RobotOptions, read_model, read_robot, read_text, robot_from_text};
use truepose_simulate::PlantDescription;

/// Rows of a run.
const ROWS: [usize; 4] = [1_000, 10_000, 100_000, 1_000_000];
/// Rows of a configuration of the plant: three targets, twice.
const OF_CONFIGURATION: usize = 6;
/// Amplitude of the gear error at the first size, mrad.
const AMPLITUDE: f64 = 0.03;
/// Of a run over breadth.
const JOINTS: [usize; 4] = [3, 6, 12, 30];
const CHANNELS: [usize; 2] = [0, 50];
const POSES: usize = 2_000;

/// Searches size after size, so that the peak of the process is mostly that of the last one.
pub fn rows(most: usize, threads: usize) -> Outcome {
    let folder = Path::new("examples/01_identify");
    let (chain, _) = read_robot(folder.join("robot.toml"), &RobotOptions::default())?;
    let effects = read_model(folder.join("model.toml"), &chain, &EffectRegistry::builtin())?;
    let text = read_text(folder.join("plant.toml"))?;
    let load = clock::load();
    for rows in ROWS.into_iter().filter(|rows| *rows <= most) {
        let mut description = PlantDescription::from_toml(&text)?;
        description.campaign.visits = rows.div_ceil(OF_CONFIGURATION);
        let amplitude = AMPLITUDE * (ROWS[0] as f64 / rows as f64).sqrt();
        description.errors.transmission.iter_mut().for_each(|gear| gear.amplitude_mrad = amplitude);
        let data = measured(&description, &chain)?;
        let (used, found) = searched(&chain, &effects, &data)?;
        let (rows, micro) = (data.len(), 1e3 * amplitude);
        say(&format!("{rows:>9} rows: {used}; gear error {micro:.2} µrad: {found}"));
    }
    say_machine(&format!("{threads} threads"), load);
    Ok(())
}

/// Searches arm after arm.
pub fn breadth(most: usize, threads: usize) -> Outcome {
    let load = clock::load();
    let declared: Vec<Box<dyn AnyEffect>> = vec![Box::new(Geometric::default())];
    for joints in JOINTS.into_iter().filter(|joints| *joints <= most) {
        for channels in CHANNELS {
            let (chain, _) = robot_from_text("snake.toml", &snake(joints)?, &RobotOptions::default())?;
            let hidden = format!("j{}", joints / 2 + 1);
            let plant = format!(
                "seed = 1\n[campaign]\nvisits = {POSES}\nvisit_s = 30\n[errors.geometric]\nposition_mm = 0.3\nangle_mrad = 0.3\n\
                 [[errors.transmission]]\njoint = \"{hidden}\"\namplitude_mrad = 0.3\ncycles = 3\n\
                 [instrument]\nsd_um = 20\n"
            );
            let mut data = measured(&PlantDescription::from_toml(&plant)?, &chain)?;
            wander(&mut data, channels);
            let (used, found) = searched(&chain, &declared, &data)?;
            say(&format!("{joints:>3} joints, {channels:>2} channels: {used}; hidden in {hidden}: {found}"));
        }
    }
    say_machine(&format!("{threads} threads"), load);
    Ok(())
}

fn measured(description: &PlantDescription, chain: &Chain) -> Outcome<Dataset> {
    let seed = description.seed;
    Ok(description.plant(chain)?.measure(&description.campaign.on(chain, seed)?, seed)?)
}

/// Times and memory of a search, and its findings.
fn searched(chain: &Chain, declared: &[Box<dyn AnyEffect>], data: &Dataset) -> Outcome<(String, String)> {
    let (solver, options) = (PivotedQr::default(), DiscoverOptions::default());
    let (cpu, wall, found) = clock::timed(|| diagnose(chain, declared, data, &solver, &options, &|_| ()));
    let names: Vec<String> = found?.findings.iter().map(|finding| finding.candidate.words()).collect();
    let used = format!("{cpu:.1} s CPU, {wall:.1} s, {:.0} MB", clock::memory_mb("VmHWM:"));
    Ok((used, if names.is_empty() { "nothing found".into() } else { names.join(", ") }))
}

/// An arm whose axes are across each other in turn.
fn snake(joints: usize) -> Result<String, std::fmt::Error> {
    let mut text = "name = \"snake\"\n[units]\nlength = \"mm\"\nangle = \"deg\"\n".to_owned();
    for k in 0..joints {
        let (d, a, alpha) = (30 * (k % 3), 120 + 10 * (k % 4), [90, -90, 0][k % 3]);
        let (dh, name) = (format!("{{ theta = 0, d = {d}, a = {a}, alpha = {alpha} }}"), k + 1);
        writeln!(text, "[[joints]]\nname = \"j{name}\"\ndh = {dh}\nlimits = [-85, 85]")?;
    }
    Ok(text)
}

/// Temperatures that wander, each by itself.
fn wander(data: &mut Dataset, channels: usize) {
    let mut state = 0x9e37_79b9_u32;
    let mut step = || {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        0.2 * (f64::from(state >> 8) / f64::from(1_u32 << 24) - 0.5)
    };
    for channel in 0..channels {
        let mut at = 20.0;
        let column = (0..data.len()).map(|_| {
            at += step();
            at
        });
        data.channels.push(column.collect());
        let (name, unit) = (format!("T{}", channel + 1), "degC".into());
        data.schema.channels.push(Channel { name, unit, temperature: true });
    }
}
