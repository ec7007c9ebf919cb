//! Robots, physics and campaigns that the library has not seen: is what `discover` reports true?
//!
//! Plants have causes by laws that are no formula of the model, geometries of no other study, and noise that is not that of
//! the model. Half of the robots are for tuning, half are locked ([`stream`]).
//!
//! `study reliability --half tuning|locked [--series N] [--kind K,K] [--poses N,N] [--cause C,C] [--robots N] [--from N]
//! [--folder NAME] [--publish]` runs what is not yet in its table, one line a robot, and writes the summary (`--publish`: into `docs/reliability.md` too);
//! `--one KIND CELL NUMBER` shows one report.

mod cause;
mod compliances;
mod description;
mod drives;
mod everyday;
mod everything;
mod executed;
mod found;
mod hidden;
mod interval;
mod judged;
mod oracle;
mod pieces;
mod plant;
mod record;
mod reported;
mod robots;
mod select;
mod size;
mod stream;
mod summary;
mod trial;
mod words;

use crate::document;
use crate::journal::{Journal, commit, line};
use crate::results::{Kept, finish};
use crate::{asked, print};
use clap::Parser;
use description::{KINDS, Kind};
use rayon::prelude::*;
use record::Record;
use std::error::Error;
use std::sync::Mutex;
use stream::Half;
use trial::Task;

/// The options of the run.
#[derive(Parser)]
struct Asked {
    #[arg(long, value_parser = half, default_value = "tuning")]
    half: Half,
    /// Which robots of the half: a locked half that was looked at has a later one.
    #[arg(long, default_value_t = 1, value_parser = clap::value_parser!(u64).range(1..=255))]
    series: u64,
    #[arg(long, value_delimiter = ',', value_parser = kind)]
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
pub fn run(arguments: &[String]) -> Result<(), Box<dyn Error>> {
    let asked: Asked = asked(arguments)?;
    if let [word, cell, number] = &asked.one[..] {
        let task = asked.task(kind(word)?, &cell.replace('-', ""), number.parse()?);
        print(&task.report()?);
        print(line(&task.run()).trim_end());
        return Ok(());
    }
    if asked.half == Half::Locked && commit().ends_with("-changed") {
        return Err("files differ from the commit; the locked half is run at a commit alone".into());
    }
    let (folder, commit) = asked.kept.open("unseen")?;
    let (half, part) = (asked.half.word(), asked.half.part(asked.series));
    let journal = Journal::open(&folder, &part, &commit)?;
    let begun = journal.begun.clone();
    let records = work(journal, &asked.tasks())?;
    let series = if asked.series > 1 { format!(", series {}", asked.series) } else { String::new() };
    let head = format!("The {half} half{series}, commit {begun}.\n\n");
    let text = head + &summary::all(&records)?;
    if asked.publish {
        document::write(&format!("unseen {part}"), &text)?;
    }
    finish("unseen", &folder.join(format!("{part}.md")), &text)
}

/// Runs what is not yet in the journal, robots in parallel; each line is written when its robot is done.
fn work(journal: Journal<Record>, tasks: &[Task]) -> Result<Vec<Record>, Box<dyn Error>> {
    let open: Vec<&Task> = tasks
        .iter()
        .filter(|task| {
            let known = |r: &Record| r.is(task.key.half, task.kind, &task.cell, task.key.number);
            !journal.records.iter().any(known)
        })
        .collect();
    let (all, known) = (open.len(), journal.records.len());
    print(&format!("{known} robots are in the table, {all} to come"));
    let shared = Mutex::new((journal, 0usize));
    let failed = open.par_iter().find_map_any(|task| {
        let record = task.run();
        let Ok(mut shared) = shared.lock() else { return Some("another robot's line was lost".to_owned()) };
        shared.1 += 1;
        print(&format!(
            "{}/{all} {}: {} {} ({} s)",
            shared.1,
            task.words(),
            record.text("cause"),
            if record.ended() { record.text("words") } else { record.text("ended") },
            record.text("seconds"),
        ));
        shared.0.add(record).err().map(|error| error.to_string())
    });
    if let Some(error) = failed {
        return Err(error.into());
    }
    let mut records = shared.into_inner().map_err(|_| "a robot's line was lost")?.0.records;
    records.sort_by_key(Record::order);
    Ok(records)
}

impl Asked {
    fn task(&self, kind: Kind, cell: &str, number: u64) -> Task {
        let mut task = Task::of(kind, cell, self.half, number);
        task.key.series = self.series;
        task
    }

