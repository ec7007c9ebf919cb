//! Lines cut into cells, and what kind of row they are.

use super::super::cells::cells;
use super::in_cells;
use super::numbers::{Marks, marks, ungrouped};

/// The cells of a line.
pub(super) fn split(line: &str, separator: char) -> Vec<String> {
    if separator == ',' {
        return cells(line.as_bytes()).map_or_else(
            |_| line.split(',').map(|cell| cell.trim().to_owned()).collect(),
            |all| all.into_iter().map(|cell| cell.into_owned()).collect(),
        );
    }
    if separator == ' ' {
        return line.split_whitespace().map(str::to_owned).collect();
    }
    let (mut all, mut cell, mut quoted) = (Vec::new(), String::new(), false);
    for c in line.chars() {
        match c {
            '"' => quoted = !quoted,
            c if c == separator && !quoted => all.push(std::mem::take(&mut cell).trim().to_owned()),
            c => cell.push(c),
        }
    }
    all.push(cell.trim().to_owned());
    all
}

/// Whether most filled cells are numbers, with a unit or without.
pub(super) fn is_row_of_numbers(cells: &[String]) -> bool {
    let is_number = |cell: &&String| {
        let bare = in_cells::parted(cell).map_or(cell.as_str(), |(number, _)| number);
        bare.parse::<f64>().is_ok() || !matches!(marks(bare), Marks::Plain) || ungrouped(bare).is_some()
    };
    let filled = || cells.iter().filter(|cell| !cell.is_empty());
    filled().count() > 0 && 2 * filled().filter(is_number).count() > filled().count()
}
