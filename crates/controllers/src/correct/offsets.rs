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
use crate::program::{Point, Program, Value};
use crate::reference::Reference;
use crate::{ControllerError, Dialect};
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
    pub fn numbers(&self, dialect: Dialect) -> Vec<f64> {
        let none = Point::new(self.name.clone(), 0);
        none.numbers_of(&self.value, dialect, &[0.0; 4])
    }
}

/// A pose of the program and its correction.
#[derive(Debug)]
struct Pair {
    point: (usize, usize),
    before: Pose,
    after: Pose,
}

/// The points of some programs by what would correct them.
#[derive(Debug, Default)]
pub struct Gathered {
    groups: Vec<Group>,
    /// Points in joint values.
    joints: usize,
    /// Points without a frame and a tool that have names.
    base: usize,
}

/// The points of one frame or tool.
#[derive(Debug)]
struct Group {
    name: String,
    tool: bool,
    stated: Pose,
    pairs: Vec<Pair>,
    /// Tools of the points of a frame.
    with: Vec<String>,
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
    Ok(gathered(programs, corrections, options)?.offsets())
}

/// The points of programs by their frames and tools.
///
/// # Errors
/// When the controller's base in its world has no usable value.
pub fn gathered(
    programs: &[Program],
    corrections: &[Vec<Correction>],
    options: &CorrectOptions,
) -> Result<Gathered, ControllerError> {
    let mut all = Gathered::default();
    for (file, (program, corrections)) in programs.iter().zip(corrections).enumerate() {
        let frames = Frames::new(program, options)?;
        for (k, (point, correction)) in program.points().iter().zip(corrections).enumerate() {
            let moves = matches!(correction.outcome, Outcome::Corrected | Outcome::NotSignificant);
            let Value::Pose { pose, frame, tool, .. } = &point.value else {
                all.joints += usize::from(correction.outcome == Outcome::Corrected);
                continue;
            };
            if !moves {
                continue;
            }
            let of_frame = frames.name(frame).filter(|_| !fixed(frame)).zip(frames.stated(frame).ok());
            let of_tool = || frames.name(tool).zip(frames.tool(tool).ok());
            let Some((name, stated)) = of_frame.or_else(of_tool) else {
                all.base += 1;
                continue;
            };
            let after = correction.replacement.as_ref().and_then(|new| {
                // A place on the way of a circular motion has no angles of its own.
                let rest = point.written.iter().skip(new.numbers.len());
                program.dialect().pose(&new.numbers.iter().chain(rest).copied().collect::<Vec<_>>())
            });
            let pair = Pair { point: (file, k), before: *pose, after: after.unwrap_or(*pose) };
            let is_tool = of_frame.is_none();
            let with = frames.name(tool).filter(|_| !is_tool).map(str::to_owned);
            let known = all.groups.iter().position(|group| group.name == name && group.tool == is_tool);
            let at = known.unwrap_or(all.groups.len());
            if known.is_none() {
                let (name, pairs, with) = (name.to_owned(), Vec::new(), Vec::new());
                all.groups.push(Group { name, tool: is_tool, stated, pairs, with });
            }
            let group = &mut all.groups[at];
            group.pairs.push(pair);
            group.with.extend(with.filter(|name| !group.with.contains(name)));
        }
    }
    Ok(all)
}

impl Gathered {
    /// Whether there is no point.
    pub fn is_empty(&self) -> bool {
        self.groups.is_empty() && self.joints == 0 && self.base == 0
    }

    /// With the points of another program: a frame of one name and one value is one frame. `files` are those before its own; what is its own is named by `program`.
    pub fn join(&mut self, other: Gathered, files: usize, program: &str) {
        self.joints += other.joints;
        self.base += other.base;
        for mut group in other.groups {
            group.pairs.iter_mut().for_each(|pair| pair.point.0 += files);
            let named = |known: &&mut Group| known.name == group.name && known.tool == group.tool;
            let own = group.name.contains(" in line ");
            match self.groups.iter_mut().find(named).filter(|_| !own) {
                Some(known) if alike(&known.stated, &group.stated) => {
                    known.pairs.append(&mut group.pairs);
                    known.with.append(&mut group.with);
                }
                None if !own => self.groups.push(group),
                _ => {
                    group.name = format!("{} of {program}", group.name);
                    self.groups.push(group);
                }
            }
        }
    }

    /// The values that correct them best; those that do not improve, in words.
    pub fn offsets(self) -> (Vec<Offset>, Vec<String>) {
        let (mut all, mut refused) = (Vec::new(), Vec::new());
        let with: Vec<(String, Vec<String>)> =
            self.groups.iter().map(|group| (group.name.clone(), group.with.clone())).collect();
        for Group { name, tool, stated, pairs, .. } in self.groups {
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
        // A new tool moves the points of every frame that have it.
        for offset in all.iter().filter(|offset| offset.tool) {
            let shared = with.iter().filter(|(name, tools)| {
                tools.contains(&offset.name) && all.iter().any(|other| !other.tool && other.name == *name)
            });
            let names: Vec<&str> = shared.map(|(name, _)| name.as_str()).collect();
            if !names.is_empty() {
                refused.push(format!(
                    "{0}: points in {1} have this tool as well, and would be corrected twice: set the new value of {0} or of {1}, not both",
                    offset.name,
                    names.join(", ")
                ));
            }
        }
        for (count, words) in [
            (self.joints, "in joint values have no frame"),
            (self.base, "have neither a frame nor a tool with a name"),
        ] {
            if count > 0 {
                refused.push(format!("points {words}: no offset corrects them ({count})"));
            }
        }
        (all, refused)
    }
}

/// Whether two frames are one, but for round-off of their digits.
fn alike(a: &Pose, b: &Pose) -> bool {
    (a.translation - b.translation).norm() < 1e-9 && (a.rotation - b.rotation).norm() < 1e-9
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
