//! One line a robot.

use crate::prelude::*;

/// What is measured; RMS in mm unless the name has another unit.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Figure {
    /// Nominal robot after best base, tool and targets.
    Nominal,
    /// Constants only: `identify`.
    Constants,
    /// The same from the record as it would be without what went wrong; not judged.
    Clean,
    Tukey,
    Huber,
    Ridge,
    Discover,
    /// The exported geometry after best base, tool and targets.
    Export,
    /// The exported geometry as it is written.
    Written,
    /// The plant, executing nominal inverse kinematics after best base, tool and targets.
    DriveNominal,
    DriveConstants,
    DriveDiscover,
    /// How many of the fresh configurations could be executed.
    Executed,
    /// Nested folds of `discover`: the declared model, and what was found.
    NestedBefore,
    NestedAfter,
    /// Seconds on the wall, and of the processors.
    SecondsIdentify,
    SecondsDiscover,
    Processors,
    SecondsNested,
}

/// What became of one robot.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Record {
    pub number: u64,
    pub seed: u64,
    pub make: String,
    pub hidden: String,
    pub style: String,
    pub spoil: String,
    pub poses: usize,
    pub rows: usize,
    pub targets: usize,
    /// `base`, `tool`, `targets`, as far as they were unknown; `turns` where orientations were measured.
    pub given: String,
    pub noise_mm: f64,
    /// Without what was not requested, or rejected.
    pub figures: BTreeMap<Figure, f64>,
    /// What was found.
    pub finds: String,
    /// `verb: why`, of verbs that gave no answer; a panic begins with the word.
    pub refused: Vec<String>,
}

impl Record {
    /// NaN where there is none.
    pub fn get(&self, figure: Figure) -> f64 {
        self.figures.get(&figure).copied().unwrap_or(f64::NAN)
    }

    pub fn set(&mut self, figure: Figure, value: f64) {
        if value.is_finite() {
            self.figures.insert(figure, value);
        }
    }

    /// Number, seed, robot and number of poses.
    pub fn words(&self) -> String {
        let Record { number, seed, make, style, hidden, spoil, poses, .. } = self;
        format!("{number:>4} ({seed}) {make} {style} {hidden} {spoil}, {poses} poses")
    }

    /// The result of a verb; a refusal and a panic are noted.
    pub fn attempt<T>(&mut self, verb: &str, work: impl FnOnce() -> Outcome<T>) -> Option<T> {
        caught(work).map_err(|why| self.refuse(verb, &why)).ok()
    }

    /// Notes that a verb gave no answer.
    pub fn refuse(&mut self, verb: &str, why: &str) {
        self.refused.push(format!("{verb}: {}", why.replace([',', '\n', ';', '"'], " ")));
    }
}
