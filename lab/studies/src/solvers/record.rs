//! One line of the table: what one strategy did on one problem, as a row of CSV and back.

use std::collections::BTreeMap;
use std::error::Error;
use std::fmt::Write as _;
use std::fs;
use std::io::Write as _;
use std::path::{Path, PathBuf};

/// A strategy on a problem.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Record {
    /// Which problems belong together: `condition`, `rows`, `ur10` …
    pub sweep: String,
    pub condition: f64,
    pub noise: f64,
    pub outliers: f64,
    pub rows: f64,
    pub unknowns: f64,
    pub seed: f64,
    pub solver: String,
    /// RMS error at rows that took no part and are not wrong; in standard deviations, for robots in mm.
    pub held_out: f64,
    /// The same of least squares without the outlying rows.
    pub oracle: f64,
    /// RMS error of the parameters in true sizes; NaN where there is no truth.
    pub parameters: f64,
    pub oracle_parameters: f64,
    /// Wall time of one solve (for robots: of one fit), s.
    pub seconds: f64,
    pub iterations: f64,
    /// Most bytes held at once.
    pub bytes: f64,
    pub rank: f64,
    /// Violation of the optimality conditions, relative.
    pub optimality: f64,
    /// Student's t and p of the held-out squares against the first strategy, over the folds.
    pub t: f64,
    pub p_value: f64,
    pub status: String,
}

/// The columns, in order.
pub const HEADER: &str = "sweep,condition,noise,outliers,rows,unknowns,seed,solver,held_out,oracle,parameters,\
oracle_parameters,seconds,iterations,bytes,rank,optimality,t,p_value,status";

impl Record {
    /// As a row; numbers come back to the bit.
    pub fn row(&self) -> String {
        let numbers = |list: &[f64]| list.iter().map(f64::to_string).collect::<Vec<_>>().join(",");
        format!(
            "{},{},{},{},{}",
            self.sweep,
            numbers(&[self.condition, self.noise, self.outliers, self.rows, self.unknowns, self.seed]),
            self.solver,
            numbers(&[
                self.held_out,
                self.oracle,
                self.parameters,
                self.oracle_parameters,
                self.seconds,
                self.iterations,
                self.bytes,
                self.rank,
                self.optimality,
                self.t,
                self.p_value,
            ]),
            self.status
        )
    }

    /// From a row; none when it is damaged.
    pub fn of(row: &str) -> Option<Self> {
        let cells: Vec<&str> = row.split(',').collect();
        if cells.len() != HEADER.split(',').count() {
            return None;
        }
        let number = |k: usize| cells[k].parse::<f64>().ok();
        Some(Record {
            sweep: cells[0].into(),
            condition: number(1)?,
            noise: number(2)?,
            outliers: number(3)?,
            rows: number(4)?,
            unknowns: number(5)?,
            seed: number(6)?,
            solver: cells[7].into(),
            held_out: number(8)?,
            oracle: number(9)?,
            parameters: number(10)?,
            oracle_parameters: number(11)?,
            seconds: number(12)?,
            iterations: number(13)?,
            bytes: number(14)?,
            rank: number(15)?,
            optimality: number(16)?,
            t: number(17)?,
            p_value: number(18)?,
            status: cells[19].into(),
        })
    }

    /// Held-out error over that of the oracle.
    pub fn ratio(&self) -> f64 {
        self.held_out / self.oracle
    }
}

/// The records of a run that may be taken up again where it was interrupted.
pub struct Journal {
    partial: PathBuf,
    whole: PathBuf,
    /// Finished problems, by name.
    done: BTreeMap<String, Vec<Record>>,
}

impl Journal {
    /// Takes up what an interrupted run of this same program left in `folder`; a finished run is not taken up.
    pub fn open(folder: &Path) -> Result<Self, Box<dyn Error>> {
        let (partial, whole) = (folder.join("partial.csv"), folder.join("table.csv"));
        let mark = format!("# {}", fingerprint()?);
        let text = fs::read_to_string(&partial).unwrap_or_default();
        let mut done = BTreeMap::new();
        if text.lines().next() == Some(&mark) {
            let (mut name, mut records) = (None, Vec::new());
            for line in text.lines().skip(1) {
                // A problem ends with its name; one that was cut off has none and is done again.
                if let Some(ended) = line.strip_prefix("# ") {
                    name = Some(ended.to_owned());
                } else if let Some(record) = Record::of(line) {
                    records.push(record);
                }
                if let Some(ended) = name.take() {
                    done.insert(ended, std::mem::take(&mut records));
                }
            }
        } else {
            fs::write(&partial, format!("{mark}\n"))?;
        }
        Ok(Journal { partial, whole, done })
    }

    /// What an interrupted run already found out about a problem.
    pub fn known(&self, problem: &str) -> Option<&[Record]> {
        self.done.get(problem).map(Vec::as_slice)
    }

    /// Writes down what was found out about a problem.
    pub fn add(&mut self, problem: &str, records: Vec<Record>) -> Result<(), Box<dyn Error>> {
        let mut text = String::new();
        for record in &records {
            writeln!(text, "{}", record.row())?;
        }
        writeln!(text, "# {problem}")?;
        fs::OpenOptions::new().append(true).open(&self.partial)?.write_all(text.as_bytes())?;
        self.done.insert(problem.to_owned(), records);
        Ok(())
    }

    /// Ends the run: the table takes the place of what was interrupted.
    pub fn finish(self, records: &[Record]) -> Result<(), Box<dyn Error>> {
        let rows: String = records.iter().map(|r| r.row() + "\n").collect();
        fs::write(&self.whole, format!("{HEADER}\n{rows}"))?;
        fs::remove_file(&self.partial)?;
        Ok(())
    }
}

/// Another program (a changed one) takes nothing up.
fn fingerprint() -> Result<String, Box<dyn Error>> {
    let program = fs::metadata(std::env::current_exe()?)?;
    let time = program.modified()?.duration_since(std::time::UNIX_EPOCH)?;
    Ok(format!("{} {}", program.len(), time.as_nanos()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_interrupted_run_is_taken_up_and_a_finished_one_is_not() {
        let folder = std::env::temp_dir().join(format!("truepose-journal-{}", std::process::id()));
        fs::create_dir_all(&folder).unwrap();
        let record = Record { sweep: "rows".into(), held_out: 0.1 + 0.2, ..Record::default() };
        let mut journal = Journal::open(&folder).unwrap();
        journal.add("first", vec![record.clone()]).unwrap();
        // Cut off in the middle of the second problem.
        let mut file = fs::OpenOptions::new().append(true).open(folder.join("partial.csv")).unwrap();
        writeln!(file, "{}", record.row()).unwrap();
        let again = Journal::open(&folder).unwrap();
        assert_eq!(again.known("first"), Some(&[record.clone()][..]));
        assert!(again.known("second").is_none());
        again.finish(&[record]).unwrap();
        assert!(Journal::open(&folder).unwrap().known("first").is_none());
        fs::remove_dir_all(&folder).unwrap();
    }
}
