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

/// Whether it is a payload or part of a wrench.
fn is_load(column: &Seen<'_>) -> bool {
    matches!(column.role, Some(Role::PayloadMass | Role::Force(_) | Role::Moment(_)))
}

fn weighs(column: &Seen<'_>) -> bool {
    column.measure().is_some_and(|unit| unit.quantity == Quantity::Mass) && column.may_be_numbers()
}
