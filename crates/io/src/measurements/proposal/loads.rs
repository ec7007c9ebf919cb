//! Which columns hold what is carried: its mass and its centre of gravity.

use super::super::columns::Role;
use super::super::names::Names;
use super::super::sampled::Sample;
use super::super::scalars::SCALARS;
use super::super::spelled_units::split_unit;
use super::Proposal;
use super::seen::{Seen, see};
use crate::Quantity;

/// What people call a mass that is carried.
const CARRIED: [&str; 17] = [
    "payload", "load", "last", "nutzlast", "traglast", "zuladung", "masse", "gewicht", "mass", "weight",
    "charge", "poids", "carico", "peso", "carga", "massa", "lading",
];

/// What people call a centre of gravity.
const CENTRE: [&str; 7] = ["com", "cog", "cg", "schwerpunkt", "cdg", "centroid", "barycentre"];

/// No arm carries more, kg.
const HEAVIEST: f64 = 5000.0;

/// The only column of a file whose unit is one of mass, where nothing of it has a meaning of its own: the payload.
pub(super) fn carried(headers: &[&str], sample: &Sample, names: &Names<'_>) -> Option<usize> {
    let seen = see(headers, sample, names);
    if seen.iter().any(is_load) {
        return None;
    }
    // A measured number in a wrong unit is no mass.
    let measured = |column: &Seen<'_>| SCALARS.contains(&split_unit(column.header).0);
    let mut masses =
        seen.iter().enumerate().filter(|(_, column)| column.free && weighs(column) && !measured(column));
    let (k, _) = masses.next()?;
    masses.next().is_none().then_some(k)
}

/// Proposes `payload` for the only column that may be one, and `cx cy cz` for those of a centre of gravity.
pub(super) fn propose(seen: &mut [Seen<'_>], all: &mut Proposal) {
    if !seen.iter().any(is_load) {
        let called =
            |column: &Seen<'_>| column.unit.is_none() && column.has(&CARRIED) && !column.has(&CENTRE);
        let fits = |column: &Seen<'_>| {
            let possible = column.range().is_some_and(|(low, high)| low >= 0.0 && high <= HEAVIEST);
            column.free && possible && (weighs(column) || called(column))
        };
        let mut these = (0..seen.len()).filter(|&k| fits(&seen[k]));
        if let (Some(k), None) = (these.next(), these.next()) {
            all.pair(&mut seen[k], "payload", Some("kg"));
        }
    }
    if seen.iter().any(|column| matches!(column.role, Some(Role::PayloadCentre(_)))) {
        return;
    }
    let along = |axis: &str| {
        let of_length =
            |column: &Seen<'_>| column.measure().is_some_and(|unit| unit.quantity == Quantity::Length);
        let fits = |column: &Seen<'_>| {
            column.free && column.has(&CENTRE) && column.has(&[axis]) && of_length(column)
        };
        let mut these = (0..seen.len()).filter(|&k| fits(&seen[k]));
        these.next().filter(|_| these.next().is_none())
    };
    if let [Some(x), Some(y), Some(z)] = ["x", "y", "z"].map(along) {
        for (k, name) in [x, y, z].into_iter().zip(["cx", "cy", "cz"]) {
            all.pair(&mut seen[k], name, None);
        }
    }
}

/// The columns of a measured wrench, `fx fy fz` or `tx ty tz` or both, as names of ours and columns of the file, where nothing of the file has that
/// meaning: three components of a force or of a moment at least, by their units or their names.
pub(super) fn wrench(headers: &[&str], sample: &Sample, names: &Names<'_>) -> Vec<(String, usize)> {
    let seen = see(headers, sample, names);
    if seen.iter().any(|column| matches!(column.role, Some(Role::Force(_) | Role::Moment(_)))) {
        return Vec::new();
    }
    let triple = |ours: &str, quantity: Quantity, letters: &[&str], long: &[&str]| -> Vec<(String, usize)> {
        let of_axis = |axis: &str| {
            let fits = |column: &Seen<'_>| {
                let short = letters.iter().any(|letter| column.has(&[&format!("{letter}{axis}")]));
                let called = short || (column.has(long) && column.has(&[axis]));
                column.free && called && column.measure().is_some_and(|unit| unit.quantity == quantity)
            };
            let mut these = (0..seen.len()).filter(|&k| fits(&seen[k]));
            these.next().filter(|_| these.next().is_none())
        };
        match ["x", "y", "z"].map(|axis| of_axis(axis).map(|k| (format!("{ours}{axis}"), k))) {
            [Some(x), Some(y), Some(z)] => vec![x, y, z],
            _ => Vec::new(),
        }
    };
    let mut all = triple("f", Quantity::Force, &["f"], &["force", "kraft", "forza", "fuerza"]);
    let long = ["moment", "torque", "drehmoment", "momento", "coppia", "couple"];
    all.extend(triple("t", Quantity::Moment, &["m", "t"], &long));
    all
}

/// Whether it is a payload or part of a wrench.
fn is_load(column: &Seen<'_>) -> bool {
    matches!(column.role, Some(Role::PayloadMass | Role::Force(_) | Role::Moment(_)))
}

fn weighs(column: &Seen<'_>) -> bool {
    column.measure().is_some_and(|unit| unit.quantity == Quantity::Mass) && column.may_be_numbers()
}
