//! Coverage of 95 % intervals on robots with known truth; p-values where the model is adequate.
//!
//! | part | robots | compared with the truth |
//! | --- | --- | --- |
//! | robots | everything declared, shapes left free | coefficients, shapes, bands of predictions and commands, statements about all poses, lack of fit |
//! | nulls | those of the study `discovery` | the family-wise p of its first screen |
//! | precision | none: ten ill-conditioned problems | solutions, covariances, ranks and relations, in sixty digits |
//! | power | the same with a hidden effect, at 4 and 8 times the detectable size | sizes and nonlinear parameters of `discover` |
//!
//! With `--half tuning` or `--half locked` it is the study of unseen robots (module `unseen`).

use crate::prelude::*;

mod plants;
mod precision;
mod table;
mod trial;

use crate::discovery::hidden_effects::HiddenEffect;
use crate::discovery::record::Record as Discovered;
use crate::discovery::trial::Task;
use crate::discovery::work;
use crate::results::publish;
use trial::Record;

/// Causes with a number that is the model's.
const FOUND: [HiddenEffect; 8] = {
    use HiddenEffect::*;
    [Mesh, Shift, ThermalLate, Thermal, BacklashApproach, JointCompliance, Coupling, Payload]
};

/// Multiples of the detectable size at which finds are judged: selection biases smaller ones.
const CLEAR: [f64; 2] = [4.0, 8.0];

/// How many robots of each part.
#[derive(Parser)]
struct Options {
    /// 20 robots, 6 nulls; seconds.
    #[arg(long)]
    short: bool,
    #[arg(long, default_value_t = 1000, default_value_if("short", "true", "20"))]
    robots: u64,
    #[arg(long, default_value_t = 300, default_value_if("short", "true", "6"))]
    nulls: u64,
    #[arg(long, default_value_t = 12, default_value_if("short", "true", "0"))]
    finds: u64,
    #[command(flatten)]
    kept: Kept,
    /// One robot, as a line.
    #[arg(long)]
    one: Option<u64>,
}

/// Runs the study.
pub fn run(arguments: &[String]) -> Outcome {
    let options: Options = parsed(arguments)?;
    if let Some(seed) = options.one {
        print_line(&trial::run(seed));
        return Ok(());
    }
    let (folder, commit) = options.kept.open("reliability")?;
    let mut robots: Journal<Record> = Journal::open(&folder, "robots", &commit)?;
    let words = |seed: &u64, record: &Record| {
        let shown = !record.ended() || (seed + 1).is_multiple_of(50);
        shown.then(|| format!("robot {seed}: {} ({:.1} s)", record.story, record.seconds))
    };
    let run = |seed: &u64| Ok(trial::run(*seed));
    robots.complete(0..options.robots, |known, seed| known.seed == *seed, run, words)?;
    let mut nulls: Journal<Discovered> = Journal::open(&folder, "nulls", &commit)?;
    work(&mut nulls, (0..options.nulls).map(Task::null))?;
    let mut finds: Journal<Discovered> = Journal::open(&folder, "power", &commit)?;
    let tasks = (0..options.finds).flat_map(|seed| {
        let cells = CLEAR.into_iter().flat_map(|m| FOUND.into_iter().map(move |cause| (m, cause)));
        cells.map(move |(multiple, cause)| Task::of(cause, multiple, seed))
    });
    work(&mut finds, tasks)?;

    let failed = robots.records.iter().filter(|r| !r.ended()).count();
    let text = [
        format!(
            "Commit {commit}, `cargo xtask study reliability --robots {} --nulls {} --finds {}`, seeds from 0; {failed} robots ended in an \
             error.\n",
            options.robots, options.nulls, options.finds
        ),
        table::declared(&robots.records),
        table::found(&finds.records),
        table::nulls(&robots.records, &nulls.records),
        "Ten ill-conditioned problems against sixty digits (`lab/studies/src/reliability/reference/make.py`); errors are relative, in columns of \
         unit length:\n"
            .to_owned(),
        precision::table(&precision::all()?),
    ]
    .join("\n");
    if !options.short {
        publish("reliability", &text)?;
    }
    finish("reliability", &folder.join("table.md"), &text)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A short form of the study: two robots with each extra; of what there are few, all together.
    #[test]
    fn coverage_is_near_its_nominal_value() {
        let records: Vec<Record> = (0..20).map(trial::run).collect();
        for record in &records {
            assert!(record.ended(), "robot {}: {}", record.seed, record.story);
        }
        let mut few = Vec::new();
        let mut kinds = 0;
        for what in trial::WHAT {
            let counts: Vec<(usize, usize)> =
                records.iter().filter_map(|r| r.counts.get(what)).map(|c| (c.held, c.of)).collect();
            kinds += usize::from(!counts.is_empty());
            if counts.len() < 10 { few.extend(counts) } else { holds(what, &counts) }
        }
        holds("few of a kind", &few);
        assert!(kinds > 15, "{kinds}");
    }

    /// No farther below 95 % than four deviations of a binomial law with as many trials as there are robots.
    fn holds(what: &str, counts: &[(usize, usize)]) {
        let c = table::Coverage::of(counts);
        let wide = 4.0 * (0.95f64 * 0.05 / c.robots as f64).sqrt();
        assert!(c.fraction > 0.95 - wide, "{what}: {c:?}");
    }
}
