//! What a reader understood of a table.

use std::path::PathBuf;

/// What was read, for `truepose check` and for logs.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct CsvInfo {
    /// The file.
    pub file: PathBuf,
    /// Every column, in the order of the file.
    pub columns: Vec<ColumnInfo>,
    /// How many rows.
    pub rows: usize,
    /// How many visits.
    pub visits: usize,
    /// How many different pairs of joint values and load.
    pub configurations: usize,
    /// The file's own number of each visit; empty when the file numbers none.
    pub visit_labels: Vec<i64>,
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
