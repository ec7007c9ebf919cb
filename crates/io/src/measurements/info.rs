//! What a reader understood of a table.

use super::mapping::ColumnMap;
use std::path::PathBuf;

/// What was read, for `truepose check` and for logs.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct CsvInfo {
    /// The file.
    pub file: PathBuf,
    /// Every column, in the order of the file.
    pub columns: Vec<ColumnInfo>,
    /// Which column was to be which.
    pub map: ColumnMap,
    /// How many rows.
    pub rows: usize,
    /// How many visits.
    pub visits: usize,
    /// How many different pairs of joint values and load.
    pub configurations: usize,
    /// How rows and visits were matched, where the file was read whole.
    pub grouping: Option<Grouping>,
    /// The file's own number of each visit; empty when the file numbers none.
    pub visit_labels: Vec<i64>,
    /// What the file calls each row (column `id`), of a file that was read whole; empty without such a column.
    pub ids: Vec<String>,
    /// Names of the sessions, in order of first appearance (column `session`); empty without such a column.
    pub sessions: Vec<String>,
    /// Names of the landmarks, in order of first appearance (column `landmark`); empty without such a column.
    pub landmarks: Vec<String>,
    /// Whether no column holds anything measured: a fit refuses the table.
    pub unmeasured: bool,
    /// What columns without a meaning are perhaps, as options and as `[columns]` of a robot file; empty where there is nothing to propose.
    pub proposal: String,
}

/// How rows were grouped into pose measurements (visits), and visits into configurations.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Grouping {
    /// Tolerance of turning joints, rad.
    pub angle: f64,
    /// Tolerance of slides, m.
    pub length: f64,
    /// Tolerances within which visits are repeats of one configuration: turning joints, rad, and slides, m.
    pub repeat_tolerance_angle: f64,
    /// See `repeat_tolerance_angle`.
    pub repeat_tolerance_length: f64,
    /// Whether the file numbers its visits; otherwise consecutive rows of one dwell are one visit.
    pub numbered: bool,
    /// Configurations that were visited more than once, and visits beyond the first of each.
    pub repeated: usize,
    /// See `repeated`.
    pub repeats: usize,
    /// How far such a visit is from the first of its configuration at most: turning joints, rad.
    pub repeat_angle: f64,
    /// And slides, m.
    pub repeat_length: f64,
    /// Rows whose joint values are not those of the first of their visit to the last digit.
    pub flickering: usize,
    /// By how much they differ at most: turning joints, rad.
    pub flicker_angle: f64,
    /// And slides, m.
    pub flicker_length: f64,
    /// Visits that go on with the configuration of the visit before, although nothing but a measured position parts the two.
    pub parted: usize,
    /// Neighbouring rows that differ by more than the tolerance and less than ten of it, and by how much at most (rad or m): of a robot at rest
    /// they may be flicker as well.
    pub near: usize,
    /// See `near`.
    pub near_most: f64,
}

/// One column of a table.
#[derive(Debug, Clone, PartialEq)]
pub struct ColumnInfo {
    /// Its name, without the unit.
    pub name: String,
    /// The unit of its cells, `1` where they have none.
    pub unit: String,
    /// Whether the header names the unit; otherwise it was assumed.
    pub unit_given: bool,
    /// What it was taken for, in words.
    pub meaning: String,
    /// How many cells are not empty.
    pub filled: usize,
    /// Smallest and largest value, in the unit of the file; none for texts and empty columns.
    pub range: Option<(f64, f64)>,
}

/// Smallest, largest and number of the values of a column.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Seen {
    pub smallest: f64,
    pub largest: f64,
    pub filled: usize,
}

impl Default for Seen {
    fn default() -> Self {
        Seen { smallest: f64::INFINITY, largest: f64::NEG_INFINITY, filled: 0 }
    }
}

impl Seen {
    #[inline]
    pub fn see(&mut self, value: f64) {
        self.smallest = self.smallest.min(value);
        self.largest = self.largest.max(value);
        self.filled += 1;
    }

    pub fn range(&self) -> Option<(f64, f64)> {
        (self.smallest <= self.largest).then_some((self.smallest, self.largest))
    }
}
