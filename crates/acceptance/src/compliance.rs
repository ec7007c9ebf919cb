//! Static compliance: displacement of the target per unit of a force, at one configuration.
//!
//! ```text
//! s = Σ (f_j − f̄)(x_j − x̄) / Σ (f_j − f̄)²          f_j = d·F_j            compliance = ‖s‖
//! u² = ŝᵀ Σ ŝ / Σ (f_j − f̄)²,   Σ: covariance of the residuals x_j − x̄ − s (f_j − f̄),  n − 2 degrees of freedom
//! ```
//!
//! | symbol | here | unit | frame |
//! | --- | --- | --- | --- |
//! | F_j | force of the load in cycle j (payload × gravity, or measured) | N | base |
//! | d | direction in which the force was varied: along an axis of the base, in one sense; else the one in which it varies most | 1 | base |
//! | x_j | attained position | m | base |
//!
//! Source: ISO 9283:1998, clause 10: forces along the axes of the base in both senses, in steps up to the rated load.

use crate::attained::TestPose;
use crate::figure::{Figure, Method};
use nalgebra::{Matrix3, Vector3};
use truepose_kinematics::{Chain, Load};

/// Static compliance at one configuration in one direction.
#[derive(Debug, Clone, PartialEq)]
pub struct Compliance {
    /// Names of the poses: one configuration under different loads.
    pub poses: Vec<String>,
    /// d, base frame.
    pub direction: Vector3<f64>,
    /// Smallest and largest force along d, N.
    pub forces: [f64; 2],
    /// Number of different forces.
    pub levels: usize,
    /// Number of cycles.
    pub cycles: usize,
    /// s, m/N, base frame.
    pub displacement: Vector3<f64>,
    /// ‖s‖, m/N.
    pub compliance: Figure,
}

/// Joint values nearer than this are one configuration (rad, m).
const SAME_JOINT: f64 = 1e-4;
/// A force lies along an axis when this fraction of it does.
const ALONG: f64 = 0.95;
/// Forces nearer than this fraction of the range are one level.
const SAME_FORCE: f64 = 1e-3;

/// Every configuration and direction in which the force varies; `forces` has one for each cycle of each pose, N, base frame.
pub fn compliance(poses: &[TestPose], forces: &[Vec<Vector3<f64>>]) -> Vec<Compliance> {
    let mut found = Vec::new();
    let mut done = vec![false; poses.len()];
    for first in 0..poses.len() {
        if done[first] {
            continue;
        }
        let same = |other: &TestPose| {
            let near = |(a, b): (&f64, &f64)| (a - b).abs() < SAME_JOINT;
            other.target == poses[first].target && poses[first].joints.iter().zip(&other.joints).all(near)
        };
        let group: Vec<usize> = (first..poses.len()).filter(|&k| same(&poses[k])).collect();
        group.iter().for_each(|&k| done[k] = true);
        let all: Vec<(Vector3<f64>, Vector3<f64>)> = group
            .iter()
            .flat_map(|&k| forces[k].iter().copied().zip(poses[k].cycles.iter().map(|cycle| cycle.position)))
            .collect();
        let names: Vec<String> = group.iter().map(|&k| poses[k].name.clone()).collect();
        found.extend(of_group(&all).into_iter().map(|one| Compliance { poses: names.clone(), ..one }));
    }
    found
}

/// The force of a load at a pose, N, base frame.
pub(crate) fn force(chain: &Chain, load: &Load, tool: &Matrix3<f64>) -> Vector3<f64> {
    match load {
        Load::None => Vector3::zeros(),
        Load::Payload(payload) => {
            chain.base().pose.rotation.transpose() * chain.gravity_in_measurement_frame() * payload.mass
        }
        Load::Wrench(wrench) => tool * wrench.force,
    }
}

fn of_group(all: &[(Vector3<f64>, Vector3<f64>)]) -> Vec<Compliance> {
    // The smallest force is the reference.
    let Some(reference) = all.iter().map(|(f, _)| *f).min_by(|a, b| a.norm().total_cmp(&b.norm())) else {
        return Vec::new();
    };
    let most = all.iter().map(|(f, _)| (f - reference).norm()).fold(0.0, f64::max);
    if most <= SAME_FORCE * reference.norm().max(1e-9) {
        return Vec::new();
    }
    let mut found = Vec::new();
    for axis in [Vector3::x(), Vector3::y(), Vector3::z()] {
        for d in [axis, -axis] {
            let along = |f: &Vector3<f64>| {
                let by = f - reference;
                by.norm() <= SAME_FORCE * most || by.dot(&d) >= ALONG * by.norm()
            };
            let chosen: Vec<_> = all.iter().filter(|(f, _)| along(f)).copied().collect();
            found.extend(regressed(&chosen, d, most));
        }
    }
    if found.is_empty() {
        let spread: Matrix3<f64> =
            all.iter().map(|(f, _)| (f - reference) * (f - reference).transpose()).sum();
        let eigen = spread.symmetric_eigen();
        let d: Vector3<f64> = eigen.eigenvectors.column(eigen.eigenvalues.imax()).into();
        let sense = all.iter().map(|(f, _)| (f - reference).dot(&d)).sum::<f64>().signum();
        found.extend(regressed(all, d * sense, most));
    }
    found
}

/// The slope over forces along d; none with fewer than two levels or three cycles.
fn regressed(all: &[(Vector3<f64>, Vector3<f64>)], d: Vector3<f64>, most: f64) -> Option<Compliance> {
    let mut levels: Vec<f64> = all.iter().map(|(f, _)| f.dot(&d)).collect();
    levels.sort_by(f64::total_cmp);
    let (low, high) = (*levels.first()?, *levels.last()?);
    levels.dedup_by(|a, b| (*a - *b).abs() <= SAME_FORCE * most);
    let n = all.len() as f64;
    if levels.len() < 2 || all.len() < 3 {
        return None;
    }
    let f_mean = all.iter().map(|(f, _)| f.dot(&d)).sum::<f64>() / n;
    let x_mean = all.iter().map(|(_, x)| *x).sum::<Vector3<f64>>() / n;
    let square: f64 = all.iter().map(|(f, _)| (f.dot(&d) - f_mean).powi(2)).sum();
    let slope = all.iter().map(|(f, x)| (x - x_mean) * (f.dot(&d) - f_mean)).sum::<Vector3<f64>>() / square;
    let size = slope.norm();
    let direction = if size > 0.0 { slope / size } else { d };
    let left: f64 =
        all.iter().map(|(f, x)| (x - x_mean - slope * (f.dot(&d) - f_mean)).dot(&direction).powi(2)).sum();
    let freedom = n - 2.0;
    let u = (left / freedom / square).sqrt();
    Some(Compliance {
        poses: Vec::new(),
        direction: d,
        forces: [low, high],
        levels: levels.len(),
        cycles: all.len(),
        displacement: slope,
        compliance: Figure::with_u(size, u, freedom, Method::FirstOrder),
    })
}
