//! A camera that the robot carries and that looks at points of known place: eye in hand.
//!
//! ```text
//! z = π(X⁻¹ T⁻¹ b)                       p̃ = T⁻¹ b,   ∂z/∂p = −H Rᵀ,   p = T p̃
//! C_i = Z F_i X,   F_ij X = X C_ij       log R(C_ij) = R_Xᵀ log R(F_ij),   (R(F_ij) − 1) t_X = R_X t(C_ij) − t(F_ij)
//! ```
//!
//! | symbol | here | unit | frame |
//! | --- | --- | --- | --- |
//! | T, R | the tool that carries the camera, its rotation | m | measurement |
//! | X | the camera on the tool | m | tool |
//! | b | the point that a row sees | m | measurement |
//! | p̃ | a target of that row's own, which the tool carries to b; H: derivative of the pixels by it | m; px/m | tool |
//! | C_i, F_i | the camera in image i by its points; the tool from the base | m | measurement, base |
//! | Z | the base of the robot | m | measurement |
//!
//! To a row it makes no difference whether the point moves or the target that stands there moves the other way. So a row of a carried camera is a
//! row along a direction like any other; nothing behind knows of the camera. The target is put anew wherever the robot has moved. The second
//! line is the start from nothing where the base is unknown (Park and Martin 1994; Shah 2013), with the nominal robot.

use super::sensors::Sensors;
use crate::IdentifyError;
use nalgebra::{DMatrix, DVector, Matrix3, Vector3};
use std::any::Any;
use std::collections::BTreeMap;
use truepose_errormodel::observation::{Camera, Observation, Seen};
use truepose_errormodel::{Dataset, Surroundings};
use truepose_kinematics::{Chain, Placed, Pose, SEEN, Target, TargetId, ToolId, rotation_log};

/// The rows of cameras that the robot carries.
#[derive(Debug, Clone, Default)]
pub(super) struct Carried {
    /// Of each row: the point that it sees, m, measurement frame.
    points: Vec<Option<Vector3<f64>>>,
    /// Of each row: its own target, by number.
    targets: Vec<Option<TargetId>>,
    /// Of each row: its image, by the number of the visit in which it was taken.
    images: Vec<usize>,
    /// Of each such target: a row, and the tool.
    rows: Vec<(usize, ToolId)>,
}

/// Points of one image that determine where its camera was.
const POINTS: usize = 4;
/// A least turn between images, rad, below which noise makes its axis.
const TURN: f64 = 0.05;

impl Carried {
    /// Of rows at these declared landmarks; each row has its numbers one after the other.
    pub fn of(
        chain: &Chain,
        data: &Dataset,
        of_row: &[Option<usize>],
        (surroundings, sensors): (&Surroundings, &Sensors),
    ) -> Result<Self, IdentifyError> {
        let (points, targets) = (vec![None; data.len()], vec![None; data.len()]);
        let mut carried = Carried { points, targets, images: data.visit.clone(), rows: Vec::new() };
        for (row, at) in of_row.iter().enumerate() {
            let Some(landmark) = at.and_then(|k| surroundings.landmarks.get(k)) else { continue };
            let why = |why: String| {
                let line =
                    data.line.get(row).map_or(format!("row {}", row + 1), |line| format!("line {line}"));
                Err(IdentifyError::Landmark { name: landmark.name.clone(), why: format!("{line}: {why}") })
            };
            let point = data.point(row).and_then(|k| surroundings.landmarks.get(k));
            let (mount, point) = match (&landmark.mount, point) {
                (None, None) => continue,
                (None, Some(point)) => {
                    return why(format!(
                        "`point` is {}, but what observed it is not on the robot; leave the cell empty, or give the camera `mount`",
                        point.name
                    ));
                }
                (Some(_), None) => {
                    return why("a camera on the robot needs the point that it saw: a landmark, in the column `point`".into());
                }
                (Some(mount), Some(point)) => (mount, point),
            };
            let Some(position) = point.position.filter(|_| point.known && point.observed.is_none()) else {
                return why(format!(
                    "a camera on the robot sees points of known place; declare `xyz` of landmark {}",
                    point.name
                ));
            };
            let Some(tool) = mounted(chain, mount) else {
                return why(format!(
                    "`mount = \"{mount}\"`: a camera is carried by a tool, named by `tool`, by its own name or by the joint in front of it, or stands in the cell (`base`)"
                ));
            };
            carried.points[row] = Some(position);
            let again = row > 0 && sensors.follows(row);
            if !again {
                carried.rows.push((row, tool));
            }
            carried.targets[row] = Some(TargetId(chain.targets().len() + carried.rows.len() - 1));
        }
        Ok(carried)
    }

    pub fn is_empty(&self) -> bool {
        self.rows.is_empty()
    }

