//! Corrections of all points of a frame as one other value of the frame, or of the tool where the points are in the base.
//!
//! ```text
//! frame  F' = F · D     min over D = (t, ω)   Σ |t + ω × p_i − d_i|²        d_i = p'_i − p_i
//! tool   X' = X · U⁻¹   min over u            Σ |R_i u − d_i|²
//! ```
//!
//! | symbol | here | shape | unit | frame |
//! | --- | --- | --- | --- | --- |
//! | p_i, R_i | pose of the program | 3, 3×3 | m, 1 | F |
//! | p'_i | pose of its correction | 3 | m | F |
//! | t, ω | D, a small motion | 3, 3 | m, rad | F |
//! | u | translation of U; its rotation is the mean of R_iᵀ R'_i | 3 | m | tool |
//!
//! Rotations of a correction are some mrad, whose squares are below a micrometre at a metre.

use super::correction::{Correction, Outcome};
use super::frames::Frames;
use super::options::CorrectOptions;
use crate::ControllerError;
use crate::program::{Point, Program, Reference, Value};
use truepose_kinematics::nalgebra::{DMatrix, DVector, Matrix3, Vector3};
use truepose_kinematics::{Pose, rotation_log, rotation_vector};

/// Directions of a rotation that the points know less than this, relative to the best one, are left alone.
const KNOWN: f64 = 1e-3;

/// A frame or a tool with another value.
#[derive(Debug, Clone)]
pub struct Offset {
    /// Its name in the program.
    pub name: String,
    /// Whether it is a tool.
    pub tool: bool,
    /// Its new value, in the terms of the one that it has, m.
    pub value: Pose,
    /// Its points.
    pub points: Vec<Remaining>,
}

/// A point of a frame that gets another value.
#[derive(Debug, Clone)]
pub struct Remaining {
    /// Place of its file, and of the point in it.
    pub point: (usize, usize),
    /// Size of its correction, m.
    pub before: f64,
    /// What remains of it, m.
    pub after: f64,
}

impl Offset {
    /// Root mean square of the corrections, and of what remains, m.
    pub fn rms(&self) -> [f64; 2] {
        let of = |size: fn(&Remaining) -> f64| {
            (self.points.iter().map(|point| size(point).powi(2)).sum::<f64>() / self.points.len() as f64)
                .sqrt()
        };
        [of(|point| point.before), of(|point| point.after)]
    }

    /// Numbers of the new value in the form of the program's language.
    pub fn numbers(&self, program: &Program) -> Vec<f64> {
        let none = Point::new(self.name.clone(), 0);
        none.numbers_of(&self.value, program.dialect(), &[0.0; 4])
    }
}

/// A pose of the program and its correction.
struct Pair {
    point: (usize, usize),
    before: Pose,
    after: Pose,
}

/// The corrections of [`correct_all`](super::correct_all) as other values of frames and tools; those that do not improve, in words.
///
/// # Errors
/// When the controller's base in its world has no usable value.
pub fn offsets(
    programs: &[Program],
    corrections: &[Vec<Correction>],
    options: &CorrectOptions,
) -> Result<(Vec<Offset>, Vec<String>), ControllerError> {
    let mut found: Vec<(String, bool, Pose, Vec<Pair>)> = Vec::new();
    let (mut joints, mut base) = (0, 0);
    for (file, (program, corrections)) in programs.iter().zip(corrections).enumerate() {
        let frames = Frames::new(program, options)?;
        for (k, (point, correction)) in program.points().iter().zip(corrections).enumerate() {
            let moves = matches!(correction.outcome, Outcome::Corrected | Outcome::NotSignificant);
            let Value::Pose { pose, frame, tool, .. } = &point.value else {
                joints += usize::from(correction.outcome == Outcome::Corrected);
                continue;
            };
            if !moves {
                continue;
            }
            let of_frame = frames.name(frame).filter(|_| !fixed(frame)).zip(frames.stated(frame).ok());
            let of_tool = || frames.name(tool).zip(frames.tool(tool).ok());
            let Some((name, stated)) = of_frame.or_else(of_tool) else {
                base += 1;
                continue;
            };
            let after = correction.replacement.as_ref().and_then(|new| {
                // A place on the way of a circular motion has no angles of its own.
                let rest = point.written.iter().skip(new.numbers.len());
                program.dialect().pose(&new.numbers.iter().chain(rest).copied().collect::<Vec<_>>())
            });
            let after = after.unwrap_or(*pose);
            let pair = Pair { point: (file, k), before: *pose, after };
            let is_tool = of_frame.is_none();
            match found.iter_mut().find(|(other, tool, ..)| other == name && *tool == is_tool) {
                Some((.., pairs)) => pairs.push(pair),
                None => found.push((name.to_owned(), is_tool, stated, vec![pair])),
            }
        }
    }
    let (mut all, mut refused) = (Vec::new(), Vec::new());
    for (name, tool, stated, pairs) in found {
        let (offset, unknowns) = if tool { of_tool(&pairs) } else { of_frame(&pairs) };
        let one = |pair: &Pair| {
            let there = if tool { pair.before * offset } else { offset * pair.before };
            let away = |from: &Pose| (pair.after.translation - from.translation).norm();
            Remaining { point: pair.point, before: away(&pair.before), after: away(&there) }
        };
        let value = stated * if tool { offset.inverse() } else { offset };
        let offset = Offset { name, tool, value, points: pairs.iter().map(one).collect() };
        let [before, after] = offset.rms();
        // An offset through fewer numbers than it has leaves nothing of them, wherever it is elsewhere.
        let count = 3 * pairs.len();
        let free = count.saturating_sub(unknowns).max(1);
        let adjusted = after * (count as f64 / free as f64).sqrt();
        match adjusted < before {
            true => all.push(offset),
            false => refused.push(format!(
                "{}: no offset improves its {} points: the corrections are {:.3} mm RMS, and {:.3} mm would remain",
                offset.name,
                offset.points.len(),
                1e3 * before,
                1e3 * adjusted
            )),
        }
    }
    for (count, words) in
        [(joints, "in joint values have no frame"), (base, "have neither a frame nor a tool with a name")]
    {
        if count > 0 {
            refused.push(format!("points {words}: no offset corrects them ({count})"));
        }
    }
    Ok((all, refused))
}

