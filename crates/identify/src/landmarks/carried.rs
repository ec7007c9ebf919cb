//! A camera that the robot carries and that looks at points of known place: eye in hand.
//!
//! ```text
//! z = π(X⁻¹ T⁻¹ b)                       p̃ = T⁻¹ b,   ∂z/∂p = −H Rᵀ,   p = T p̃
//! ```
//!
//! | symbol | here | unit | frame |
//! | --- | --- | --- | --- |
//! | T, R | the tool that carries the camera, its rotation | m | measurement |
//! | X | the camera on the tool | m | tool |
//! | b | the point that a row sees | m | measurement |
//! | p̃ | a target of that row's own, which the tool carries to b; H: derivative of the pixels by it | m; px/m | tool |
//!
//! To a row it makes no difference whether the point moves or the target that stands there moves the other way. So a row of a carried camera is a
//! row along a direction like any other; nothing behind knows of the camera. The target is put anew wherever the robot has moved. The start from nothing is
//! in `hand_eye`.

use crate::IdentifyError;
use nalgebra::{Matrix3, Vector3};
use truepose_errormodel::{Dataset, Surroundings};
use truepose_kinematics::{Chain, Pose, SEEN, Target, TargetId, ToolId};

/// The rows of cameras that the robot carries.
#[derive(Debug, Clone, Default)]
pub(super) struct Carried {
    /// Of each row: the point that it sees, m, measurement frame.
    points: Vec<Option<Vector3<f64>>>,
    /// Of each row: its own target, by number.
    targets: Vec<Option<TargetId>>,
    /// Of each row: its image, by the number of the visit in which it was taken.
    pub(super) images: Vec<usize>,
    /// Of each such target: a row, and the tool.
    rows: Vec<(usize, ToolId)>,
}

impl Carried {
    /// Of rows at these declared landmarks; each row has its numbers one after the other.
    pub fn of(
        chain: &Chain,
        data: &Dataset,
        of_row: &[Option<usize>],
        (surroundings, follows): (&Surroundings, &dyn Fn(usize) -> bool),
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
                    return why("a camera on the robot needs the point that it saw: a landmark, in the column `point`; where it sees targets on the robot itself, the robot begins at the camera: a URDF with the camera's link as base link and the link of the targets as tip, and a camera without `mount`".into());
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
            let again = row > 0 && follows(row);
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
}

/// The tool on which a camera is mounted.
pub(crate) fn mounted(chain: &Chain, mount: &str) -> Option<ToolId> {
    if let Some(tool) = chain.tool_named(mount) {
        return Some(tool);
    }
    if mount == "tool" {
        return (chain.tools().len() == 1).then_some(ToolId::FIRST);
    }
    let frame = chain.frame_after(chain.joint_named(mount)?);
    chain.tools().iter().position(|tool| tool.frame == frame).map(ToolId)
}