    /// The point that a row sees.
    pub fn point(&self, row: usize) -> Option<Vector3<f64>> {
        self.points.get(row).copied().flatten()
    }

    /// Whether the points span a plane: then they say where the base is, and how long everything is.
    pub fn spans(&self) -> bool {
        let all: Vec<Vector3<f64>> = self.points.iter().flatten().copied().collect();
        let Some(first) = all.first() else { return false };
        let far = all.iter().map(|p| p - first).max_by(|a, b| a.norm().total_cmp(&b.norm()));
        let far = far.unwrap_or_default();
        let area = all.iter().map(|p| (p - first).cross(&far).norm()).fold(0.0, f64::max);
        area > 1e-4 * far.norm_squared() && far.norm() > 0.0
    }

    /// The rows with the targets of their own, or without any.
    pub fn set_targets(&self, chain: &Chain, data: &mut Dataset, own: bool) {
        for (row, target) in self.targets.iter().enumerate() {
            if target.is_some() {
                data.target[row] = target.filter(|_| own);
            }
        }
        let mut tools: Vec<ToolId> = (0..data.len()).map(|row| data.tool(row)).collect();
        for (k, (_, tool)) in self.rows.iter().enumerate() {
            let own = |target: &Option<TargetId>| target.is_some_and(|t| t.0 == chain.targets().len() + k);
            let rows = self.targets.iter().enumerate().filter(|(_, target)| own(target));
            rows.for_each(|(row, _)| tools[row] = *tool);
        }
        if !self.is_empty() {
            data.set_tools(chain, &tools);
        }
    }

    /// The robot with the targets of these rows, where their tools (one pose a row) carry them to the points.
    pub fn with_targets(&self, chain: &Chain, at: &[Pose]) -> Result<Chain, IdentifyError> {
        if self.is_empty() {
            return Ok(chain.clone());
        }
        let mut targets = chain.described_targets().to_vec();
        for (k, &(row, tool)) in self.rows.iter().enumerate() {
            let position = self.seen_from(row, &at[row]).map_or_else(Vector3::zeros, |at| at.translation);
            targets.push(Target { name: format!("{SEEN}{}", k + 1), position, known: true, tool });
        }
        let name = "cameras on the robot".to_owned();
        chain
            .clone()
            .with_targets(targets)
            .map_err(|error| IdentifyError::Landmark { name, why: error.to_string() })
    }

    /// The point of a row in the frame of its tool, which is here: what its camera reads is that of a camera in the cell that the tool is.
    pub fn seen_from(&self, row: usize, tool: &Pose) -> Option<Pose> {
        let point = self.point(row)?;
        Some(Pose::new(Matrix3::identity(), tool.rotation.tr_mul(&(point - tool.translation))))
    }

    /// The robot with its base where the images say it stands, and the cameras on it, with the tools where they are now (one a row).
    pub fn with_base(
        &self,
        chain: &Chain,
        sensors: &mut Sensors,
        at: &[Pose],
    ) -> Result<Chain, IdentifyError> {
        let from = chain.base().pose.inverse();
        let mut best: Option<(usize, Pose)> = None;
        for sensor in 0..sensors.found.len() {
            let rows: Vec<usize> =
                sensors.first_rows(sensor).filter(|&row| self.point(row).is_some()).collect();
            let found = &sensors.found[sensor];
            let Some(camera) =
                (&*found.observation as &dyn Any).downcast_ref::<Camera>().filter(|_| !rows.is_empty())
            else {
                continue;
            };
            let mut images: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
            for &row in &rows {
                images.entry(self.images[row]).or_default().push(row);
            }
            let mut pairs: Vec<(Pose, Pose)> = Vec::new();
            let free = Camera { place: None, known: false, free_intrinsics: false, ..camera.clone() };
            for rows in images.values().filter(|rows| rows.len() >= POINTS) {
                let point = |row: usize| Pose::new(Matrix3::identity(), self.point(row).unwrap_or_default());
                let seen: Vec<Seen> =
                    rows.iter().map(|&row| (point(row), sensors.numbers(row).to_vec())).collect();
                if let Ok(found) = free.started(&seen)
                    && let Some(place) =
                        (&*found as &dyn Any).downcast_ref::<Camera>().and_then(|camera| camera.place)
                {
                    pairs.push((place, from * at[rows[0]]));
                }
            }
            let why = |why: &str| IdentifyError::Landmark { name: found.name.clone(), why: why.into() };
            let (mount, base) = hand_eye(&pairs).ok_or_else(|| {
                why("where camera and base are is not determined: three images of four known points each at least, with the camera turned about two axes between them")
            })?;
            if !camera.known {
                let camera = Camera { place: Some(mount), ..camera.clone() };
                sensors.found[sensor].observation = Box::new(camera);
            }
            if best.is_none_or(|(count, _)| pairs.len() > count) {
                best = Some((pairs.len(), base));
            }
        }
        let Some((_, pose)) = best else { return Ok(chain.clone()) };
        let name = "cameras on the robot".to_owned();
        let placed = chain.clone().with_base(Placed { pose, ..*chain.base() });
        placed.map_err(|error| IdentifyError::Landmark { name, why: error.to_string() })
    }
}

