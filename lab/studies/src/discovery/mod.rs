//! The closed loop of `discover`, calibrated on simulated robots: false alarms, power, names, intervals.
//!
//! | part | plants | question |
//! | --- | --- | --- |
//! | nulls | nothing hidden; distractors, correlated visits, a third with heavy tails | how often is something found? |
//! | power | one cause hidden, at multiples of the detectable size | is it found, named, placed? do the intervals hold? |
//! | several | two or three causes in one | do they hide each other? |
//! | without | the same, its family taken out of the library | is it called by a wrong name? |

use crate::prelude::*;
pub mod hidden_effects;

mod plants;
pub mod record;
pub mod robots;
pub mod summary;
pub mod trial;

use hidden_effects::HiddenEffect;
use record::Record;
use trial::Task;
use truepose_report::{DiscoverySettings, DiscoverySummary};

/// Multiples of the detectable size.
const MULTIPLES: [f64; 5] = [0.5, 1.0, 2.0, 4.0, 8.0];
/// Robots with several causes for each of a cell.
const SEVERAL: u64 = 6;
/// At which a family is taken out.
const WITHOUT: f64 = 4.0;

/// The options of the run.
#[derive(Parser)]
struct Options {
    /// 12 nulls, one robot a cell at 1 and 4 times the detectable size.
    #[arg(long)]
    short: bool,
    #[arg(long, default_value_t = 1000, default_value_if("short", "true", "12"))]
    nulls: u64,
    #[arg(long, default_value_t = 20, default_value_if("short", "true", "1"))]
    robots: u64,
    #[arg(long, value_delimiter = ',')]
    multiples: Vec<f64>,
    #[arg(long, value_enum, value_delimiter = ',')]
    causes: Vec<HiddenEffect>,
    #[arg(long, value_parser = ["nulls", "power", "several", "without"])]
    part: Option<String>,
    #[command(flatten)]
    kept: Kept,
    /// One robot, with its whole diagnosis; the cause `none` is a null.
    #[arg(long, num_args = 3, value_names = ["CAUSE", "SEED", "MULTIPLE"])]
    one: Vec<String>,
    /// The family of the one's cause is taken out of the library.
    #[arg(long, requires = "one")]
    without: bool,
}

/// Runs the study.
pub fn run(arguments: &[String]) -> Outcome {
    let mut options: Options = parsed(arguments)?;
    if let [word, seed, multiple] = &options.one[..] {
        let cause = if word == "none" { None } else { Some(HiddenEffect::from_str(word, false)?) };
        let (seed, multiple) = (seed.parse()?, multiple.parse()?);
        return one(&Task { cause, multiple, seed, without: options.without });
    }
    if options.multiples.is_empty() {
        options.multiples = if options.short { vec![1.0, 4.0] } else { MULTIPLES.to_vec() };
    }
    if options.causes.is_empty() {
        options.causes = HiddenEffect::all().to_vec();
    }
    let (folder, commit) = options.kept.open("discovery")?;
    let wanted = |part: &str| options.part.as_deref().is_none_or(|only| only == part);
    let mut text = format!("commit {commit}\n\n");
    let mut journal: Journal<Record> = Journal::open(&folder, "nulls", &commit)?;
    if wanted("nulls") {
        work(&mut journal, (0..options.nulls).map(Task::null))?;
    }
    text += &summary::nulls(&journal.records)?;

    let mut journal: Journal<Record> = Journal::open(&folder, "power", &commit)?;
    if wanted("power") {
        // All cells first, then the next robot of each.
        let tasks = (0..options.robots).flat_map(|seed| {
            let causes = &options.causes;
            options
                .multiples
                .iter()
                .flat_map(move |&multiple| causes.iter().map(move |&cause| Task::of(cause, multiple, seed)))
        });
        work(&mut journal, tasks)?;
    }
    text += &format!("\n{}", summary::power(&journal.records, &options.multiples)?);
    text += &format!("\n{}", summary::confusion_text(&journal.records)?);
    text += &format!("\n{}", summary::coverage(&journal.records)?);

    let mut journal: Journal<Record> = Journal::open(&folder, "several", &commit)?;
    if wanted("several") {
        trial::work_several(&mut journal, SEVERAL * options.robots)?;
    }
    text += &format!("\n{}", trial::summary_of_several(&journal.records)?);

    let mut journal: Journal<Record> = Journal::open(&folder, "without", &commit)?;
    if wanted("without") {
        let tasks = (0..options.robots).flat_map(|seed| {
            let causes =
                options.causes.iter().filter(|c| !matches!(c, HiddenEffect::Outliers | HiddenEffect::Wobble));
            causes.map(move |&cause| Task { without: true, ..Task::of(cause, WITHOUT, seed) })
        });
        work(&mut journal, tasks)?;
    }
    text += &format!("\n{}", summary::without(&journal.records)?);
    finish("discovery", &folder.join("table.txt"), &text)
}

/// Runs what is not yet in the table.
pub fn work(journal: &mut Journal<Record>, tasks: impl Iterator<Item = Task>) -> Outcome {
    let words = |task: &Task, record: &Record| {
        Some(format!("{}: {} in {:.1} s, {}", task.words(), record.first, record.seconds, record.story))
    };
    journal.complete(tasks, |known, task| task.is_of(known), |task| Ok(task.run()), words)
}

/// One robot, with all results of the search.
fn one(task: &Task) -> Outcome {
    let (made, diagnosis) = task.diagnosed()?;
    let truth = made.hidden.first().map_or("nothing hidden".into(), |(_, hidden)| hidden.place.words());
    print(&format!("{}: {} with {}, λ = {:.3}", task.words(), made.robot, truth, made.lambda));
    let settings = DiscoverySettings {
        seed: plants::HOLDOUT.1,
        holdout: Some(plants::HOLDOUT.0),
        rotations: 999,
        alpha: 0.005,
    };
    let summary = DiscoverySummary::new(&diagnosis, settings);
    print(&summary.to_string());
    print(&serde_json::to_string_pretty(&summary)?);
    print_line(&task.judged(&made, &diagnosis));
    Ok(())
}
