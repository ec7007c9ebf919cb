//! Everything that is wrong with the rows of a table, in the order of the file, up to a number of errors.

use crate::IoError;
use std::collections::HashMap;

/// Errors that are listed, and of those the most in one column: the tenth cell with the same fault helps nobody.
const LISTED: usize = 20;
const LISTED_IN_COLUMN: usize = 3;
/// Errors that are counted; a table with more is another kind of table.
const COUNTED: usize = 1000;

/// Errors of rows.
#[derive(Default)]
pub(super) struct Problems {
    listed: Vec<IoError>,
    in_column: HashMap<usize, usize>,
    more: usize,
}

impl Problems {
    pub fn add(&mut self, error: IoError) {
        // Columns count from 1; 0 stands for rows as a whole.
        let place = match error {
            IoError::Cell { number, .. } => Some(number),
            IoError::Line { .. } => Some(0),
            _ => None,
        };
        if let Some(place) = place {
            let count = self.in_column.entry(place).or_default();
            *count += 1;
            if *count > LISTED_IN_COLUMN {
                self.more += 1;
                return;
            }
        }
        if self.listed.len() < LISTED {
            self.listed.push(error);
        } else {
            self.more += 1;
        }
    }

    /// Whether reading on would help nobody.
    pub fn enough(&self) -> bool {
        self.listed.len() + self.more >= COUNTED
    }

    pub fn into_error(self) -> IoError {
        IoError::several(self.listed, self.more)
    }
}
