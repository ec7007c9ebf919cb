//! How far joints are apart.

use std::f64::consts::TAU;

/// Joints that differ from whole turns by less than this are one configuration, rad.
const CONGRUENT: f64 = 1e-4;

/// Whether joints differ by whole turns alone.
pub(super) fn congruent(a: &[f64], b: &[f64]) -> bool {
    a.iter().zip(b).all(|(a, b)| {
        let off = a - b;
        (off - TAU * (off / TAU).round()).abs() < CONGRUENT
    })
}

pub(super) fn distance(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b).powi(2)).sum::<f64>().sqrt()
}
