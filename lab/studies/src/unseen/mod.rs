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
use crate::journal::{Journal, Line, commit};
use crate::{folder, print};
use description::{KINDS, Kind};
use rayon::prelude::*;
use record::Record;
use std::error::Error;
use std::path::Path;
use std::sync::Mutex;
use stream::Half;
use trial::Task;

/// The options of the run.
struct Asked {
    half: Half,
    /// Which robots of the half: a locked half that was looked at has a later one.
    series: u64,
    kinds: Vec<Kind>,
    /// Only these numbers of poses, of the kind `power`.
    poses: Option<Vec<String>>,
    /// Only robots with these causes.
    causes: Option<Vec<String>>,
    robots: u64,
    from: u64,
    folder: Option<String>,
    /// Whether the summary goes into the documentation.
    publish: bool,
    one: Option<Task>,
}

/// Runs the study.
pub fn run(arguments: &[String]) -> Result<(), Box<dyn Error>> {
    let asked = Asked::of(arguments)?;
    if let Some(task) = &asked.one {
        print(&task.report()?);
        print(&task.run().row());
        return Ok(());
    }
    let commit = commit();
    if asked.half == Half::Locked && commit.ends_with("-changed") {
        return Err("files differ from the commit; the locked half is run at a commit alone".into());
    }
    let into = asked.folder.clone().unwrap_or_else(|| commit.chars().take(12).collect());
    let folder = folder("unseen")?.join(into);
    std::fs::create_dir_all(&folder)?;
    let (half, part) = (asked.half.word(), asked.half.part(asked.series));
    print(&format!("{half} half, series {}, commit {commit}; {}", asked.series, folder.display()));
    let journal = Journal::open(&folder, &part, &commit)?;
    let records = work(journal, &asked.tasks())?;
    let series = if asked.series > 1 { format!(", series {}", asked.series) } else { String::new() };
    let head = format!("The {half} half{series}, commit {}.\n\n", begun(&folder, &part)?);
    let text = head + &summary::all(&records)?;
    print(&text);
    if asked.publish {
        document::write(&format!("unseen {part}"), &text)?;
    }
    write(&folder, &part, &text)
}

/// The commit at which a table was begun: that of its first line.
fn begun(folder: &Path, part: &str) -> std::io::Result<String> {
    let text = std::fs::read_to_string(folder.join(format!("{part}.csv")))?;
    let first = text.lines().next().and_then(|line| line.strip_prefix("# commit "));
    Ok(first.unwrap_or("unknown").to_owned())
}

