//! Which columns hold the time, the name of a row, a target; and columns that cannot be read as numbers.

use super::super::clock;
use super::super::columns::Role;
use super::super::names::Names;
use super::Proposal;
use super::seen::Seen;
use crate::Quantity;
use std::collections::HashSet;
use truepose_kinematics::Chain;

/// Units of the time from 1970, and what numbers are below for some centuries.
const LATEST: [(f64, &str); 4] = [(1e10, "s"), (1e13, "ms"), (1e16, "us"), (1e19, "ns")];

/// Proposes `time`, `id` and `target`, and leaves out what is neither number nor text.
pub(super) fn propose(seen: &mut [Seen<'_>], names: &Names<'_>, all: &mut Proposal) {
    let has = |seen: &[Seen<'_>], role: Role| seen.iter().any(|column| column.role == Some(role));
    if !has(seen, Role::Time) {
        time(seen, all);
    }
    if !has(seen, Role::Target) {
        target(seen, names.chain, all);
    }
    if !has(seen, Role::Id) {
        let words = [
            "name",
            "id",
            "pose",
            "punkt",
            "point",
            "pr",
            "nr",
            "no",
            "n",
            "num",
            "label",
            "frame",
            "target",
            "meas",
            "measurement",
            "messung",
            "index",
            "row",
            "zeile",
            "sample",
            "count",
        ];
        let names = seen.iter().position(|column| column.free && column.has(&words) && distinct(column));
        if let Some(k) = names {
            all.pair(&mut seen[k], "id", None);
        }
    }
    matrix(seen, all);
    let axes = |column: &&Seen<'_>| {
        let one = |cell: &&&str| matches!(&*cell.to_lowercase(), "x" | "y" | "z");
        column.free && column.cells.len() > 2 && column.cells.iter().all(|cell| one(&cell))
    };
    if let Some(column) = seen.iter().find(axes) {
        all.notes.push(format!(
            "`{}` names coordinates, with a row for each: write x, y and z of a point into columns of one row",
            column.header
        ));
    }
    for column in seen.iter_mut().filter(|column| column.free && !column.cells.is_empty()) {
        let texts = column.cells.iter().filter(|cell| is_text(cell)).count();
        let numbers = column.cells.iter().filter(|cell| cell.parse::<f64>().is_ok()).count();
        let empty = column.cells.iter().filter(|cell| cell.is_empty()).count();
        if numbers > 0 && (texts > 0 || empty > 0) {
            column.free = false;
            all.ignore.push(column.header.to_owned());
        }
    }
}

/// Nine columns `r11` … `r33` of a rotation matrix, which is not read, and no cause of errors either.
fn matrix(seen: &mut [Seen<'_>], all: &mut Proposal) {
    let place = |column: &Seen<'_>| match &column.words[..] {
        [letter, number] => {
            let lettered = ["r", "m", "t"].contains(&letter.as_str());
            column.free && lettered && number.len() == 2 && number.bytes().all(|b| matches!(b, b'1'..=b'3'))
        }
        _ => false,
    };
    let nine: Vec<usize> = (0..seen.len()).filter(|&k| place(&seen[k])).collect();
    if nine.len() == 9 {
        for k in nine {
            seen[k].free = false;
            all.no_cause.push(seen[k].header.to_owned());
        }
        all.notes.push("rotation matrices are not read: give orientations as quaternions or angles".into());
    }
}

fn is_text(cell: &str) -> bool {
    !cell.is_empty() && cell.parse::<f64>().is_err()
}

/// Whether the cells are texts or whole numbers, all of them different.
fn distinct(column: &Seen<'_>) -> bool {
    let named = |cell: &&str| is_text(cell) && !dated(cell);
    let cells = || column.cells.iter().filter(|cell| !cell.is_empty());
    let different: HashSet<&&str> = cells().collect();
    let texts = cells().count() > 1 && cells().all(named);
    let counted = cells().count() > 1 && cells().all(|cell| cell.parse::<i64>().is_ok());
    // Repeats of a pose bear its name again.
    (texts || (counted && column.unit.is_none())) && 2 * different.len() > cells().count()
}

fn dated(cell: &str) -> bool {
    !matches!(clock::seconds(cell), Ok(None))
}

fn time(seen: &mut [Seen<'_>], all: &mut Proposal) {
    let words = ["time", "timestamp", "zeit", "uhrzeit", "zeitstempel", "datetime", "heure"];
    let dates = ["date", "datum"];
    let cells = |column: &Seen<'_>| column.cells.iter().filter(|cell| !cell.is_empty()).count();
    let clocks = |column: &Seen<'_>| {
        cells(column) > 0 && column.cells.iter().filter(|cell| !cell.is_empty()).all(|cell| dated(cell))
    };
    let counted = |column: &Seen<'_>| match column.measure() {
        Some(unit) => (unit.quantity == Quantity::Time).then_some(unit.word),
        None if column.unit.is_some() => None,
        None => column.range().and_then(|(_, high)| LATEST.iter().find(|of| high < of.0)).map(|of| of.1),
    };
    let fits = |column: &Seen<'_>| {
        column.free && column.has(&words) && (clocks(column) || counted(column).is_some())
    };
    let mut these = seen.iter().enumerate().filter(|(_, column)| fits(column));
    let (Some((k, _)), None) = (these.next(), these.next()) else { return };
    drop(these);
    // A clock time beside a date: one day, or it goes backwards at midnight.
    let bare = seen[k]
        .cells
        .iter()
        .any(|cell| cell.contains(':') && !cell.contains(['-', '/', 'T']) && cell.len() < 13);
    let date = seen.iter().find(|column| column.free && column.has(&dates) && clocks(column));
    let days: Option<HashSet<&&str>> = date.map(|column| column.cells.iter().collect());
    if let (true, Some(date), Some(days)) = (bare, date, days)
        && days.len() > 1
    {
        all.notes.push(format!(
            "`{}` and `{}` are date and clock time of several days: join them in one column `time`",
            date.header, seen[k].header
        ));
        return;
    }
    let unit = if clocks(&seen[k]) { None } else { counted(&seen[k]) };
    all.pair(&mut seen[k], "time", unit);
}

/// A text of few different values: names of the robot's targets, or called so.
fn target(seen: &mut [Seen<'_>], chain: &Chain, all: &mut Proposal) {
    let words = ["target", "smr", "point", "reflector", "reflektor", "ziel", "messpunkt", "prism"];
    let known = |cell: &str| chain.targets().iter().any(|target| target.name == cell);
    let fits = |column: &Seen<'_>| {
        let cells: Vec<&&str> = column.cells.iter().filter(|cell| !cell.is_empty()).collect();
        let different: HashSet<&&&str> = cells.iter().collect();
        let few = (2..=12).contains(&different.len()) && 2 * different.len() <= cells.len();
        let texts = cells.iter().all(|cell| is_text(cell) && !dated(cell));
        column.free
            && !cells.is_empty()
            && texts
            && (cells.iter().all(|cell| known(cell)) || (few && column.has(&words)))
    };
    let mut these = (0..seen.len()).filter(|&k| fits(&seen[k]));
    let (Some(k), None) = (these.next(), these.next()) else { return };
    let mut values: Vec<&str> = seen[k].cells.clone();
    values.sort_unstable();
    values.dedup();
    let new: Vec<&str> = values.into_iter().filter(|cell| !cell.is_empty() && !known(cell)).collect();
    if !new.is_empty() {
        all.targets = new.into_iter().map(str::to_owned).collect();
    }
    all.pair(&mut seen[k], "target", None);
}
