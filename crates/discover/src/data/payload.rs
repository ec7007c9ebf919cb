//! Payloads whose declared mass is wrong.
//!
//! Deflection depends on the product of mass and compliance, so that a wrong mass at one declared level is
//! strongly correlated with a compliance. Levels are therefore compared by whole fits, in which masses and
//! compliances are estimated jointly ([`crate::contest::payload`]).

use truepose_errormodel::{Dataset, LoadCorrection};
use truepose_kinematics::{Conditions, Load};

/// A stretch of time, s; none: all of it.
pub(crate) type Stretch = Option<[f64; 2]>;

fn replaced(load: Load, level: f64, mass: f64) -> Option<Load> {
    LoadCorrection { declared: level, carried: mass, during: None }.apply(load, 0.0)
}

/// The same conditions with another mass (kg), when they declare this level (kg) in this stretch; `None` else.
pub(crate) fn changed(
    conditions: &Conditions,
    (level, during): (f64, Stretch),
    mass: f64,
) -> Option<Conditions> {
    let correction = LoadCorrection { declared: level, carried: mass, during };
    let load = correction.apply(conditions.load, conditions.time)?;
    Some(Conditions { load, ..conditions.clone() })
}

/// Whether conditions declare this level (kg) in this stretch.
pub(crate) fn declares(conditions: &Conditions, (level, during): (f64, Stretch)) -> bool {
    let same = LoadCorrection { declared: level, carried: level, during };
    same.apply(conditions.load, conditions.time).is_some()
}

/// The same data with another mass (kg) in the rows that declare this level (kg) in this stretch.
pub(crate) fn corrected(data: &Dataset, (level, during): (f64, Stretch), mass: f64) -> Dataset {
    let mut data = data.clone();
    let correction = LoadCorrection { declared: level, carried: mass, during };
    for (load, time) in data.load.iter_mut().zip(&data.time) {
        if let Some(other) = correction.apply(*load, *time) {
            *load = other;
        }
    }
    data
}

/// A level as it is printed, kg: units of the file leave a rounding error in the last digits.
pub(crate) fn rounded(level: f64) -> f64 {
    (level * 1e6).round() * 1e-6
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

/// Rows (0-based) that declare a level (kg) in a stretch.
pub(crate) fn rows_at(data: &Dataset, (level, during): (f64, Stretch)) -> Vec<usize> {
    let correction = LoadCorrection { declared: level, carried: level, during };
    (0..data.len()).filter(|&row| correction.apply(data.load[row], data.time[row]).is_some()).collect()
}

/// Whether a stretch has some of the rows that declare a level (kg), and not all of them.
pub(crate) fn is_part(data: &Dataset, level: f64, during: [f64; 2]) -> bool {
    let (part, all) = (rows_at(data, (level, Some(during))).len(), rows_at(data, (level, None)).len());
    part > 0 && part < all
}

#[cfg(test)]
mod tests {
    use super::*;
    use truepose_errormodel::Schema;
    use truepose_kinematics::{Payload, nalgebra::Vector3};

    #[test]
    fn a_stretch_is_a_part_of_the_rows_with_its_level() {
        let mut data = Dataset { schema: Schema { time: true, ..Schema::default() }, ..Dataset::default() };
        for (time, mass) in [(0.0, 0.0), (1.0, 80.0), (2.0, 80.0), (3.0, 0.0)] {
            data.load.push(Load::Payload(Payload { mass, com: Vector3::zeros() }));
            data.time.push(time);
            data.visit.push(data.visit.len());
        }
        assert!(is_part(&data, 80.0, [0.0, 1.5]));
        assert!(!is_part(&data, 80.0, [0.5, 2.5]), "all of them");
        assert!(!is_part(&data, 80.0, [2.5, 4.0]), "none of them");
    }
}