fn write(folder: &Path, part: &str, text: &str) -> Result<(), Box<dyn Error>> {
    let path = folder.join(format!("{part}.md"));
    std::fs::write(&path, text)?;
    print(&format!("table in {}", path.display()));
    Ok(())
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
    fn of(arguments: &[String]) -> Result<Self, Box<dyn Error>> {
        let mut asked = Asked {
            half: Half::Tuning,
            series: 1,
            kinds: KINDS.to_vec(),
            poses: None,
            causes: None,
            robots: 100,
            from: 0,
            folder: None,
            publish: false,
            one: None,
        };
        let mut rest = arguments.iter();
        let mut one = None;
        while let Some(word) = rest.next() {
            let mut next = || rest.next().ok_or_else(|| format!("`{word}` lacks its value"));
            match word.as_str() {
                "--half" => {
                    let word = next()?;
                    asked.half = Half::named(word)
                        .ok_or_else(|| format!("unknown half `{word}`; there are: tuning, locked"))?;
                }
                "--series" => asked.series = next()?.parse()?,
                "--kind" => {
                    let named = |word: &str| Kind::named(word).ok_or_else(|| unknown(word));
                    asked.kinds = next()?.split(',').map(named).collect::<Result<_, _>>()?;
                }
                "--poses" => asked.poses = Some(next()?.split(',').map(str::to_owned).collect()),
                "--cause" => asked.causes = Some(next()?.split(',').map(str::to_owned).collect()),
                "--robots" => asked.robots = next()?.parse()?,
                "--from" => asked.from = next()?.parse()?,
                "--folder" => asked.folder = Some(next()?.clone()),
                "--publish" => asked.publish = true,
                "--one" => {
                    let word = next()?;
                    let kind = Kind::named(word).ok_or_else(|| unknown(word))?;
                    let cell = next()?.replace('-', "");
                    one = Some((kind, cell, next()?.parse()?));
                }
                word => return Err(format!("unknown option `{word}` of the study").into()),
            }
        }
        let cells = description::POSES.map(|poses| poses.to_string());
        if let Some(wrong) = asked.poses.iter().flatten().find(|poses| !cells.contains(poses)) {
            return Err(format!("no cell of {wrong} poses; there are: {}", cells.join(", ")).into());
        }
        if !(1..=255).contains(&asked.series) {
            return Err(format!("`--series` is 1 to 255, not {}", asked.series).into());
        }
        asked.one = one.map(|(kind, cell, number)| asked.task(kind, &cell, number));
        Ok(asked)
    }

    fn task(&self, kind: Kind, cell: &str, number: u64) -> Task {
        let mut task = Task::of(kind, cell, self.half, number);
        task.key.series = self.series;
        task
    }

    /// The next robot of every cell, then the one after: a run that ends early has all cells.
    fn tasks(&self) -> Vec<Task> {
        let mut tasks = Vec::new();
        for number in self.from..self.from + self.robots {
            for &kind in &self.kinds {
                let wanted = |cell: &String| {
                    kind != Kind::Power || self.poses.as_ref().is_none_or(|poses| poses.contains(cell))
                };
                let cells = kind.cells().into_iter().filter(wanted);
                tasks.extend(cells.map(|cell| self.task(kind, &cell, number)));
            }
        }
        if let Some(causes) = &self.causes {
            tasks.retain(|task| task.cause().is_some_and(|cause| causes.iter().any(|word| word == cause)));
        }
        tasks
    }
}

fn unknown(word: &str) -> String {
    format!("unknown kind `{word}`; there are: {}", KINDS.map(Kind::word).join(", "))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs;

    fn arguments(text: &str) -> Vec<String> {
        text.split_whitespace().map(str::to_owned).collect()
    }

    #[test]
    fn options_select_tasks() {
        let asked =
            Asked::of(&arguments("--half locked --kind power,null --poses 25,100 --robots 3 --from 7"))
                .expect("options");
        let tasks = asked.tasks();
        assert_eq!(tasks.len(), 3 * 3);
        assert!(tasks.iter().all(|task| task.key.half == Half::Locked));
        assert_eq!((tasks[0].cell.as_str(), tasks[0].key.number), ("25", 7));
        assert!(tasks.iter().all(|task| task.key.series == 1));
        let later = Asked::of(&arguments("--series 2 --kind power --poses 30 --cause base_tilt --robots 40"))
            .expect("options")
            .tasks();
        assert!((1..20).contains(&later.len()) && later.iter().all(|task| task.key.series == 2));
        assert!(later.iter().all(|task| task.cause() == Some("base_tilt")));
        for wrong in ["--series 0", "--half both", "--kind nothing", "--poses 26", "--seeds 3", "--robots"] {
            assert!(Asked::of(&arguments(wrong)).is_err(), "{wrong}");
        }
    }

    /// What is not a time, of each line.
    fn lines(records: &[Record]) -> Vec<String> {
        let timeless = |record: &Record| {
            let mut record = record.clone();
            record.set("seconds", "");
            Line::row(&record)
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
        let path = cut.join("tuning.csv");
        let text = fs::read_to_string(&path).expect("the table");
        let half: String = Line::row(&whole[1]).chars().take(40).collect();
        fs::write(&path, text + &half).expect("half a line");
        let again = open(&cut);
        assert_eq!(again.records.len(), 1);
        let continued = work(again, &tasks).expect("records");
        assert_eq!(lines(&continued), lines(&whole));
        assert_eq!(open(&cut).records.len(), 2);
        fs::remove_dir_all(&root).expect("no folder");
    }
}