/// Frames that every controller has at its base, with a name.
fn fixed(frame: &Reference) -> bool {
    matches!(frame, Reference::Named(name) if ["BASE_DATA[0]", "WOBJ0", "world[0]"].contains(&name.as_str()))
}

/// The small motion of the frame, and how many numbers it has.
fn of_frame(pairs: &[Pair]) -> (Pose, usize) {
    // About the middle of the points the rotation is independent of the translation.
    let count = pairs.len() as f64;
    let middle = pairs.iter().map(|pair| pair.before.translation).sum::<Vector3<f64>>() / count;
    let shift = pairs.iter().map(moved).sum::<Vector3<f64>>() / count;
    let mut left = DMatrix::zeros(3 * pairs.len(), 3);
    let mut right = DVector::zeros(3 * pairs.len());
    for (k, pair) in pairs.iter().enumerate() {
        let arm = pair.before.translation - middle;
        left.view_mut((3 * k, 0), (3, 3)).copy_from(&-arm.cross_matrix());
        right.rows_mut(3 * k, 3).copy_from(&(moved(pair) - shift));
    }
    let svd = left.svd(true, true);
    let least = KNOWN * svd.singular_values.max();
    let turn = svd.solve(&right, least.max(f64::MIN_POSITIVE)).ok();
    let turn = turn.map_or(Vector3::zeros(), |turn| Vector3::new(turn[0], turn[1], turn[2]));
    let known = svd.singular_values.iter().filter(|&&value| value > least).count();
    let rotation = rotation_vector(&turn);
    (Pose::new(rotation, middle + shift - rotation * middle), 3 + known)
}

/// The small motion of the tool, and how many numbers place its tip.
fn of_tool(pairs: &[Pair]) -> (Pose, usize) {
    let count = pairs.len() as f64;
    let back = |pair: &Pair| -> Matrix3<f64> { pair.before.rotation.transpose() };
    let shift = pairs.iter().map(|pair| back(pair) * moved(pair)).sum::<Vector3<f64>>() / count;
    let turn =
        pairs.iter().map(|pair| rotation_log(&(back(pair) * pair.after.rotation))).sum::<Vector3<f64>>();
    (Pose::new(rotation_vector(&(turn / count)), shift), 3)
}

fn moved(pair: &Pair) -> Vector3<f64> {
    pair.after.translation - pair.before.translation
}

#[cfg(test)]
mod tests {
    use super::*;

    fn pairs(places: &[[f64; 3]], by: impl Fn(&Pose) -> Pose) -> Vec<Pair> {
        let one = |(k, place): (usize, &[f64; 3])| {
            let before = Pose::from_xyz_rpy(*place, [0.3 * k as f64, 0.2, 0.1]);
            Pair { point: (0, k), before, after: by(&before) }
        };
        places.iter().enumerate().map(one).collect()
    }

    #[test]
    fn small_motions_are_found_and_directions_without_points_are_left() {
        let places = [[0.0, 0.0, 0.0], [0.4, 0.1, 0.0], [0.1, 0.5, 0.2], [0.3, 0.2, -0.1]];
        let small = Pose::from_xyz_rpy([2e-3, -1e-3, 5e-4], [1e-3, -2e-3, 3e-3]);
        let (found, unknowns) = of_frame(&pairs(&places, |pose| small * *pose));
        assert!((found.translation - small.translation).norm() < 5e-6 && unknowns == 6, "{found:?}");
        assert!(rotation_log(&(found.rotation.transpose() * small.rotation)).norm() < 2e-5);
        let (found, unknowns) = of_tool(&pairs(&places, |pose| *pose * small));
        assert!((found.translation - small.translation).norm() < 1e-12 && unknowns == 3);
        assert!(rotation_log(&(found.rotation.transpose() * small.rotation)).norm() < 1e-12);
        // On a line the rotation about it is unknown, at one place all of them.
        let line: Vec<[f64; 3]> = (0..4).map(|k| [0.1 * f64::from(k), 0.0, 0.0]).collect();
        let (found, unknowns) = of_frame(&pairs(&line, |pose| small * *pose));
        assert!(rotation_log(&found.rotation).x.abs() < 1e-9 && unknowns == 5, "{found:?}");
        let (found, unknowns) = of_frame(&pairs(&line[..1], |pose| small * *pose));
        assert!(rotation_log(&found.rotation).norm() < 1e-12 && unknowns == 3);
    }
}
