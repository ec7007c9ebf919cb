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
    /// Each with the number of further rows that have the same fault in the same column.
    listed: Vec<(IoError, usize)>,
    /// Where the fault of a column stands in the list.
    facts: HashMap<(usize, String), usize>,
    in_column: HashMap<usize, usize>,
    more: usize,
    count: usize,
}

/// A message without its numbers: the same fault of another cell.
fn fact(message: &str) -> String {
    let word = |word: &str| {
        if word.trim_matches([',', ';', ':']).parse::<f64>().is_ok() { "#" } else { word }.to_owned()
    };
    message.split([' ', '`']).map(word).collect::<Vec<_>>().join(" ")
}

impl Problems {
    pub fn add(&mut self, error: IoError) {
        self.count += 1;
        // Columns count from 1; 0 stands for rows as a whole.
        let place = match &error {
            IoError::Cell { number, message, .. } => Some((*number, fact(message))),
            IoError::Line { message, .. } => Some((0, fact(message))),
            _ => None,
        };
        if let Some(place) = &place {
            if let Some(&known) = self.facts.get(place) {
                self.listed[known].1 += 1;
                return;
            }
            let count = self.in_column.entry(place.0).or_default();
            *count += 1;
            if *count > LISTED_IN_COLUMN {
                self.more += 1;
                return;
            }
        }
        if self.listed.len() < LISTED {
            self.facts.extend(place.map(|place| (place, self.listed.len())));
            self.listed.push((error, 0));
        } else {
            self.more += 1;
        }
    }

    /// Whether reading on would help nobody.
    pub fn enough(&self) -> bool {
        self.count >= COUNTED
    }

    /// As one error; with a last one where there is something else to say.
    pub fn into_error(self, last: Option<IoError>) -> IoError {
        let told = |(mut error, others): (IoError, usize)| {
            if let (IoError::Cell { message, .. } | IoError::Line { message, .. }, 1..) = (&mut error, others)
            {
                let rows =
                    if others == 1 { "another row".to_owned() } else { format!("{others} other rows") };
                message.push_str(&format!("; the same in {rows}"));
            }
            error
        };
        let listed = self.listed.into_iter().map(told);
        IoError::several(listed.chain(last).collect(), self.more)
    }
}
