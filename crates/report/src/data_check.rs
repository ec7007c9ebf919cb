//! What seems wrong with measurements, before anything that a fit of them says.

use serde::{Deserialize, Serialize};
use std::fmt;

/// Suspected mistakes in the data or in the robot's description.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(default)]
pub struct DataCheck {
    /// Each with its evidence, and what to do.
    pub suspected: Vec<String>,
    /// Rows (from 1) that the fit leaves out for it.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub rows_left_out: Vec<usize>,
    /// Whether the rows that are used are in doubt as a whole: figures of a fit are then about the mistake, and not about the robot.
    pub in_doubt: bool,
}

impl DataCheck {
    /// Whether nothing is suspected.
    pub fn is_empty(&self) -> bool {
        self.suspected.is_empty()
    }

    /// The number (from 1) among all rows of a row that is one of those that are used.
    pub(crate) fn row_of_all(&self, used: usize) -> usize {
        self.rows_left_out.iter().fold(used, |row, &left_out| if left_out <= row { row + 1 } else { row })
    }

    /// Sentences that stand before any figure.
    pub(crate) fn sentences(&self) -> Vec<String> {
        let mut all: Vec<String> =
            self.suspected.iter().map(|words| format!("Check the data first: {words}.")).collect();
        match self.rows_left_out.len() {
            0 => (),
            1 => all.push("1 row is left out of all that follows.".into()),
            rows => all.push(format!("{rows} rows are left out of all that follows.")),
        }
        if self.in_doubt {
            all.push("Until that is corrected, what follows describes the mistake and not the robot.".into());
        }
        all
    }
}

impl fmt::Display for DataCheck {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if !self.is_empty() {
            writeln!(f)?;
        }
        self.sentences().iter().try_for_each(|words| writeln!(f, "{words}"))
    }
}
