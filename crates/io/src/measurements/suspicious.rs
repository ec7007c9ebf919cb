//! Warnings about tables that are valid but implausible.

use super::columns::Cells;
use super::copies::copies;
use super::header::Needs;
use super::info::CsvInfo;
use super::plausible::rounded;
use super::row::RowReader;
use crate::{Quantity, Unit, Warning};
use std::collections::BTreeSet;
use truepose_errormodel::{Dataset, Moving};
use truepose_kinematics::{Chain, Load};

/// Positions spread over more than this many lengths of the robot are in another unit.
const TOO_FAR: f64 = 20.0;

/// What a reader has taken from a table.
pub(super) struct ReadSoFar<'a> {
    pub rows: &'a RowReader,
    /// Rows of the table so far.
    pub count: usize,
    /// The first line where time goes backwards, and how many do.
    pub backwards: Option<(u64, usize)>,
}

/// Warns; rows that are copies of others.
pub(super) fn look(
    read: &ReadSoFar<'_>,
    chain: &Chain,
    data: &Dataset,
    (needs, info): (Needs, &CsvInfo),
    warnings: &mut Vec<Warning>,
) -> Vec<usize> {
    let mut copied = Vec::new();
    let header = &read.rows.header;
    look_at_columns(read, chain, warnings);
    let at = |line, column, message| told(read, line, column, message);
    if needs.measured && data.len() >= 5 {
        unvaried(read, data, warnings);
        if let Some(k) = header.columns.iter().position(|column| column.cells == Cells::Target)
            && let Some(first) = data.target.iter().position(Option::is_none)
        {
            let count = data.target.iter().filter(|t| t.is_none()).count();
            if 3 * count < data.len() {
                let message = format!(
                    "is empty{}: the tool's origin was measured there; name the target if it was not",
                    more(count)
                );
                warnings.push(at(data.line[first], Some(k), message));
            }
        }
        let copies = copies(data);
        if let Some(&(row, of)) = copies.first() {
            let message = format!(
                "is an exact copy of line {}{} not used; a copied row is not a repeated measurement, and leads to an underestimate of the noise",
                data.line[of],
                match copies.len() {
                    1 => ": it is".into(),
                    2 => ", and another row is a copy too: they are".into(),
                    n => format!(", and {} other rows are copies too: they are", n - 1),
                }
            );
            warnings.push(at(data.line[row], None, message));
            copied = copies.into_iter().map(|(row, _)| row).collect();
        }
    }
    if let Some(grouping) = &info.grouping
        && !grouping.numbered
        && needs.joints
        && 10 * grouping.near >= data.len()
        && Moving::of(data).is_none()
    {
        let message = format!(
            "no column `visit`, and {} neighbouring rows differ by {} rad or m at most: if the robot stood still there, they are one pose \
             measurement; number the visits, or widen `--dwell-tolerance`",
            grouping.near,
            rounded(grouping.near_most)
        );
        header.warn(warnings, None, message);
    }
    if needs.measured {
        let empty = (0..data.len()).filter(|&row| {
            data.seen(row).count() == 0 && data.landmark(row).is_none() && !read.rows.lost.has(data.line[row])
        });
        let mut empty = empty.peekable();
        if let Some(&first) = empty.peek() {
            let count = empty.count();
            let message = format!("nothing was measured in this row{}; fits ignore it", more(count));
            warnings.push(at(data.line[first], None, message));
        }
    }
    copied
}

/// A warning about a row.
fn told(read: &ReadSoFar<'_>, line: u64, column: Option<usize>, message: String) -> Warning {
    let header = &read.rows.header;
    Warning {
        file: header.file.clone(),
        line: Some(line),
        column: column.map(|k| (header.columns[k].header.clone(), k + 1)),
        message,
    }
}

