//! How a table is written, from its first lines.

use super::super::cells::cells;
use super::super::names::{Names, is_unit_word};
use super::encoding::Encoding;
use super::numbers::{Marks, marks};
use super::{Dialect, skipped};

/// Lines in which a header is looked for: below a title, an operator, a date, an instrument's settings.
const SEARCHED: usize = 60;

/// A header has at least so many names that the robot's table knows, where there is a title above it.
const KNOWN: usize = 2;

/// The dialect of a text; none where the plain reader reads it.
pub(super) fn dialect(text: &str, encoding: Encoding, whole: bool, names: &Names<'_>) -> Option<Dialect> {
    let mut lines: Vec<(usize, &str)> = text.lines().enumerate().filter(|(_, line)| !skipped(line)).collect();
    if !whole {
        lines.pop();
    }
    let first = *lines.first()?;
    let top = &lines[..lines.len().min(SEARCHED)];
    let mut best: Option<(usize, usize, char)> = None;
    for separator in [',', ';', '\t', '|'] {
        for &(at, line) in top {
            let cut = split(line, separator);
            let known = cut.iter().filter(|cell| names.knows(cell)).count();
            if cut.len() > 1 && known >= KNOWN && best.is_none_or(|(most, ..)| known > most) {
                best = Some((known, at, separator));
            }
        }
    }
    let (header, separator) = match best {
        Some((_, at, separator)) => (at, separator),
        None => regular(top)?,
    };
    let below = lines.iter().find(|(at, _)| *at > header);
    let units = below.filter(|(_, line)| is_row_of_units(&split(line, separator))).map(|(at, _)| *at);
    let quoted = |line: &str| line.contains('"') && split(line, ',').iter().any(|c| marks(c) == Marks::Comma);
    let commas = separator != ',' || lines.iter().any(|(_, line)| quoted(line));
    let plain =
        encoding == Encoding::Utf8 && separator == ',' && header == first.0 && units.is_none() && !commas;
    (!plain).then_some(Dialect { encoding, separator, header, units, commas })
}

/// The separator that cuts most lines alike, and the first line that it cuts so; none where the comma does.
fn regular(lines: &[(usize, &str)]) -> Option<(usize, char)> {
    for separator in ['\t', ';', '|', ','] {
        let counts: Vec<usize> = lines.iter().map(|(_, line)| split(line, separator).len()).collect();
        let Some(&usual) = counts.last() else { continue };
        let alike = counts.iter().filter(|&&count| count == usual).count();
        if usual > 2 && 2 * alike > lines.len() {
            let at = counts.iter().position(|&count| count == usual)?;
            // A title with as many separators by chance has numbers nowhere; neither has a header.
            return Some((lines[at].0, separator));
        }
    }
    None
}

fn is_row_of_units(cells: &[String]) -> bool {
    let filled: Vec<&String> = cells.iter().filter(|cell| !cell.is_empty()).collect();
    filled.len() >= 2 && filled.iter().all(|cell| is_unit_word(cell))
}

/// The cells of a line.
pub(super) fn split(line: &str, separator: char) -> Vec<String> {
    if separator == ',' {
        return cells(line.as_bytes()).map_or_else(
            |_| line.split(',').map(|cell| cell.trim().to_owned()).collect(),
            |all| all.into_iter().map(|cell| cell.into_owned()).collect(),
        );
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
