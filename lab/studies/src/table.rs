//! Tables in Markdown, and tables whose columns have fixed widths.

use std::fmt::Display;

/// A table that grows row by row.
pub struct Table {
    /// Width of each column, negative where it begins at the left; none is Markdown.
    widths: Option<Vec<i32>>,
    text: String,
    rows: usize,
}

impl Table {
    /// In Markdown, with these heads.
    pub fn markdown(heads: &[&str]) -> Self {
        let mut table = Table { widths: None, text: String::new(), rows: 0 };
        table.line(heads);
        table.line(&vec!["---"; heads.len()]);
        table
    }

    /// With these heads and widths; a column with a negative width begins at the left.
    pub fn columns(heads: &[(&str, i32)]) -> Self {
        let widths = heads.iter().map(|(_, width)| *width).collect();
        let mut table = Table { widths: Some(widths), text: String::new(), rows: 0 };
        table.line(&heads.iter().map(|(head, _)| *head).collect::<Vec<_>>());
        table
    }

    fn line<T: Display>(&mut self, cells: &[T]) {
        let cells: Vec<String> = cells.iter().map(ToString::to_string).collect();
        let padded = |(cell, width): (&String, &i32)| match usize::try_from(*width) {
            Ok(width) => format!("{cell:>width$}"),
            Err(_) => format!("{cell:<width$}", width = width.unsigned_abs() as usize),
        };
        self.text += &match &self.widths {
            Some(widths) => cells.iter().zip(widths).map(padded).collect::<Vec<_>>().join(" "),
            None => format!("| {} |", cells.join(" | ")),
        };
        self.text.push('\n');
    }

    /// Adds a row.
    pub fn row(&mut self, cells: &[&dyn Display]) {
        self.line(cells);
        self.rows += 1;
    }

    /// The last line.
    pub fn last(&self) -> &str {
        self.text.lines().last().unwrap_or_default()
    }

    /// The text.
    pub fn text(self) -> String {
        self.text
    }

    /// The text; nothing where there are no rows.
    pub fn text_of_rows(self) -> String {
        if self.rows > 0 { self.text } else { String::new() }
    }
}

/// `part/all`.
pub fn part_of(part: usize, all: usize) -> String {
    format!("{part}/{all}")
}

/// With so many digits behind the point.
pub fn fixed(value: f64, digits: usize) -> String {
    format!("{value:.digits$}")
}
