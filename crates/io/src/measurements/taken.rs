//! Rows whose cells stand in columns: Parquet, and tables in memory.

use super::cells::number;
use super::columns::Cells;
use super::row::RowReader;
use crate::IoError;

/// A cell of a column.
pub(crate) enum Cell<'a> {
    Empty,
    Number(f64),
    Text(&'a [u8]),
}

impl RowReader {
    /// Takes a row whose cells stand in columns.
    pub fn take<'c>(&mut self, line: u64, cell: impl Fn(usize) -> Cell<'c>) -> Result<(), IoError> {
        let taken = self.take_cells(line, cell);
        self.failed = taken.is_err();
        taken
    }

    fn take_cells<'c>(&mut self, line: u64, cell: impl Fn(usize) -> Cell<'c>) -> Result<(), IoError> {
        if !self.begin(line) {
            return Ok(());
        }
        for k in 0..self.kinds.len() {
            let cells = self.kinds[k].0;
            if matches!(cells, Cells::Note | Cells::Blank) {
                continue;
            }
            let raw = match (cells, cell(k)) {
                (Cells::Target, Cell::Number(value)) => {
                    let message = format!("a target has a name, and not a number ({value})");
                    return Err(self.header.cell_error(line, k, message));
                }
                (Cells::Use, Cell::Number(value)) => {
                    self.use_row(line, k, if value.abs() < f64::MIN_POSITIVE { "0" } else { "1" })?;
                    continue;
                }
                (Cells::Id, Cell::Number(value)) => {
                    self.take_id(k, &value.to_string());
                    continue;
                }
                (
                    Cells::Session | Cells::Kind | Cells::Landmark | Cells::Point | Cells::Tool,
                    Cell::Number(value),
                ) => {
                    self.take_word(line, k, &value.to_string());
                    continue;
                }
                (_, Cell::Number(value)) if value.is_finite() => Some(value),
                (_, Cell::Number(_)) => {
                    let message = "is not a finite number; leave the cell empty if nothing was measured";
                    return Err(self.header.cell_error(line, k, message));
                }
                (_, Cell::Text(text)) => {
                    let text = String::from_utf8_lossy(text);
                    let text = text.trim();
                    if cells == Cells::Id {
                        self.take_id(k, text);
                        continue;
                    }
                    if matches!(
                        cells,
                        Cells::Session | Cells::Kind | Cells::Landmark | Cells::Point | Cells::Tool
                    ) {
                        self.take_word(line, k, text);
                        continue;
                    }
                    if cells == Cells::Target {
                        self.row.target =
                            self.target(text).map_err(|message| self.header.cell_error(line, k, message))?;
                        self.seen[k].filled += usize::from(self.row.target.is_some());
                        continue;
                    }
                    number(text).map_err(|message| self.header.cell_error(line, k, message))?
                }
                (_, Cell::Empty) => None,
            };
            match raw {
                Some(raw) => self.put(line, k, raw)?,
                None if matches!(cells, Cells::Kind | Cells::Landmark | Cells::Point | Cells::Tool) => {}
                None if matches!(cells, Cells::Maybe | Cells::Target | Cells::Id) => {
                    self.numbers[k] = f64::NAN
                }
                None => return Err(self.empty(line, k)),
            }
        }
        self.judge()
    }
}