    /// The next robot of every cell, then the one after: a run that ends early has all cells.
    fn tasks(&self) -> Vec<Task> {
        let mut tasks = Vec::new();
        for number in self.from..self.from + self.robots {
            let kinds = if self.kind.is_empty() { &KINDS[..] } else { &self.kind };
            for &kind in kinds {
                let wanted =
                    |cell: &String| kind != Kind::Power || self.poses.is_empty() || self.poses.contains(cell);
                let cells = kind.cells().into_iter().filter(wanted);
                tasks.extend(cells.map(|cell| self.task(kind, &cell, number)));
            }
        }
        if !self.cause.is_empty() {
            tasks
                .retain(|task| task.cause().is_some_and(|cause| self.cause.iter().any(|word| word == cause)));
        }
        tasks
    }
}

fn half(word: &str) -> Result<Half, String> {
    Half::named(word).ok_or_else(|| format!("unknown half `{word}`; there are: tuning, locked"))
}

fn kind(word: &str) -> Result<Kind, String> {
    let known = KINDS.map(Kind::word).join(", ");
    Kind::named(word).ok_or_else(|| format!("unknown kind `{word}`; there are: {known}"))
}

fn poses(word: &str) -> Result<String, String> {
    let cells = description::POSES.map(|poses| poses.to_string());
    let known = cells.iter().any(|cell| cell == word);
    known
        .then(|| word.to_owned())
        .ok_or_else(|| format!("no cell of {word} poses; there are: {}", cells.join(", ")))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs;
    use std::path::Path;

    fn arguments(text: &str) -> Vec<String> {
        text.split_whitespace().map(str::to_owned).collect()
    }

    #[test]
    fn options_select_tasks() {
        let asked = crate::asked::<Asked>(&arguments(
            "--half locked --kind power,null --poses 25,100 --robots 3 --from 7",
        ))
        .expect("options");
        let tasks = asked.tasks();
        assert_eq!(tasks.len(), 3 * 3);
        assert!(tasks.iter().all(|task| task.key.half == Half::Locked));
        assert_eq!((tasks[0].cell.as_str(), tasks[0].key.number), ("25", 7));
        assert!(tasks.iter().all(|task| task.key.series == 1));
        let later = crate::asked::<Asked>(&arguments(
            "--series 2 --kind power --poses 30 --cause base_tilt --robots 40",
        ))
        .expect("options")
        .tasks();
        assert!((1..20).contains(&later.len()) && later.iter().all(|task| task.key.series == 2));
        assert!(later.iter().all(|task| task.cause() == Some("base_tilt")));
        for wrong in ["--series 0", "--half both", "--kind nothing", "--poses 26", "--seeds 3", "--robots"] {
            assert!(crate::asked::<Asked>(&arguments(wrong)).is_err(), "{wrong}");
        }
    }

    /// What is not a time, of each line.
    fn lines(records: &[Record]) -> Vec<String> {
        let timeless = |record: &Record| {
            let mut record = record.clone();
            record.set("seconds", "");
            line(&record)
        };
        records.iter().map(timeless).collect()
    }

    #[test]
    fn a_run_that_was_killed_is_continued_and_ends_the_same() {
        let root = std::env::temp_dir().join(format!("truepose-unseen-{}", std::process::id()));
        let of = |name: &str| {
            let folder = root.join(name);
            fs::create_dir_all(&folder).expect("a folder");
            folder
        };
        let tasks: Vec<Task> = (0..2).map(|number| Task::of(Kind::Null, "", Half::Tuning, number)).collect();
        let open = |folder: &Path| Journal::<Record>::open(folder, "tuning", "abc").expect("a journal");
        let whole = work(open(&of("whole")), &tasks).expect("records");
        assert!(whole.iter().all(Record::ended), "{whole:?}");
        // The first robot, and half a line of the second.
        let cut = of("cut");
        work(open(&cut), &tasks[..1]).expect("a record");
        let path = cut.join("tuning.jsonl");
        let text = fs::read_to_string(&path).expect("the table");
        let half: String = line(&whole[1]).chars().take(40).collect();
        fs::write(&path, text + &half).expect("half a line");
        let again = open(&cut);
        assert_eq!(again.records.len(), 1);
        let continued = work(again, &tasks).expect("records");
        assert_eq!(lines(&continued), lines(&whole));
        assert_eq!(open(&cut).records.len(), 2);
        fs::remove_dir_all(&root).expect("no folder");
    }
}
