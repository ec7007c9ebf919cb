//! The cells of a sheet, and the lines that they become. What they take is bounded before it is allocated.

use super::dialect::LARGEST;
use std::ops::Range;

/// Cells that are not empty.
#[derive(Debug, Default)]
pub(super) struct Sheet {
    cells: Vec<Cell>,
    /// Their texts, one behind the other.
    texts: String,
}

/// A cell, by row and column from zero on, and where its text begins and ends.
#[derive(Debug, Clone, Copy)]
struct Cell {
    row: u32,
    column: u32,
    text: (u32, u32),
}

/// Rows and columns that a sheet has at most: XFD1048576 is its last cell.
const ROWS: u32 = 1 << 20;
const COLUMNS: u32 = 1 << 14;

/// Bytes that a cell takes beside its text.
const OF_A_CELL: u64 = size_of::<Cell>() as u64;

impl Sheet {
    /// Adds a cell; an empty one is none.
    ///
    /// # Errors
    /// When it is outside of any sheet, or the cells would not fit.
    pub fn add(&mut self, (row, column): (u32, u32), text: &str) -> Result<(), String> {
        if text.is_empty() {
            return Ok(());
        }
        if row >= ROWS || column >= COLUMNS {
            return Err(format!(
                "has a cell in row {}, column {}; a sheet ends at row {ROWS}, column {COLUMNS}",
                u64::from(row) + 1,
                u64::from(column) + 1
            ));
        }
        let start = self.texts.len() as u64;
        let end = start + text.len() as u64;
        let (Ok(start), Ok(end)) = (u32::try_from(start), u32::try_from(end)) else {
            return Err(too_large());
        };
        if u64::from(end) + OF_A_CELL * (self.cells.len() as u64 + 1) > LARGEST {
            return Err(too_large());
        }
        self.texts.push_str(text);
        self.cells.push(Cell { row, column, text: (start, end) });
        Ok(())
    }

    /// The most cells of one row of which this is true.
    pub fn known(&mut self, is: impl Fn(&str) -> bool) -> usize {
        self.sort();
        let in_row = |row: &[Cell]| row.iter().filter(|cell| is(self.text_of(cell))).count();
        self.cells.chunk_by(|a, b| a.row == b.row).map(in_row).max().unwrap_or(0)
    }

    /// One line for each row, from the first column with a cell to the last.
    ///
    /// # Errors
    /// When they are too long.
    pub fn text(mut self) -> Result<String, String> {
        self.sort();
        let columns = self.cells.iter().map(|cell| cell.column);
        let first = columns.clone().min().unwrap_or(0);
        let width = columns.max().map_or(0, |last| last - first + 1);
        let rows = || self.cells.chunk_by(|a, b| a.row == b.row);
        let separators = rows().count() as u64 * u64::from(width);
        let end = self.cells.last().map_or(0, |cell| u64::from(cell.row) + 1);
        if self.texts.len() as u64 + separators + end > LARGEST {
            return Err(too_large());
        }
        let mut text = String::new();
        let mut line = 0;
        for row in rows() {
            (line..row[0].row).for_each(|_| text.push('\n'));
            self.put(&mut text, row, first..first + width);
            line = row[0].row + 1;
        }
        Ok(text)
    }

    fn put(&self, text: &mut String, row: &[Cell], columns: Range<u32>) {
        let mut cells = row.iter().peekable();
        for column in columns.clone() {
            if column > columns.start {
                text.push(',');
            }
            let Some(cell) = cells.next_if(|cell| cell.column == column) else { continue };
            let cell = self.text_of(cell);
            if cell.contains([',', '"']) {
                text.push('"');
                text.push_str(&cell.replace('"', "\"\""));
                text.push('"');
            } else {
                text.push_str(cell);
            }
        }
        text.push('\n');
    }

    fn text_of(&self, cell: &Cell) -> &str {
        &self.texts[cell.text.0 as usize..cell.text.1 as usize]
    }

    /// By rows and columns; of two cells at one place the later one stays.
    fn sort(&mut self) {
        let place = |cell: &Cell| (cell.row, cell.column);
        if !self.cells.is_sorted_by(|a, b| place(a) < place(b)) {
            self.cells.reverse();
            self.cells.sort_by_key(place);
            self.cells.dedup_by_key(|cell| place(cell));
        }
    }
}

/// What is said of a sheet that is too large.
fn too_large() -> String {
    format!("has a sheet of more than {} MiB; save the rows of the measurements alone, as CSV", LARGEST >> 20)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(cells: &[(u32, u32, &str)]) -> Result<String, String> {
        let mut sheet = Sheet::default();
        cells.iter().try_for_each(|&(row, column, text)| sheet.add((row, column), text))?;
        sheet.text()
    }

    #[test]
    fn rows_are_lines_from_the_first_column_on() {
        assert_eq!(of(&[(1, 2, "a"), (1, 4, "b,\"c"), (3, 3, "d")]).unwrap(), "\na,,\"b,\"\"c\"\n\n,d,\n");
        assert_eq!(of(&[(1, 0, "b"), (0, 0, "a"), (1, 0, "c")]).unwrap(), "a\nc\n");
        assert_eq!(of(&[]).unwrap(), "");
    }

    #[test]
    fn the_last_cell_of_a_sheet_makes_no_rectangle_and_none_is_behind_it() {
        let far = of(&[(0, 0, "a"), (ROWS - 1, COLUMNS - 1, "b")]).unwrap();
        assert_eq!(far.len() as u32, 2 * (COLUMNS - 1) + ROWS + 2);
        assert!(of(&[(ROWS, 0, "a")]).unwrap_err().contains("row 1048577"));
        assert!(of(&[(0, COLUMNS, "a")]).unwrap_err().contains("column 16385"));
    }

    #[test]
    fn full_columns_that_are_far_apart_are_refused_before_they_are_lines() {
        let mut sheet = Sheet::default();
        for row in 0..40_000 {
            sheet.add((row, if row == 0 { COLUMNS - 1 } else { 0 }), "1").unwrap();
        }
        assert!(sheet.text().unwrap_err().starts_with("has a sheet of more than 512 MiB"));
    }
}
