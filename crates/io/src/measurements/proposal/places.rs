//! Which columns hold measured positions, and their standard deviations.

use super::super::columns::Role;
use super::super::names::Names;
use super::super::sampled::Sample;
use super::super::spelled_units::split_unit;
use super::groups::{Group, MEASURED, coordinates};
use super::seen::{Seen, see};
use super::{Proposal, units};
use crate::{Quantity, Unit};

const XYZ: [&str; 3] = ["x", "y", "z"];

/// Groups that may be positions: with a unit of length, or without a unit.
fn places(seen: &[Seen<'_>]) -> Vec<Group> {
    let length = |k: &usize| match seen[*k].measure() {
        Some(unit) => unit.quantity == Quantity::Length,
        None => seen[*k].unit.is_none(),
    };
    let mut groups = coordinates(seen);
    groups.retain(|group| group.is_place() && group.columns.len() == 3 && group.columns.iter().all(length));
    groups
}

/// Columns `X Y Z` with units of length that nothing else in the file can be mistaken for: they are read as `x y z`.
pub(super) fn capitals(headers: &[&str], sample: &Sample, names: &Names<'_>) -> Option<[usize; 3]> {
    let seen = see(headers, sample, names);
    if seen.iter().any(|column| matches!(column.role, Some(Role::Position(_)))) {
        return None;
    }
    let groups = places(&seen);
    let [group] = &groups[..] else { return None };
    let columns = [group.columns[0], group.columns[1], group.columns[2]];
    let bare = columns.iter().zip(["X", "Y", "Z"]).all(|(&k, capital)| {
        let (name, unit) = split_unit(headers[k]);
        let length = unit.and_then(Unit::named).is_some_and(|unit| unit.quantity == Quantity::Length);
        name == capital && length
    });
    bare.then_some(columns)
}

/// Proposes columns for x y z and sx sy sz; for x y z without a unit the one that values show.
pub(super) fn propose(seen: &mut [Seen<'_>], names: &Names<'_>, all: &mut Proposal) {
    let known: Vec<usize> = (0..3)
        .filter_map(|k| seen.iter().position(|column| column.role == Some(Role::Position(k))))
        .collect();
    if known.is_empty() {
        position(seen, names, all);
    } else if known.len() == 3 && known.iter().all(|&k| seen[k].unit.is_none()) {
        let unit = units::of_places(seen, &known, names.chain);
        if let Some(unit) = unit.filter(|unit| !unit.is_si()) {
            known.iter().zip(XYZ).for_each(|(&k, name)| all.pair(&mut seen[k], name, Some(unit.word)));
        }
    }
    let spread = |column: &Seen<'_>| matches!(column.role, Some(Role::PositionSd(_)));
    if !seen.iter().any(spread) {
        let groups = coordinates(seen);
        let of_length = |k: &usize| seen[*k].measure().is_some_and(|unit| unit.quantity == Quantity::Length);
        // Without a unit they are in that of the position.
        let unit = all.unit_of("x");
        let bare = |k: &usize| unit.is_some() && seen[*k].unit.is_none();
        let mut groups = groups.iter().filter(|group| {
            group.is_spread()
                && !group.is_turn()
                && group.columns.len() == 3
                && (group.columns.iter().all(of_length) || group.columns.iter().all(bare))
        });
        if let (Some(group), None) = (groups.next(), groups.next()) {
            for (&k, name) in group.columns.iter().zip(["sx", "sy", "sz"]) {
                all.pair(&mut seen[k], name, unit);
            }
        }
    }
    if known.is_empty() && !all.pairs.iter().any(|(ours, _)| ours == "x") {
        return;
    }
    let no_cause: Vec<usize> =
        coordinates(seen).into_iter().filter(Group::is_no_cause).flat_map(|group| group.columns).collect();
    for k in no_cause {
        seen[k].free = false;
        all.no_cause.push(seen[k].header.to_owned());
    }
}

fn position(seen: &mut [Seen<'_>], names: &Names<'_>, all: &mut Proposal) {
    let mut groups = places(seen);
    groups.retain(|group| !group.is_wanted());
    if groups.len() > 1 {
        let measured: Vec<Group> = groups.iter().filter(|group| group.has(&MEASURED)).cloned().collect();
        if measured.len() == 1 {
            groups = measured;
        }
    }
    match &groups[..] {
        [group] => {
            let unit = match group.columns.iter().all(|&k| seen[k].unit.is_none()) {
                true => units::of_places(seen, &group.columns, names.chain).map(|unit| unit.word),
                false => None,
            };
            for (&k, name) in group.columns.iter().zip(XYZ) {
                all.pair(&mut seen[k], name, unit);
            }
        }
        [] => {}
        several => {
            let firsts: Vec<String> =
                several.iter().map(|group| format!("`{}` …", seen[group.columns[0]].header)).collect();
            let first: Vec<&str> = several[0].columns.iter().map(|&k| seen[k].header).collect();
            all.notes.push(format!(
                "several columns may be the measured position: {}; choose with --map, as in --map \"x={}\" --map \"y={}\" --map \"z={}\"",
                firsts.join(", "), first[0], first[1], first[2]
            ));
        }
    }
}
