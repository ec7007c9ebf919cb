//! How a table is written, from its first lines.

use super::super::names::Names;
use super::super::spelled_units::is_unit_word;
use super::composed::incomplete;
use super::cut::{is_row_of_numbers, split};
use super::encoding::Encoding;
use super::numbers::{Marks, marks, ungrouped};
use super::{Dialect, in_cells, krl, named, skipped, spaced};

/// Lines in which a header is looked for: below a title, an operator, a date, an instrument's settings.
const SEARCHED: usize = 60;

/// Rows whose cells are looked at for units.
const CELLS: usize = 500;

/// A header has at least so many names that the robot's table knows, where there is a title above it.
const KNOWN: usize = 2;

/// The dialect of a text; none where the plain reader reads it.
pub(super) fn dialect(text: &str, encoding: Encoding, whole: bool, names: &Names<'_>) -> Option<Dialect> {
    let read = |line: &str| !skipped(line) || named::begins_with_a_number_sign(line);
    let mut lines: Vec<(usize, &str)> = text.lines().enumerate().filter(|(_, line)| read(line)).collect();
    if !whole {
        lines.pop();
    }
    let first = *lines.first()?;
    if lines.iter().take(SEARCHED).any(|(_, line)| krl::has(line)) {
        let (header, units, above, in_cells) = (0, None, Vec::new(), Vec::new());
        return Some(Dialect {
            encoding,
            separator: ' ',
            header,
            units,
            above,
            commas: false,
            in_cells,
            structures: true,
        });
    }
    let top = &lines[..lines.len().min(SEARCHED)];
    let mut best: Option<(usize, usize, char)> = None;
    for separator in [',', ';', '\t', '|'] {
        for &(at, line) in top {
            let cut = split(line, separator);
            if cut.iter().any(|cell| cell.contains('.') && cell.parse::<f64>().is_ok()) {
                // Names of joints beside their values, as `rostopic echo -p` writes them: a row.
                continue;
            }
            let known = cut.iter().filter(|cell| names.knows(cell)).count();
            if cut.len() > 1 && known >= KNOWN && best.is_none_or(|(most, ..)| known > most) {
                best = Some((known, at, separator));
            }
        }
    }
    let (mut header, separator) = match best {
        Some((_, at, separator)) => (at, separator),
        None => spaced::table(top).or_else(|| regular(top))?,
    };
    let cut = split(text.lines().nth(header)?, separator);
    if is_row_of_numbers(&cut) {
        header = named::in_a_comment(text, header, separator, cut.len()).unwrap_or(header);
    }
    if let Some((at, line)) = lines.iter().find(|(at, _)| *at > header)
        && is_row_of_units_and_names(&split(line, separator))
    {
        header = *at;
    }
    let below = lines.iter().find(|(at, _)| *at > header);
    let units = below.filter(|(_, line)| is_row_of_units(&split(line, separator))).map(|(at, _)| *at);
    let rows: Vec<Vec<String>> = lines
        .iter()
        .filter(|(at, _)| *at > header && Some(*at) != units)
        .take(CELLS)
        .map(|(_, line)| split(line, separator))
        .collect();
    let line = text.lines().nth(header)?;
    let named = named::cells(line, separator);
    let above = if incomplete(&named) { titles(&lines, header, separator, named.len()) } else { Vec::new() };
    let mut in_cells = in_cells::units(&rows, named.len());
    in_cells
        .iter_mut()
        .zip(&named)
        .filter(|(_, name)| names.is_text(name))
        .for_each(|(unit, _)| *unit = None);
    let marked = |cell: &String| cell.contains(',') && marks(cell) != Marks::Plain;
    let quoted = |line: &str| line.contains('"') && split(line, ',').iter().any(marked);
    let grouped = |line: &str| {
        line.contains(['\'', '\u{2019}', ' ', '\u{a0}', '\u{202f}'])
            && split(line, ',').iter().any(|cell| ungrouped(cell).is_some())
    };
    let commas = separator != ',' || lines.iter().any(|(_, line)| quoted(line) || grouped(line));
    let plain = encoding == Encoding::Utf8
        && separator == ','
        && header == first.0
        && !line.starts_with('#')
        && units.is_none()
        && !commas
        && in_cells.iter().all(Option::is_none);
    let structures = false;
    (!plain).then_some(Dialect { encoding, separator, header, units, above, commas, in_cells, structures })
}

/// Rows of titles directly above a header, the nearest first: without numbers, and hardly longer than the header.
fn titles(lines: &[(usize, &str)], header: usize, separator: char, count: usize) -> Vec<usize> {
    let above = lines.iter().rev().filter(|(at, _)| *at < header);
    let is_title = |cells: &[String]| {
        let filled = cells.iter().filter(|cell| !cell.is_empty()).count();
        let numbers = cells.iter().any(|cell| cell.parse::<f64>().is_ok());
        filled > 1 && !numbers && cells.len() <= count && 2 * cells.len() >= count
    };
    above.take_while(|(_, line)| is_title(&split(line, separator))).map(|(at, _)| *at).collect()
}

/// The separator that cuts most lines alike, and the first line that it cuts so; none where the comma does.
fn regular(lines: &[(usize, &str)]) -> Option<(usize, char)> {
    for separator in ['\t', ';', '|', ','] {
        let counts: Vec<usize> = lines.iter().map(|(_, line)| split(line, separator).len()).collect();
        let Some(&usual) = counts.last() else { continue };
        let alike = counts.iter().filter(|&&count| count == usual).count();
        if usual > 2 && 2 * alike > lines.len() {
            let at = counts.iter().position(|&count| count == usual)?;
            // Of several rows of names the last one stands above the numbers.
            let numbers = |&k: &usize| counts[k] == usual && is_row_of_numbers(&split(lines[k].1, separator));
            let row = (at..lines.len()).find(numbers).unwrap_or(at);
            let named = |&k: &usize| counts[k] == usual && !is_row_of_units(&split(lines[k].1, separator));
            let header = (at..row).rev().find(named).unwrap_or(at);
            return Some((lines[header].0, separator));
        }
    }
    None
}

fn is_row_of_units(cells: &[String]) -> bool {
    let filled: Vec<&String> = cells.iter().filter(|cell| !cell.is_empty()).collect();
    filled.len() >= 2 && filled.iter().all(|cell| is_unit_word(cell))
}

/// A row without numbers that has units for some columns, and names for others.
fn is_row_of_units_and_names(cells: &[String]) -> bool {
    let filled = || cells.iter().filter(|cell| !cell.is_empty());
    let units = filled().filter(|cell| is_unit_word(cell)).count();
    let numbers = filled().any(|cell| cell.parse::<f64>().is_ok() || !matches!(marks(cell), Marks::Plain));
    units > 1 && units < filled().count() && !numbers
}
