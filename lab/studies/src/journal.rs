//! The journal of a study: each record is a line of JSON, written as soon as it is complete, so that an interrupted run is continued.

use crate::prelude::*;
use serde::de::DeserializeOwned;
use std::fs;
use std::io::Write as _;
use std::path::PathBuf;
use std::process::Command;
use std::sync::Mutex;

/// Where records are kept.
#[derive(clap::Args)]
pub struct Kept {
    /// Folder of the records, in place of the commit's.
    #[arg(long)]
    folder: Option<String>,
}

impl Kept {
    /// The folder, which is made, and the commit.
    pub fn open(&self, study: &str) -> Outcome<(PathBuf, String)> {
        let commit = commit();
        let into = self.folder.clone().unwrap_or_else(|| commit.chars().take(12).collect());
        let folder = folder(study)?.join(into);
        fs::create_dir_all(&folder)?;
        print(&format!("commit {commit}; {}", folder.display()));
        Ok((folder, commit))
    }
}

/// The lines of one part of a study.
pub struct Journal<L> {
    path: PathBuf,
    /// The commit at which the file was begun, which its first line names.
    pub begun: String,
    pub records: Vec<L>,
}

impl<L: Serialize + DeserializeOwned> Journal<L> {
    /// Reads what is there; a line that was cut off is dropped.
    pub fn open(folder: &Path, part: &str, commit: &str) -> Outcome<Self> {
        let path = folder.join(format!("{part}.jsonl"));
        let text = fs::read_to_string(&path).unwrap_or_default();
        let begun = text.lines().next().and_then(|line| line.strip_prefix("# commit "));
        let begun = begun.unwrap_or(commit).to_owned();
        let records: Vec<L> = text.lines().filter_map(|line| serde_json::from_str(line).ok()).collect();
        let journal = Journal { path, begun, records };
        if !text.ends_with('\n') {
            let lines: String = journal.records.iter().map(line).collect();
            fs::write(&journal.path, format!("# commit {}\n{lines}", journal.begun))?;
        }
        Ok(journal)
    }

    /// The same, of a run that is only continued at the same commit.
    pub fn open_at(folder: &Path, part: &str, commit: &str) -> Outcome<Self> {
        let journal = Self::open(folder, part, commit)?;
        if journal.begun == commit {
            return Ok(journal);
        }
        fs::remove_file(&journal.path)?;
        Self::open(folder, part, commit)
    }

    /// Writes one line.
    pub fn add(&mut self, record: L) -> Outcome {
        fs::OpenOptions::new().append(true).open(&self.path)?.write_all(line(&record).as_bytes())?;
        self.records.push(record);
        Ok(())
    }

    /// Adds a record of each task that has none yet, one after the other; `words` are printed of each.
    pub fn complete<T>(
        &mut self,
        tasks: impl IntoIterator<Item = T>,
        is_of: impl Fn(&L, &T) -> bool,
        run: impl Fn(&T) -> Outcome<L>,
        words: impl Fn(&T, &L) -> Option<String>,
    ) -> Outcome {
        for task in tasks {
            if !self.records.iter().any(|known| is_of(known, &task)) {
                let record = run(&task)?;
                words(&task, &record).iter().for_each(|words| print(words));
                self.add(record)?;
            }
        }
        Ok(())
    }

    /// The same with tasks in parallel; the records in the order in which they were complete.
    pub fn complete_in_parallel<T: Sync>(
        self,
        tasks: &[T],
        is_of: impl Fn(&L, &T) -> bool,
        run: impl Fn(&T) -> L + Sync,
        words: impl Fn(&T, &L) -> String + Sync,
    ) -> Outcome<Vec<L>>
    where
        L: Send,
    {
        let is_open = |task: &&T| !self.records.iter().any(|known| is_of(known, task));
        let open: Vec<&T> = tasks.iter().filter(is_open).collect();
        let all = open.len();
        print(&format!("{} robots are in the table, {all} to come", self.records.len()));
        let shared = Mutex::new((self, 0usize));
        open.par_iter().try_for_each(|task| {
            let record = run(task);
            let mut shared = shared.lock().map_err(|_| "another robot's line was lost")?;
            shared.1 += 1;
            print(&format!("{}/{all} {}", shared.1, words(task, &record)));
            shared.0.add(record)
        })?;
        Ok(shared.into_inner().map_err(|_| "a robot's line was lost")?.0.records)
    }