/// What needs no row to be remembered.
pub(super) fn look_at_columns(read: &ReadSoFar<'_>, chain: &Chain, warnings: &mut Vec<Warning>) {
    let header = &read.rows.header;
    let at = |line, column, message| told(read, line, column, message);
    if let Some((line, count)) = read.backwards {
        let message = format!("time goes backwards here{}; it counts as the order all the same", more(count));
        warnings.push(at(line, header.slots.time, message));
    }
    for (k, seen) in read.rows.seen.iter().enumerate() {
        if header.columns[k].cells == Cells::Blank && seen.filled > 0 {
            header.warn(warnings, Some(k), "has no name, and is not read");
        }
    }
    if let (Some(slots), Some((line, message))) = (header.slots.position, read.rows.lost.words()) {
        warnings.push(at(line, Some(slots[0]), message));
    }
    if let Some(slots) = &header.slots.joints {
        for (joint, &k) in slots.iter().enumerate().filter(|(joint, _)| chain.is_commanded(*joint)) {
            if let Some((line, count)) = read.rows.beyond[joint] {
                let message = format!("is beyond the joint's limits{}", more(count));
                warnings.push(at(line, Some(k), message));
            }
        }
        for (unit, larger, what) in [("deg", "rad", "radians"), ("mm", "m", "metres")] {
            // A joint that hardly moves is nothing special; all of them together are.
            let judged: Vec<(usize, bool)> = slots
                .iter()
                .enumerate()
                .filter(|&(_, &k)| header.columns[k].unit == unit)
                .filter_map(|(joint, &k)| {
                    let conversion = header.columns[k].conversion;
                    let (low, high) = read.rows.seen[k].range()?;
                    let (low, high) = (conversion.to_si(low), conversion.to_si(high));
                    Some((k, read.rows.plausible(joint).looks_too_small(low, high, unit)?))
                })
                .collect();
            if let Some(&(k, _)) = judged.first()
                && judged.iter().all(|(_, small)| *small)
                && read.count >= 5
            {
                let message = format!(
                    "all joint values in [{unit}] are so small that they look like {what}; if so, call the columns `name[{larger}]`"
                );
                header.warn(warnings, Some(k), message);
            }
        }
    }
    // A channel may have any unit; one in the unit of a joint's value is rather a joint under another name. Commanded poses are known by theirs.
    let commanded = |k: usize| header.columns[k].name.starts_with("command_");
    for &k in header.slots.channels.iter().filter(|&&k| !commanded(k)) {
        if header.proposal.has(&header.columns[k].header) {
            continue;
        }
        let unit = Unit::named(&header.columns[k].unit);
        if unit.is_some_and(|unit| matches!(unit.quantity, Quantity::Angle | Quantity::Length)) {
            let joints: Vec<&str> = chain.movable().iter().map(|&j| chain.joint(j).name.as_str()).collect();
            let message = format!(
                "is not a joint of the robot (its joints: {}) and counts as a channel",
                joints.join(", ")
            );
            header.warn(warnings, Some(k), message);
        }
    }
    if let Some(slots) = header.slots.position {
        let spread = slots
            .iter()
            .map(|&k| {
                let conversion = header.columns[k].conversion;
                read.rows.seen[k]
                    .range()
                    .map_or(0.0, |(low, high)| conversion.to_si(high) - conversion.to_si(low))
            })
            .fold(0.0, f64::hypot);
        let length = chain.characteristic_length();
        if spread > TOO_FAR * length {
            let message = format!(
                "positions spread over {} m, but the robot is about {} m long; check the unit",
                rounded(spread),
                rounded(length)
            );
            header.warn(warnings, Some(slots[0]), message);
        }
    }
}

/// Columns that should change and do not.
fn unvaried(read: &ReadSoFar<'_>, data: &Dataset, warnings: &mut Vec<Warning>) {
    let header = &read.rows.header;
    let still = |column: &[f64]| column.iter().all(|q| q.to_bits() == column[0].to_bits());
    if let Some(slots) = &header.slots.joints {
        let mut fixed: Vec<usize> =
            data.joints.iter().zip(slots).filter(|(column, _)| still(column)).map(|(_, &k)| k).collect();
        let count = fixed.len();
        // Joints that follow one another share a column.
        let mut seen = BTreeSet::new();
        fixed.retain(|k| seen.insert(*k));
        let all = count == slots.len();
        if all && count > 0 {
            let message =
                "no joint moves: all rows are one configuration, which contains no information about the arm";
            header.warn(warnings, None, message);
        } else {
            if let [k] = fixed[..] {
                header.warn(
                    warnings,
                    Some(k),
                    "never changes: the data contains no information about this joint's motion",
                );
            } else if !fixed.is_empty() {
                let names: Vec<&str> = fixed.iter().map(|&k| header.columns[k].name.as_str()).collect();
                let message = format!(
                    "{} never change: the data contains no information about the motion of these joints",
                    names.join(", ")
                );
                header.warn(warnings, None, message);
            }
            stuck(read, warnings);
        }
    }
    let unloaded =
        |load: &Load| matches!(load, Load::Payload(payload) if payload.mass.abs() < f64::MIN_POSITIVE);
    if let Some(k) = header.slots.payload
        && data.load.iter().all(unloaded)
    {
        let message = "is zero in every row: this data does not determine the compliance under a payload; if a payload was carried, declare it";
        header.warn(warnings, Some(k), message);
    }
}

/// Positions that are all the same, although the robot moves.
fn stuck(read: &ReadSoFar<'_>, warnings: &mut Vec<Warning>) {
    let Some(slots) = read.rows.header.slots.position else { return };
    let one =
        |&k: &usize| read.rows.seen[k].range().is_some_and(|(low, high)| low.to_bits() == high.to_bits());
    if read.count >= 5 && slots.iter().all(one) {
        let message = "never changes, nor do the other two, although the robot moves: the measured point does not move with the robot";
        read.rows.header.warn(warnings, Some(slots[0]), message);
    }
}

fn more(count: usize) -> String {
    match count {
        0 | 1 => String::new(),
        2 => " and in another row".into(),
        n => format!(" and in {} other rows", n - 1),
    }
}
