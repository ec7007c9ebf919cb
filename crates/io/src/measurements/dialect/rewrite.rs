//! A table in another dialect, written anew line for line.

use super::super::cells::shown;
use super::super::names::Names;
use super::super::spelled_units::split_unit;
use super::composed::composed;
use super::cut::split;
use super::encoding::Encoding;
use super::in_cells::parted;
use super::numbers::{Marks, marks, ungrouped, with_point};
use super::{Dialect, Rewritten, named, skipped};
use crate::nearest::listed;
use crate::{IoError, Unit};
use std::path::Path;

/// Errors about numbers that are listed.
const LISTED: usize = 10;

pub(super) fn rewrite(
    dialect: &Dialect,
    file: &Path,
    text: &str,
    names: &Names<'_>,
) -> Result<Rewritten, IoError> {
    let lines: Vec<&str> = text.lines().collect();
    let mut header = named::cells(lines.get(dialect.header).copied().unwrap_or(""), dialect.separator);
    let above: Vec<Vec<String>> =
        dialect.above.iter().map(|&at| split(lines[at], dialect.separator)).collect();
    let whole = composed(&header, &above);
    let completed = whole != header;
    header = whole;
    if let Some(units) = dialect.units {
        for (name, unit) in header.iter_mut().zip(split(lines[units], dialect.separator)) {
            let none = matches!(unit.trim(), "" | "-" | "–");
            if !none && !name.contains('[') && !name.is_empty() {
                *name = format!("{name}[{}]", unit.trim_matches(['[', ']', '(', ')']));
            }
        }
    }
    let mut stripped = Vec::new();
    for (name, unit) in header.iter_mut().zip(&dialect.in_cells) {
        let Some(unit) = unit else { continue };
        let own = split_unit(name).1.and_then(Unit::named);
        if own.is_none_or(|own| Some(own) == Unit::named(unit)) {
            stripped.push(format!("{} ({unit})", shown(name)));
            if own.is_none() && !name.is_empty() {
                *name = format!("{name}[{unit}]");
            }
        }
    }
    let bare = |k: usize, cell: &str| -> Option<String> {
        let unit = dialect.in_cells.get(k)?.as_ref()?;
        let own = header.get(k).and_then(|name| split_unit(name).1).and_then(Unit::named);
        let (number, found) = parted(cell)?;
        (own == Unit::named(unit) && found == unit).then(|| number.to_owned())
    };
    let decimals = decimals(dialect, &lines, &header, names);
    let mut out = String::with_capacity(text.len() + text.len() / 8);
    let (mut errors, mut notes) = (Vec::new(), Vec::new());
    for (at, line) in lines.iter().enumerate() {
        if at == dialect.header {
            put(&mut out, &header);
        } else if at > dialect.header && Some(at) != dialect.units && !skipped(line) {
            let mut row = split(line, dialect.separator);
            while row.len() > header.len() && row.last().is_some_and(String::is_empty) {
                row.pop();
            }
            // A line of separators alone, or with a word among them: the title of what a program wrote below the rows.
            if row.iter().all(String::is_empty) || is_note(&row, header.len()) {
                if let Some(word) = row.iter().find(|cell| !cell.is_empty()) {
                    notes.push(format!("{} (`{}`)", at + 1, shown(word)));
                }
                out.push('\n');
                continue;
            }
            for (k, cell) in row.iter_mut().enumerate() {
                if let Some(number) = bare(k, cell) {
                    *cell = number;
                }
                if !dialect.commas || header.get(k).is_some_and(|name| names.is_text(name)) {
                    continue;
                }
                if let Some((whole, _)) = ungrouped(cell) {
                    *cell = whole;
                }
                match read(cell, decimals) {
                    Ok(Some(number)) => *cell = number,
                    Ok(None) => {}
                    Err(message) if errors.len() <= LISTED => errors.push(IoError::Cell {
                        file: file.into(),
                        line: at as u64 + 1,
                        name: header.get(k).map_or_else(String::new, |name| shown(name)),
                        number: k + 1,
                        message,
                    }),
                    Err(_) => {}
                }
            }
            put(&mut out, &row);
        }
        out.push('\n');
    }
    if !errors.is_empty() {
        let more = errors.len() > LISTED;
        errors.truncate(LISTED);
        return Err(IoError::several(errors, usize::from(more)));
    }
    let mut remarks = remarks(dialect, decimals, completed, &stripped);
    if !notes.is_empty() {
        remarks.push(format!(
            "lines that hold a text alone are not read: {}",
            listed(notes.iter().map(String::as_str))
        ));
    }
    Ok(Rewritten { text: out.into_bytes(), remarks, header_added: false })
}