/// The tool on which a camera is mounted.
fn mounted(chain: &Chain, mount: &str) -> Option<ToolId> {
    if let Some(tool) = chain.tool_named(mount) {
        return Some(tool);
    }
    if mount == "tool" {
        return (chain.tools().len() == 1).then_some(ToolId::FIRST);
    }
    let frame = chain.frame_after(chain.joint_named(mount)?);
    chain.tools().iter().position(|tool| tool.frame == frame).map(ToolId)
}

/// X and Z of images: where the camera was in the measurement frame, and the tool in that of the base.
fn hand_eye(pairs: &[(Pose, Pose)]) -> Option<(Pose, Pose)> {
    let mut cross = Matrix3::zeros();
    let mut moves = Vec::new();
    for (i, (c, f)) in pairs.iter().enumerate() {
        for (c2, f2) in &pairs[i + 1..] {
            let (camera, tool) = (c.inverse() * *c2, f.inverse() * *f2);
            let (a, b) = (rotation_log(&tool.rotation), rotation_log(&camera.rotation));
            if a.norm() > TURN && a.norm() < 3.0 {
                cross += a * b.transpose();
                moves.push((camera, tool));
            }
        }
    }
    let svd = cross.svd(true, true);
    let mut sizes: [f64; 3] = svd.singular_values.into();
    sizes.sort_by(|a, b| b.total_cmp(a));
    // Turns about one axis only leave the turn about it open.
    if moves.len() < 2 || sizes[1] < 1e-3 * sizes[0] {
        return None;
    }
    let turn = nearest_rotation(&cross)?;
    let a = DMatrix::from_fn(3 * moves.len(), 3, |row, k| {
        moves[row / 3].1.rotation[(row % 3, k)] - f64::from(u8::from(row % 3 == k))
    });
    let b = DVector::from_fn(3 * moves.len(), |row, _| {
        let (camera, tool) = &moves[row / 3];
        (turn * camera.translation - tool.translation)[row % 3]
    });
    let shift = a.svd(true, true).solve(&b, 1e-9).ok()?;
    let mount = Pose::new(turn, Vector3::new(shift[0], shift[1], shift[2]));
    let bases: Vec<Pose> = pairs.iter().map(|(c, f)| *c * mount.inverse() * f.inverse()).collect();
    let rotation = nearest_rotation(&bases.iter().map(|base| base.rotation).sum())?;
    let place = bases.iter().map(|base| base.translation).sum::<Vector3<f64>>() / bases.len() as f64;
    Some((mount, Pose::new(rotation, place)))
}

/// The rotation nearest to a matrix.
fn nearest_rotation(m: &Matrix3<f64>) -> Option<Matrix3<f64>> {
    let svd = m.svd(true, true);
    let (u, vt) = (svd.u?, svd.v_t?);
    let sign = (u * vt).determinant().signum();
    let mut order = [0, 1, 2];
    order.sort_by(|&a, &b| svd.singular_values[b].total_cmp(&svd.singular_values[a]));
    let mut flip = Vector3::repeat(1.0);
    flip[order[2]] = sign;
    Some(u * Matrix3::from_diagonal(&flip) * vt)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn camera_and_base_are_found_from_images_of_a_robot_that_turns_about_several_axes() {
        let (mount, base) = (
            Pose::from_xyz_rpy([0.03, -0.05, 0.1], [0.2, -0.1, 2.0]),
            Pose::from_xyz_rpy([1.0, 2.0, -0.5], [0.1, 3.0, -1.0]),
        );
        let tool = |k: f64| {
            Pose::from_xyz_rpy([0.4 + 0.1 * k, 0.2 * k.sin(), 0.5], [0.3 * k.cos(), 0.4 * k.sin(), 0.2 * k])
        };
        let pairs: Vec<(Pose, Pose)> =
            (0..6).map(|k| tool(f64::from(k))).map(|f| (base * f * mount, f)).collect();
        let (x, z) = hand_eye(&pairs).unwrap();
        for (found, truth) in [(x, mount), (z, base)] {
            assert!((found.translation - truth.translation).norm() < 1e-9);
            assert!((found.rotation - truth.rotation).amax() < 1e-9);
        }
        // About one axis only, the place along it is open.
        let about = |k: f64| Pose::rot(2, 0.3 * k) * Pose::trans(0, 0.4);
        let pairs: Vec<(Pose, Pose)> =
            (0..6).map(|k| about(f64::from(k))).map(|f| (base * f * mount, f)).collect();
        assert!(hand_eye(&pairs).is_none());
    }
}
