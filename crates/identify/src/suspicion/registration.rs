//! How well a robot as described fits measured positions when only the base, and what the description leaves open, may move.
//!
//! ```text
//! min Σ_k |p_k − R (F_k y_τ + f_k) − t|²        over R, t, and y_τ of targets whose place is not known
//! ```
//!
//! | symbol | here | unit | frame |
//! | --- | --- | --- | --- |
//! | p_k | measured position | m | measurement |
//! | F_k, f_k | nominal flange: rotation, origin | 1, m | frame 0 |
//! | y_τ | target seen from the flange | m | flange |
//! | R, t | base | 1, m | measurement |
//!
//! With y fixed, R and t are those of Arun, Huang and Blostein (1987), a reflection excluded; with R and t fixed, each y is a mean.
//! The two take turns. Sources: docs/references.md.

use nalgebra::{Matrix3, Vector3};
use truepose_kinematics::Pose;

/// Turns of the two steps where targets have to be found; the search is for errors of a factor, not for the last digit.
const TURNS: usize = 60;

/// A measured position, and where the robot as described was.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Point {
    /// p_k.
    pub measured: Vector3<f64>,
    /// F_k, f_k.
    pub flange: Pose,
    /// Which of the offsets.
    pub target: usize,
}

/// An offset y_τ of a target from the flange, and whether it may be changed.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Offset {
    /// m.
    pub at: Vector3<f64>,
    /// False: found from the data.
    pub known: bool,
}

/// Root of the mean square of what is left with the base where it fits best, m.
pub(crate) fn anywhere(points: &[Point], offsets: &[Offset]) -> f64 {
    let (base, offsets) = placed(points, offsets);
    at(points, &offsets, &base)
}

/// What is left of the nearest nine tenths of the points when only they place the base (m, RMS), and how far every point is
/// from there (m).
pub(super) fn without_strays(points: &[Point], offsets: &[Offset]) -> (f64, Vec<f64>) {
    let mut kept = points.to_vec();
    let mut distances = Vec::new();
    // A point far away bends the first placement; each round it bends the next one less.
    for _ in 0..6 {
        let (base, offsets) = placed(&kept, offsets);
        distances = points.iter().map(|p| distance(p, &offsets, &base)).collect();
        let mut order: Vec<usize> = (0..points.len()).collect();
        order.sort_by(|&a, &b| distances[a].total_cmp(&distances[b]).then(a.cmp(&b)));
        order.truncate((points.len() * 9).div_ceil(10));
        kept = order.iter().map(|&k| points[k]).collect();
    }
    let (base, offsets) = placed(&kept, offsets);
    (at(&kept, &offsets, &base), distances)
}

/// What is left of these points with base and offsets where they fit best (m, RMS), and how far each of `others` is from there (m).
pub(super) fn distances(points: &[Point], others: &[Point], offsets: &[Offset]) -> (f64, Vec<f64>) {
    let (base, offsets) = placed(points, offsets);
    (at(points, &offsets, &base), others.iter().map(|p| distance(p, &offsets, &base)).collect())
}

/// Base and offsets that fit best.
fn placed(points: &[Point], offsets: &[Offset]) -> (Pose, Vec<Offset>) {
    let mut offsets = offsets.to_vec();
    let open = offsets.iter().any(|o| !o.known);
    let mut base = fitted(points, &offsets);
    for _ in 0..if open { TURNS } else { 0 } {
        let inverse = base.inverse();
        for (k, offset) in offsets.iter_mut().enumerate().filter(|(_, o)| !o.known) {
            let mut sum = Vector3::zeros();
            let mut count = 0.0;
            for p in points.iter().filter(|p| p.target == k) {
                sum += p.flange.inverse().apply(&inverse.apply(&p.measured));
                count += 1.0;
            }
            offset.at = sum / f64::max(count, 1.0);
        }
        base = fitted(points, &offsets);
    }
    (base, offsets)
}

/// How far a point is from where the robot has it, m.
fn distance(p: &Point, offsets: &[Offset], base: &Pose) -> f64 {
    (p.measured - base.apply(&p.flange.apply(&offsets[p.target].at))).norm()
}

/// The same with the base at a place, m.
pub(super) fn at(points: &[Point], offsets: &[Offset], base: &Pose) -> f64 {
    let square: f64 = points.iter().map(|p| distance(p, offsets, base).powi(2)).sum();
    (square / points.len().max(1) as f64).sqrt()
}

/// The base that fits best.
fn fitted(points: &[Point], offsets: &[Offset]) -> Pose {
    let n = points.len().max(1) as f64;
    let place = |p: &Point| p.flange.apply(&offsets[p.target].at);
    let mean_measured = points.iter().map(|p| p.measured).sum::<Vector3<f64>>() / n;
    let mean_place = points.iter().map(place).sum::<Vector3<f64>>() / n;
    let mut cross = Matrix3::zeros();
    for p in points {
        cross += (p.measured - mean_measured) * (place(p) - mean_place).transpose();
    }
    let rotation = nearest_rotation(&cross);
    Pose::new(rotation, mean_measured - rotation * mean_place)
}

/// The rotation R with the largest tr(Rᵀ M).
fn nearest_rotation(m: &Matrix3<f64>) -> Matrix3<f64> {
    if !m.iter().all(|v| v.is_finite()) {
        return Matrix3::identity();
    }
    let svd = m.svd(true, true);
    let (Some(u), Some(v_t)) = (svd.u, svd.v_t) else { return Matrix3::identity() };
    let mut flip = Matrix3::identity();
    // The weakest direction gives way; nalgebra does not promise an order.
    let weakest = svd.singular_values.imin();
    flip[(weakest, weakest)] = (u * v_t).determinant().signum();
    u * flip * v_t
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn base_and_offset_are_found_and_a_mirror_image_is_not() {
        let base = Pose::from_xyz_rpy([3.0, -8.0, 1.0], [2.0, -0.4, 1.1]);
        let truth = Vector3::new(0.1, 0.02, 0.3);
        let flange = |k: usize| {
            let a = k as f64;
            Pose::from_xyz_rpy(
                [(1.3 * a).sin(), (0.7 * a).cos(), (2.1 * a).sin()],
                [a.sin(), (3.0 * a).cos(), 0.4 * a],
            )
        };
        let point = |k: usize| {
            let flange = flange(k);
            Point { measured: base.apply(&flange.apply(&truth)), flange, target: 0 }
        };
        let points: Vec<Point> = (0..30).map(point).collect();
        let known = [Offset { at: truth, known: true }];
        let open = [Offset { at: Vector3::zeros(), known: false }];
        assert!(anywhere(&points, &known) < 1e-12);
        assert!(anywhere(&points, &open) < 1e-5, "{}", anywhere(&points, &open));
        let mirrored: Vec<Point> = points
            .iter()
            .map(|p| Point { measured: p.measured.component_mul(&Vector3::new(1.0, 1.0, -1.0)), ..*p })
            .collect();
        assert!(anywhere(&mirrored, &known) > 0.3);
    }
}