    /// Ends the run: the file gets another name, under which nothing is continued.
    pub fn finish(self, part: &str) -> Outcome {
        Ok(fs::rename(&self.path, self.path.with_file_name(format!("{part}.jsonl")))?)
    }
}

/// A record as a line.
pub fn line<L: Serialize>(record: &L) -> String {
    serde_json::to_string(record).map_or_else(|error| format!("# {error}\n"), |line| line + "\n")
}

/// Prints a record as a line.
pub fn print_line<L: Serialize>(record: &L) {
    print(line(record).trim_end());
}

/// The commit that is checked out, with a mark when files differ from it; `unknown` outside of a repository.
pub fn commit() -> String {
    let git = |arguments: &[&str]| {
        let done = Command::new("git").args(arguments).output().ok().filter(|done| done.status.success())?;
        Some(String::from_utf8_lossy(&done.stdout).trim().to_owned())
    };
    let Some(head) = git(&["rev-parse", "HEAD"]) else { return "unknown".into() };
    let changed =
        git(&["status", "--porcelain", "--untracked-files=no"]).is_some_and(|list| !list.is_empty());
    if changed { format!("{head}-changed") } else { head }
}

/// A number that may be none (NaN) or infinite, which JSON has no number for.
pub mod number {
    use serde::{Deserialize, Deserializer, Serializer};

    #[derive(Deserialize)]
    #[serde(untagged)]
    enum Number {
        Finite(f64),
        Word(String),
    }

    pub fn serialize<S: Serializer>(value: &f64, into: S) -> Result<S::Ok, S::Error> {
        if value.is_finite() { into.serialize_f64(*value) } else { into.serialize_str(&value.to_string()) }
    }

    pub fn deserialize<'a, D: Deserializer<'a>>(from: D) -> Result<f64, D::Error> {
        match Number::deserialize(from)? {
            Number::Finite(value) => Ok(value),
            Number::Word(word) => word.parse().map_err(serde::de::Error::custom),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[derive(Serialize, Deserialize, Clone)]
    struct Record {
        seed: u64,
        ratio: f64,
        #[serde(with = "number")]
        p: f64,
        story: String,
    }

    #[test]
    fn a_run_is_continued_where_it_was_cut_off() {
        let folder = std::env::temp_dir().join(format!("truepose-journal-{}", std::process::id()));
        fs::create_dir_all(&folder).expect("a folder");
        let record = Record { seed: 3, ratio: 0.1 + 0.2, p: f64::NAN, story: "a, \"b\"\n".into() };
        let open = |commit: &str| Journal::<Record>::open(&folder, "power", commit).expect("a journal");
        open("abc").add(record.clone()).expect("a line");
        let path = folder.join("power.jsonl");
        let half: String = line(&record).chars().take(20).collect();
        let text = fs::read_to_string(&path).expect("the file");
        fs::write(&path, text + &half).expect("half a line");
        let mut again = open("def");
        assert_eq!((again.records.len(), again.begun.as_str()), (1, "abc"));
        let back = &again.records[0];
        assert_eq!((back.seed, back.ratio.to_bits(), back.p.is_nan()), (3, record.ratio.to_bits(), true));
        assert_eq!(back.story, record.story);
        // The second task has no record yet.
        let run = |seed: &u64| Ok(Record { seed: *seed, ..record.clone() });
        again.complete([3, 4], |known, seed| known.seed == *seed, run, |_, _| None).expect("a line");
        // In parallel the order of the lines is not that of the tasks.
        let one = |seed: &u64| Record { seed: *seed, ..record.clone() };
        let is_of = |known: &Record, seed: &u64| known.seed == *seed;
        let all = again.complete_in_parallel(&[3, 4, 5, 6], is_of, one, |_, _| String::new());
        let mut seeds: Vec<u64> = all.expect("lines").iter().map(|record| record.seed).collect();
        seeds.sort_unstable();
        assert_eq!((seeds, open("def").records.len()), (vec![3, 4, 5, 6], 4));
        assert_eq!(Journal::<Record>::open_at(&folder, "power", "abc").expect("a journal").records.len(), 4);
        assert!(Journal::<Record>::open_at(&folder, "power", "def").expect("a journal").records.is_empty());
        open("def").finish("table").expect("the end");
        assert!(!path.exists() && folder.join("table.jsonl").exists());
        fs::remove_dir_all(&folder).expect("no folder");
    }
}
