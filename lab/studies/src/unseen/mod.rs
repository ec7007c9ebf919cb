//! Robots, physics and campaigns that the library has not seen: is what `discover` reports true?
//!
//! Plants have causes by laws that are no formula of the model, geometries of no other study, and noise that is not that of
//! the model. Half of the robots are for tuning, half are locked ([`stream`]).

mod amend;
mod cause;
mod description;
mod hidden;
mod plant;
mod record;
mod robots;
mod size;
mod stream;
mod summary;
mod trial;

use crate::journal::commit;
use crate::prelude::*;
use crate::results::publish;
use description::Kind;
use record::Record;
use trial::Task;

/// The options of the run.
#[derive(Parser)]
struct Options {
    #[arg(long, value_enum, default_value = "tuning")]
    half: Half,
    /// Which robots of the half: a locked half that was looked at has a later one.
    #[arg(long, default_value_t = 1, value_parser = clap::value_parser!(u64).range(1..=255))]
    series: u64,
    #[arg(long, value_enum, value_delimiter = ',')]
    kind: Vec<Kind>,
    /// Only these numbers of poses, of the kind `power`.
    #[arg(long, value_delimiter = ',', value_parser = poses)]
    poses: Vec<String>,
    /// Only robots with these causes.
    #[arg(long, value_delimiter = ',')]
    cause: Vec<String>,
    #[arg(long, default_value_t = 100)]
    robots: u64,
    #[arg(long, default_value_t = 0)]
    from: u64,
    #[command(flatten)]
    kept: Kept,
    /// Whether the summary goes into the documentation.
    #[arg(long)]
    publish: bool,
    /// One report.
    #[arg(long, num_args = 3, value_names = ["KIND", "CELL", "NUMBER"], allow_hyphen_values = true)]
    one: Vec<String>,
}

/// Runs the study.
pub fn run(arguments: &[String]) -> Outcome {
    let options: Options = parsed(arguments)?;
    if let [word, cell, number] = &options.one[..] {
        let task = options.task(Kind::from_str(word, false)?, &cell.replace('-', ""), number.parse()?);
        print(&task.report()?);
        print_line(&task.run());
        return Ok(());
    }
    if options.half == Half::Locked && commit().ends_with("-changed") {
        return Err("files differ from the commit; the locked half is run at a commit alone".into());
    }
    let (folder, commit) = options.kept.open("unseen")?;
    let (half, part) = (options.half.word(), options.half.part(options.series));
    let journal = Journal::open(&folder, &part, &commit)?;
    let begun = journal.begun.clone();
    let records = work(journal, &options.tasks())?;
    let series = if options.series > 1 { format!(", series {}", options.series) } else { String::new() };
    let head = format!("The {half} half{series}, commit {begun}.\n\n");
    let text = head + &summary::all(&records)?;
    if options.publish {
        publish(&format!("unseen {part}"), &text)?;
    }
    finish("unseen", &folder.join(format!("{part}.md")), &text)
}

/// Runs what is not yet in the journal, robots in parallel; each line is written when its robot is done.
fn work(journal: Journal<Record>, tasks: &[Task]) -> Outcome<Vec<Record>> {
    let words = |task: &Task, record: &Record| {
        let story = record.text(if record.ended() { "words" } else { "ended" });
        format!("{}: {} {story} ({} s)", task.words(), record.text("cause"), record.text("seconds"))
    };
    let is_of =
        |record: &Record, task: &Task| record.is(task.key.half, task.kind, &task.cell, task.key.number);
    let mut records = journal.complete_in_parallel(tasks, is_of, Task::run, words)?;
    records.sort_by_key(Record::order);
    Ok(records)
}

impl Options {
    fn task(&self, kind: Kind, cell: &str, number: u64) -> Task {
        let mut task = Task::of(kind, cell, self.half, number);
        task.key.series = self.series;
        task
    }

    /// The next robot of every cell, then the one after: a run that ends early has all cells.
    fn tasks(&self) -> Vec<Task> {
        let mut tasks = Vec::new();
        for number in self.from..self.from + self.robots {
            let kinds = if self.kind.is_empty() { Kind::all() } else { &self.kind };
            for &kind in kinds {
                let wanted =
                    |cell: &String| kind != Kind::Power || self.poses.is_empty() || self.poses.contains(cell);
                let cells = kind.cells().into_iter().filter(wanted);
                tasks.extend(cells.map(|cell| self.task(kind, &cell, number)));
            }
        }
        if !self.cause.is_empty() {
            tasks.retain(|task| task.cause().is_some_and(|cause| self.cause.contains(&cause.word())));
        }
        tasks
    }
}

fn poses(word: &str) -> Result<String, String> {
    let cells = Kind::Power.cells();
    let known = cells.iter().find(|cell| *cell == word).cloned();
    known.ok_or_else(|| format!("no cell of {word} poses; there are: {}", cells.join(", ")))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn options_select_tasks() {
        let words_of = |text: &str| text.split_whitespace().map(str::to_owned).collect::<Vec<_>>();
        let read = |text: &str| parsed::<Options>(&words_of(text));
        let words = "--half locked --kind power,null --poses 25,100 --robots 3 --from 7";
        let options = read(words).expect("options");
        let tasks = options.tasks();
        assert_eq!(tasks.len(), 3 * 3);
        assert!(tasks.iter().all(|task| task.key.half == Half::Locked));
        assert_eq!((tasks[0].cell.as_str(), tasks[0].key.number), ("25", 7));
        assert!(tasks.iter().all(|task| task.key.series == 1));
        let words = "--series 2 --kind power --poses 30 --cause base_tilt --robots 40";
        let later = read(words).expect("options").tasks();
        assert!((1..20).contains(&later.len()) && later.iter().all(|task| task.key.series == 2));
        assert!(later.iter().all(|task| task.cause() == Some(cause::Cause::BaseTilt)));
        for wrong in ["--series 0", "--half both", "--kind nothing", "--poses 26", "--seeds 3", "--robots"] {
            assert!(read(wrong).is_err(), "{wrong}");
        }
    }
}
