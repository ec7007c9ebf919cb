//! The peers' tables: a header and numbers. Reading them is not timed.

use crate::workload::Failure;
use std::path::Path;

/// Columns of numbers by name; what is no number is NaN.
pub struct Table {
    names: Vec<String>,
    columns: Vec<Vec<f64>>,
}

impl Table {
    /// Reads a file.
    pub fn read(path: &Path) -> Result<Self, Failure> {
        let text = std::fs::read_to_string(path).map_err(|error| format!("{}: {error}", path.display()))?;
        let mut lines = text.lines();
        let names: Vec<String> = lines.next().unwrap_or("").split(',').map(str::to_string).collect();
        let mut columns = vec![Vec::new(); names.len()];
        for line in lines {
            for (column, cell) in columns.iter_mut().zip(line.split(',')) {
                column.push(cell.parse().unwrap_or(f64::NAN));
            }
        }
        Ok(Table { names, columns })
    }

    /// A column.
    pub fn column(&self, name: &str) -> Result<&[f64], Failure> {
        let at = self.names.iter().position(|n| n == name).ok_or(format!("there is no column `{name}`"))?;
        Ok(&self.columns[at])
    }

    /// Whether there is one.
    pub fn has(&self, name: &str) -> bool {
        self.names.iter().any(|n| n == name)
    }

    /// Columns `name0 name1 …` or `name1 name2 …`, one after the other.
    pub fn series(&self, name: &str, numbers: std::ops::Range<usize>) -> Result<Vec<Vec<f64>>, Failure> {
        numbers.map(|k| Ok(self.column(&format!("{name}{k}"))?.to_vec())).collect()
    }

    /// Number of rows.
    pub fn rows(&self) -> usize {
        self.columns.first().map_or(0, Vec::len)
    }
}