/// Whether one cell of a row holds a text, and the others nothing.
fn is_note(row: &[String], columns: usize) -> bool {
    let mut filled = row.iter().filter(|cell| !cell.is_empty());
    let text = filled.next().is_some_and(|cell| cell.starts_with(char::is_alphabetic));
    text && filled.next().is_none() && columns > 3
}

/// What the numbers of a file show about its marks.
#[derive(Debug, Clone, Copy, Default)]
struct Decimals {
    commas: bool,
    points: bool,
    /// What separates thousands, where it is neither of them.
    groups: Option<char>,
}

fn decimals(dialect: &Dialect, lines: &[&str], header: &[String], names: &Names<'_>) -> Decimals {
    let mut seen = Decimals::default();
    if !dialect.commas {
        return seen;
    }
    for line in lines.iter().skip(dialect.header + 1).filter(|line| !skipped(line)) {
        for (cell, name) in split(line, dialect.separator).iter().zip(header) {
            if !names.is_text(name) {
                let number = parted(cell).map_or(cell.as_str(), |(number, _)| number);
                let whole = ungrouped(number);
                seen.groups = seen.groups.or(whole.as_ref().map(|(_, mark)| *mark));
                match marks(whole.as_ref().map_or(number, |(number, _)| number)) {
                    Marks::Comma => seen.commas = true,
                    Marks::Point => seen.points = true,
                    _ => {}
                }
            }
        }
    }
    seen
}

/// The number with a decimal point; none where the cell stays as it is.
fn read(cell: &str, decimals: Decimals) -> Result<Option<String>, String> {
    let two = |first: &str, second: &str, why: &str| {
        Err(format!(
            "`{}` is {first} or {second}: {why}; write the number in a form that has one reading",
            shown(cell)
        ))
    };
    let joined: String = cell.chars().filter(|c| !matches!(c, ',' | '.')).collect();
    match marks(cell) {
        Marks::Plain => Ok(None),
        Marks::Comma | Marks::Point => Ok(Some(with_point(cell))),
        Marks::CommaOrThousands if decimals.commas && !decimals.points => Ok(Some(with_point(cell))),
        Marks::PointOrThousands if !decimals.commas => Ok(Some(cell.to_owned())),
        Marks::CommaOrThousands => {
            let why = match decimals.points {
                true => "other numbers have decimal points",
                false => "no number of the file shows which",
            };
            two(&cell.replace(',', "."), &joined, why)
        }
        Marks::PointOrThousands => two(cell, &joined, "other numbers have decimal commas"),
    }
}

/// Cells as a line of CSV, without its end.
fn put(out: &mut String, cells: &[String]) {
    for (k, cell) in cells.iter().enumerate() {
        if k > 0 {
            out.push(',');
        }
        if cell.contains([',', '"', '\r']) || (k == 0 && cell.starts_with('#')) {
            out.push('"');
            out.push_str(&cell.replace('"', "\"\""));
            out.push('"');
        } else {
            out.push_str(cell);
        }
    }
}

fn remarks(dialect: &Dialect, decimals: Decimals, completed: bool, stripped: &[String]) -> Vec<String> {
    let mut read = Vec::new();
    match dialect.encoding {
        Encoding::Utf8 => {}
        Encoding::Utf16Little | Encoding::Utf16Big => read.push("text in UTF-16".to_owned()),
        Encoding::Windows1252 => read.push("text in Windows-1252 (Latin-1)".to_owned()),
    }
    match dialect.separator {
        ',' => {}
        '\t' => read.push("columns separated by tabs".to_owned()),
        ' ' => read.push("columns separated by blanks".to_owned()),
        other => read.push(format!("columns separated by `{other}`")),
    }
    if decimals.commas {
        read.push("decimal commas".to_owned());
    }
    if let Some(mark) = decimals.groups {
        let mark = if mark.is_whitespace() { "blanks".to_owned() } else { format!("`{mark}`") };
        read.push(format!("thousands separated by {mark}"));
    }
    if let Some(units) = dialect.units {
        read.push(format!("the units in line {}", units + 1));
    }
    if dialect.header > 0 {
        read.push(format!("the header in line {}", dialect.header + 1));
    }
    if completed {
        let lines: Vec<String> = dialect.above.iter().rev().map(|at| (at + 1).to_string()).collect();
        read.push(format!("names completed from line {}", lines.join(", ")));
    }
    if !stripped.is_empty() {
        read.push(format!("the units that stand in the cells of {}", stripped.join(", ")));
    }
    if read.is_empty() { Vec::new() } else { vec![format!("read with {}", read.join(", "))] }
}
