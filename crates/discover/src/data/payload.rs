//! Payloads whose declared mass is wrong.
//!
//! A wrong mass at one level and another stiffness look much alike from afar: the product of both is what is seen. So levels are held
//! against each other by whole fits, in which masses and stiffnesses move together.

use crate::hypotheses::candidate::{Candidate, Change};
use truepose_errormodel::{Dataset, LoadCorrection};
use truepose_kinematics::{Conditions, Load};

fn replaced(load: Load, level: f64, mass: f64) -> Option<Load> {
    LoadCorrection { declared: level, carried: mass }.apply(load)
}

/// The same conditions with another mass, when they declare this level.
pub(crate) fn changed(conditions: &Conditions, level: f64, mass: f64) -> Option<Conditions> {
    replaced(conditions.load, level, mass).map(|load| Conditions { load, ..conditions.clone() })
}

/// The same data with another mass where this level is declared.
pub(crate) fn corrected(data: &Dataset, level: f64, mass: f64) -> Dataset {
    let mut data = data.clone();
    for load in &mut data.load {
        if let Some(other) = replaced(*load, level, mass) {
            *load = other;
        }
    }
    data
}

/// The levels of payload that the data declares, kg, ascending.
pub(crate) fn levels(data: &Dataset) -> Vec<f64> {
    let mut levels: Vec<f64> = Vec::new();
    for load in &data.load {
        if let Load::Payload(payload) = load
            && !levels.iter().any(|&known| replaced(*load, known, known).is_some())
        {
            levels.push(payload.mass);
        }
    }
    levels.sort_by(f64::total_cmp);
    levels
}

/// Rows (0-based) that declare a level.
pub(crate) fn rows_at(data: &Dataset, level: f64) -> Vec<usize> {
    (0..data.len()).filter(|&row| replaced(data.load[row], level, level).is_some()).collect()
}

/// The data with loads as they were found.
pub(crate) fn with_loads(data: &Dataset, found: &[Candidate]) -> Dataset {
    found.iter().fold(data.clone(), |data, candidate| match candidate.change {
        Change::CorrectLoad { level, mass, .. } => corrected(&data, level, mass),
        Change::Add(_) => data,
    })
}

/// The data without what was measured in these rows.
pub(crate) fn without(data: &Dataset, rows: &[usize]) -> Dataset {
    let mut data = data.clone();
    for &row in rows {
        data.position[row] = [f64::NAN; 3];
        data.orientation[row] = None;
    }
    data
}
