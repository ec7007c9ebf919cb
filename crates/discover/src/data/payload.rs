//! Payloads whose declared mass is wrong.
//!
//! Deflection depends on the product of mass and compliance, so that a wrong mass at one declared level is
//! strongly correlated with a compliance. Levels are therefore compared by whole fits, in which masses and
//! compliances are estimated jointly ([`crate::contest::payload`]).

use truepose_errormodel::{Dataset, LoadCorrection};
use truepose_kinematics::{Conditions, Load};

fn replaced(load: Load, level: f64, mass: f64) -> Option<Load> {
    LoadCorrection { declared: level, carried: mass }.apply(load)
}

/// The same conditions with another mass (kg), when they declare this level (kg); `None` else.
pub(crate) fn changed(conditions: &Conditions, level: f64, mass: f64) -> Option<Conditions> {
    replaced(conditions.load, level, mass).map(|load| Conditions { load, ..conditions.clone() })
}

/// The same data with another mass (kg) in the rows that declare this level (kg).
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

/// Rows (0-based) that declare a level (kg).
pub(crate) fn rows_at(data: &Dataset, level: f64) -> Vec<usize> {
    (0..data.len()).filter(|&row| replaced(data.load[row], level, level).is_some()).collect()
}
