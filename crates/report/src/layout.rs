//! Tables for a terminal.

use comfy_table::{CellAlignment, Table, presets};

/// How a column is set.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Alignment {
    /// Words.
    Left,
    /// Numbers.
    Right,
}

/// A table with a header, without a frame around it; lines carry no trailing blanks.
pub fn table(header: &[&str], alignment: &[Alignment], rows: &[Vec<String>]) -> String {
    let mut table = Table::new();
    table.load_preset(presets::NOTHING);
    table.set_header(header.iter().map(ToString::to_string).collect::<Vec<_>>());
    rows.iter().for_each(|row| {
        table.add_row(row.clone());
    });
    for (k, side) in alignment.iter().enumerate() {
        if let Some(column) = table.column_mut(k) {
            column.set_cell_alignment(match side {
                Alignment::Left => CellAlignment::Left,
                Alignment::Right => CellAlignment::Right,
            });
        }
    }
    table.to_string().lines().map(|line| format!(" {}\n", line.trim_end())).collect()
}
