//! The first rows of a table, which show what its columns hold.

use super::cells::{cells, number};
use super::clock;
use super::columns::{Cells, Column, Role};
use super::names::{Named, Names};
use super::spelled_units::{split_unit, unit_in_words};

/// Rows that are looked at.
const ROWS: usize = 200;

/// Cells of the first rows.
#[derive(Debug, Default)]
pub(crate) struct Sample(Vec<Vec<String>>);

impl Sample {
    /// Of a text that begins like this, its header included.
    pub fn of(head: &[u8], whole: bool) -> Sample {
        let text = String::from_utf8_lossy(head);
        let mut lines: Vec<&str> =
            text.lines().filter(|line| !super::dialect::skipped(line)).take(ROWS + 2).collect();
        if !whole && lines.len() < ROWS + 2 {
            lines.pop();
        }
        let cut = |line: &&str| Some(cells(line.as_bytes()).ok()?.into_iter().map(String::from).collect());
        Sample(lines.iter().skip(1).filter_map(cut).collect())
    }

    /// A column from its header, with a warning.
    ///
    /// # Errors
    /// What is wrong with the header, and what to do.
    pub fn column(
        &self,
        k: usize,
        header: &str,
        names: &Names<'_>,
        channels: usize,
    ) -> Result<(Column, Option<String>), String> {
        if header.is_empty() && !self.0.is_empty() && self.filled(k).next().is_none() {
            return Ok((Column::unread(header, Cells::Blank), None));
        }
        if header.is_empty() && !self.0.is_empty() {
            let message = "has no name, and is not read".to_owned();
            return Ok((Column::unread(header, Cells::Note), Some(message)));
        }
        let ours = match names.resolve(header) {
            Named::Ignored => return Ok((Column::unread(header, Cells::Note), None)),
            Named::Header(ours) => ours,
        };
        let role = names.oriented(split_unit(&ours).0);
        let (mut column, mut warning) = Column::named(header, &ours, (names.chain, role), channels)?;
        // Of a longer table these are the first rows alone: there a channel may begin later, and a value of a sensor.
        let all = (1..ROWS).contains(&self.0.len());
        if matches!(column.role, Role::Channel(_)) && all && self.filled(k).next().is_none() {
            let message = "is empty, and is not read".to_owned();
            return Ok((Column::unread(header, Cells::Note), Some(message)));
        }
        if matches!(column.role, Role::Channel(_)) && !column.unit_given && self.holds_text(k) {
            let message = "holds text, and is not read".to_owned();
            return Ok((Column::unread(header, Cells::Note), Some(message)));
        }
        if split_unit(header).1.is_none()
            && column.unit_given
            && unit_in_words(header).is_some_and(|unit| unit == column.unit)
        {
            warning = Some(format!("is read in [{}], as its header says", column.unit));
        }
        if column.role == Role::Time
            && self.filled(k).all(|cell| matches!(clock::seconds(cell), Ok(Some(_)) | Err(_)))
        {
            // Dates and clock times need no unit.
            if self.filled(k).next().is_some() {
                warning = Some("holds dates or clock times, and is read in seconds".to_owned());
                column.unit_given = true;
            }
        }
        Ok((column, warning))
    }

    /// The cells of a column, one of each row.
    pub fn cells(&self, k: usize) -> impl Iterator<Item = &str> {
        self.0.iter().map(move |row| row.get(k).map_or("", String::as_str))
    }

    /// What is in the cells of a column.
    fn filled(&self, k: usize) -> impl Iterator<Item = &str> {
        self.0.iter().filter_map(move |row| row.get(k)).map(String::as_str).filter(|cell| !cell.is_empty())
    }

    /// Whether no cell of a column is, or was meant as, a number.
    fn holds_text(&self, k: usize) -> bool {
        let text = |cell: &str| {
            let dated = !matches!(clock::seconds(cell), Ok(None));
            let worded = cell.starts_with(char::is_alphabetic) && !unmeasured(cell);
            number(cell).is_err() && (dated || worded)
        };
        self.filled(k).next().is_some() && self.filled(k).all(|cell| text(cell) || cell == "-")
    }
}

/// Words for a number that is none.
fn unmeasured(cell: &str) -> bool {
    let cell = cell.to_lowercase();
    matches!(&*cell, "nan" | "inf" | "infinity" | "na" | "n/a" | "null" | "none")
}
