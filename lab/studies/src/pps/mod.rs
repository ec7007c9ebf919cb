//! The paper's experiment (patient positioning system) against plants with real physics.
//!
//! Identification from set b) and half of set a), 394 configurations; the check on the other half of set a). Four radii a
//! plant, each the largest error of the treatment point over the 56 check configurations:
//!
//! | radius | compares | with |
//! | --- | --- | --- |
//! | measured | the treatment point computed from the three measured targets | the model |
//! | noise only | the same measurement | the true plant |
//! | noise-free | the true plant | the model |
//! | executed | the true plant, sent there with compensated commands | where it is wanted |
//!
//! `--plants N` takes fewer plants, `--only WORD` the models with that word in their names.

mod figures;
mod models;
mod trial;

pub use models::{Strategy, polynomial, reduced_first};
pub use trial::Experiment;

use crate::clock::{least, least_on_the_wall};
use crate::results::finish;
use crate::{asked, folder, print};
use clap::Parser;
use models::strategies;
use rayon::prelude::*;
use std::error::Error;
use std::fmt::Write;
use trial::Radii;

/// How many plants, and at how many of them the identification is timed.
const PLANTS: u64 = 20;
const TIMED: usize = 3;
/// How often each, of which the quickest counts.
const RUNS: usize = 3;

/// The options of the run.
#[derive(Parser)]
struct Asked {
    #[arg(long, default_value_t = PLANTS)]
    plants: u64,
    /// Models with these words in their names.
    #[arg(long, default_value = "")]
    only: String,
}

/// Runs the study.
pub fn run(arguments: &[String]) -> Result<(), Box<dyn Error>> {
    let Asked { plants, only } = asked(arguments)?;
    let folder = folder("pps")?;
    let mut text = String::new();
    let experiments: Vec<Experiment> = (0..plants)
        .into_par_iter()
        .map(|seed| Experiment::new(100 + seed).map_err(|e| e.to_string()))
        .collect::<Result<_, _>>()?;
    let before: Vec<f64> = experiments.iter().map(Experiment::before).collect();
    let noise: Vec<f64> = experiments.iter().map(Experiment::noise_only).collect();
    let linearity: Vec<f64> = experiments.iter().map(|e| e.linearity).collect();
    writeln!(text, "The paper's experiment, {plants} plants; radii in mm, median [worst]")?;
    writeln!(text, "{:48} {:>16}   paper", "", "here")?;
    writeln!(text, "{:48} {:>16}   order of 10", "error before", show(&before))?;
    writeln!(text, "{:48} {:>16}   within 0.1", "payload linearity at home", show(&linearity))?;
    writeln!(text, "{:48} {:>16}   –", "radius of noise only", show(&noise))?;
    let configurations = experiments.first().map_or(0, |e| e.configurations);
    writeln!(text, "{:48} {configurations:>16}   < 400", "configurations used")?;
    writeln!(text)?;
    writeln!(
        text,
        "{:48} {:>6} {:>16} {:>12} {:>16} {:>16} {:>6} {:>6} {:>6}",
        "model and solver",
        "rank",
        "measured",
        "/ noise only",
        "noise-free",
        "executed",
        "rounds",
        "ms",
        "wall"
    )?;
    print(&text);
    let mut best: Option<(f64, Vec<Radii>, String)> = None;
    for strategy in strategies().into_iter().filter(|s| s.name.contains(&only)) {
        let radii: Vec<Radii> = experiments
            .par_iter()
            .map(|e| e.identify(&strategy).map_err(|error| error.to_string()))
            .collect::<Result<_, _>>()?;
        let timed = || experiments.iter().take(TIMED);
        let work: Vec<f64> = timed().map(|e| least(RUNS, || e.fit(&strategy))).collect::<Result<_, _>>()?;
        let wall: Vec<f64> =
            timed().map(|e| least_on_the_wall(RUNS, || e.fit(&strategy))).collect::<Result<_, _>>()?;
        line(&mut text, &strategy, &radii, [&work, &wall])?;
        print(text.lines().last().unwrap_or_default());
        let median = quantile(&radii.iter().map(|r| r.noise_free).collect::<Vec<_>>(), 0.5);
        if best.as_ref().is_none_or(|b| median < b.0) {
            best = Some((median, radii, strategy.name.clone()));
        }
    }
    writeln!(text, "paper (measured, one machine): {:>39}", "0.38")?;
    finish("pps", &folder.join("table.txt"), &text)?;
    let missed: usize = best.iter().flat_map(|b| &b.1).map(|r| r.errors.len() - r.reached).sum();
    print(&format!("commands of the best model that are not ok: {missed}"));
    if let (Some((_, radii, name)), Some(first)) = (best, experiments.first()) {
        figures::space(&folder.join("figure_6.svg"), first, &radii[0], &name)?;
        figures::repeatability(&folder.join("figure_7.svg"), first)?;
        figures::axes(&folder.join("figure_8.svg"), &radii)?;
        figures::linearity(&folder.join("linearity.svg"), first)?;
        print(&format!("figures in {}", folder.display()));
    }
    Ok(())
}

fn line(
    text: &mut String,
    strategy: &Strategy,
    radii: &[Radii],
    seconds: [&[f64]; 2],
) -> Result<(), std::fmt::Error> {
    let of = |f: &dyn Fn(&Radii) -> f64| radii.iter().map(f).collect::<Vec<f64>>();
    writeln!(
        text,
        "{:48} {:>6} {:>16} {:>12.2} {:>16} {:>16} {:>6.0} {:>6.0} {:>6.0}",
        strategy.name,
        radii.first().map_or(0, |r| r.rank),
        show(&of(&|r| r.measured)),
        quantile(&of(&|r| r.measured / r.noise_only), 0.5),
        show(&of(&|r| r.noise_free)),
        show(&of(&|r| r.executed)),
        quantile(&of(&|r| r.rounds as f64), 0.5),
        1e3 * quantile(seconds[0], 0.5),
        1e3 * quantile(seconds[1], 0.5),
    )
}

/// Median and worst, from metres, in mm.
fn show(values: &[f64]) -> String {
    format!("{:.3} [{:.3}]", 1e3 * quantile(values, 0.5), 1e3 * quantile(values, 1.0))
}

fn quantile(values: &[f64], share: f64) -> f64 {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    if sorted.is_empty() {
        return f64::NAN;
    }
    let at = share * (sorted.len() - 1) as f64;
    let below = sorted[at.floor() as usize];
    below + (at - at.floor()) * (sorted[at.ceil() as usize] - below)
}
