//! Tables in Markdown, and tables whose columns have fixed widths.

use std::fmt::Display;

/// A table that grows row by row.
pub struct Table {
    /// Width of each column, negative where it begins at the left; none is Markdown.
    widths: Option<Vec<i32>>,
    text: String,
}

impl Table {
    /// In Markdown, with heads separated by bars.
    pub fn markdown(heads: &str) -> Self {
        let heads: Vec<&str> = heads.split('|').collect();
        let mut table = Table { widths: None, text: String::new() };
        table.line(&heads);
        table.line(&vec!["---"; heads.len()]);
        table
    }

    /// With heads and widths, `robot -8|plant 6`; a column with a negative width begins at the left.
    pub fn columns(layout: &str) -> Self {
        let columns = layout.split('|').map(|column| column.rsplit_once(' ').unwrap_or((column, "0")));
        let (heads, widths): (Vec<&str>, Vec<&str>) = columns.unzip();
        let widths = widths.iter().map(|width| width.parse().unwrap_or(0)).collect();
        let mut table = Table { widths: Some(widths), text: String::new() };
        table.line(&heads);
        table
    }

    fn line<T: Display>(&mut self, cells: &[T]) {
        let cells: Vec<String> = cells.iter().map(ToString::to_string).collect();
        let padded = |(cell, width): (&String, &i32)| match usize::try_from(*width) {
            Ok(width) => format!("{cell:>width$}"),
            Err(_) => format!("{cell:<width$}", width = width.unsigned_abs() as usize),
        };
        let columns = self.widths.as_ref().map_or(cells.len(), Vec::len);
        debug_assert!(cells.len() <= columns, "{} cells in {columns} columns: {cells:?}", cells.len());
        self.text += &match &self.widths {
            Some(widths) => cells.iter().zip(widths).map(padded).collect::<Vec<_>>().join(" "),
            None => format!("| {} |", cells.join(" | ")),
        };
        self.text.push('\n');
    }

    /// Adds a row of texts.
    pub fn cells(&mut self, cells: &[String]) {
        self.line(cells);
    }

    /// Adds a row.
    pub fn row(&mut self, cells: &[&dyn Display]) {
        self.line(cells);
    }

    /// The last line.
    pub fn last(&self) -> &str {
        self.text.lines().last().unwrap_or_default()
    }

    /// The text.
    pub fn text(self) -> String {
        self.text
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
