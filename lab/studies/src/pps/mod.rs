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

use crate::prelude::*;
mod trial;

pub use trial::{Experiment, Strategy, polynomial, reduced_first};

use crate::clock::{least, least_on_the_wall};
use trial::{Radii, strategies};

/// How many plants, and at how many of them the identification is timed.
const PLANTS: u64 = 20;
const TIMED: usize = 3;
/// How often each, of which the quickest counts.
const RUNS: usize = 3;

/// The options of the run.
#[derive(Parser)]
struct Options {
    #[arg(long, default_value_t = PLANTS)]
    plants: u64,
    /// Models with these words in their names.
    #[arg(long, default_value = "")]
    only: String,
}

/// Runs the study.
pub fn run(arguments: &[String]) -> Outcome {
    let Options { plants, only } = parsed(arguments)?;
    let folder = folder("pps")?;
    let seeds = (0..plants).into_par_iter();
    let experiments = seeds.map(|seed| Experiment::new(100 + seed)).collect::<Outcome<Vec<_>>>()?;
    let over = |of: fn(&Experiment) -> f64| show(experiments.iter().map(of));
    let mut text = format!("The paper's experiment, {plants} plants; radii in mm, median [worst]\n");
    let configurations = experiments.first().map_or(0, |e| e.configurations).to_string();
    for (words, here, paper) in [
        ("", "here".to_owned(), "paper"),
        ("error before", over(Experiment::before), "order of 10"),
        ("payload linearity at home", over(|e| e.linearity), "within 0.1"),
        ("radius of noise only", over(Experiment::noise_only), "–"),
        ("configurations used", configurations, "< 400"),
    ] {
        writeln!(text, "{words:48} {here:>16}   {paper}")?;
    }
    let mut table = Table::columns(
        "model and solver -48|rank 6|measured 16|/ noise only 12|noise-free 16|executed 16|rounds 6|ms 6|wall 6",
    );
    print(&format!("{text}\n{}", table.last()));
    let mut best: Option<(f64, usize)> = None;
    for strategy in strategies().into_iter().filter(|s| s.name.contains(&only)) {
        let radii = experiments.par_iter().map(|e| e.identify(&strategy)).collect::<Outcome<Vec<Radii>>>()?;
        let timed = || experiments.iter().take(TIMED);
        let work: Vec<f64> = timed().map(|e| least(RUNS, || e.fit(&strategy))).collect::<Outcome<_>>()?;
        let wall: Vec<f64> =
            timed().map(|e| least_on_the_wall(RUNS, || e.fit(&strategy))).collect::<Outcome<_>>()?;
        let middle = |of: fn(&Radii) -> f64| quantile(radii.iter().map(of), 0.5);
        let over = |of: fn(&Radii) -> f64| show(radii.iter().map(of));
        let (measured, noise_free, executed) =
            (over(|r| r.measured), over(|r| r.noise_free), over(|r| r.executed));
        let (ratio, rounds) = (fixed(middle(|r| r.measured / r.noise_only), 2), middle(|r| r.rounds as f64));
        let (rank, rounds) = (radii.first().map_or(0, |r| r.rank), fixed(rounds, 0));
        let [ms, wall] = [work, wall].map(|seconds| fixed(1e3 * quantile(seconds, 0.5), 0));
        let name = &strategy.name;
        table.row(&[name, &rank, &measured, &ratio, &noise_free, &executed, &rounds, &ms, &wall]);
        print(table.last());
        let median = middle(|r| r.noise_free);
        if best.as_ref().is_none_or(|b| median < b.0) {
            best = Some((median, radii.iter().map(|r| r.missed).sum()));
        }
    }
    writeln!(text, "\n{}paper (measured, one machine): {:>39}", table.text(), "0.38")?;
    finish("pps", &folder.join("table.txt"), &text)?;
    let missed = best.map_or(0, |(_, missed)| missed);
    print(&format!("commands of the best model that are not ok: {missed}"));
    Ok(())
}

/// Median and worst, from metres, in mm.
fn show(values: impl Iterator<Item = f64> + Clone) -> String {
    format!("{:.3} [{:.3}]", 1e3 * quantile(values.clone(), 0.5), 1e3 * quantile(values, 1.0))
}
