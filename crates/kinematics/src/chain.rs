//! The nominal robot.

use crate::couplings::Couplings;
use crate::prepared::PreparedJoint;
use crate::sines::sin_cos;
use crate::{
    Axis, ChainError, FrameId, Joint, JointId, JointKind, JointMotion, Placement, Pose, Site, Target,
    TargetId,
};
use nalgebra::Vector3;
use serde::{Deserialize, Serialize};

/// In which frame the gravity vector of a description is meant.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum GravityFrame {
    /// The instrument's frame.
    #[default]
    Measurement,
    /// The robot's base, frame 0.
    Base,
}

/// Gravity, m/s².
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Gravity {
    /// The vector, in the axes of `frame`.
    pub vector: Vector3<f64>,
    /// Whose axes.
    pub frame: GravityFrame,
}

impl Default for Gravity {
    fn default() -> Self {
        Gravity { vector: Vector3::new(0.0, 0.0, -9.81), frame: GravityFrame::Measurement }
    }
}

/// A nominal pose, and whether it can be relied on.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Placed {
    /// The nominal pose.
    pub pose: Pose,
    /// False when it is a hint at most, to be found from the data.
    pub known: bool,
}

impl Default for Placed {
    fn default() -> Self {
        Placed { pose: Pose::IDENTITY, known: true }
    }
}

/// A serial robot: `T = B · A_1(q_1) … A_n(q_n) · tool`, with measured points in the tool frame.
///
/// Immutable once made: the `with_…` functions return a changed copy.
#[derive(Debug, Clone, PartialEq)]
pub struct Chain {
    name: String,
    base: Placed,
    joints: Vec<Joint>,
    tool: Placed,
    targets: Vec<Target>,
    gravity: Gravity,
    movable: Vec<JointId>,
    coordinates: Vec<Option<usize>>,
    /// The joints with their constants worked out.
    prepared: Vec<PreparedJoint>,
    /// Between the controller's values and the joints' variables.
    pub(crate) couplings: Couplings,
}

impl Chain {
    /// A robot of these joints, base to tip, with base and tool at the identity and no declared targets.
    ///
    /// # Errors
    /// When no joint moves, a name stands twice, or a number is not finite.
    pub fn new(name: impl Into<String>, joints: Vec<Joint>) -> Result<Self, ChainError> {
        if joints.is_empty() {
            return Err(ChainError::NoJoints);
        }
        for (index, joint) in joints.iter().enumerate() {
            if joint.name.is_empty() {
                return Err(ChainError::EmptyName { what: "joint", number: index + 1 });
            }
            if joints[..index].iter().any(|other| other.name == joint.name) {
                return Err(ChainError::DuplicateName { what: "joints", name: joint.name.clone() });
            }
            joint.validate()?;
        }
        let movable: Vec<JointId> =
            (1..=joints.len()).map(JointId).filter(|j| joints[j.index()].moves()).collect();
        if movable.is_empty() {
            return Err(ChainError::NothingMoves);
        }
        let mut coordinates = vec![None; joints.len()];
        for (coordinate, joint) in movable.iter().enumerate() {
            coordinates[joint.index()] = Some(coordinate);
        }
        let prepared = joints.iter().map(PreparedJoint::of).collect();
        Ok(Chain {
            name: name.into(),
            base: Placed::default(),
            prepared,
            joints,
            tool: Placed::default(),
            targets: Vec::new(),
            gravity: Gravity::default(),
            movable,
            coordinates,
            couplings: Couplings::default(),
        })
    }

    /// With this base: measurement frame → frame 0.
    ///
    /// # Errors
    /// When the pose is not finite.
    pub fn with_base(mut self, base: Placed) -> Result<Self, ChainError> {
        if !base.pose.is_finite() {
            return Err(ChainError::NotFinite { what: "the pose", name: "base".into() });
        }
        self.base = base;
        Ok(self)
    }

    /// With this tool: last joint's frame → tool frame.
    ///
    /// # Errors
    /// When the pose is not finite.
    pub fn with_tool(mut self, tool: Placed) -> Result<Self, ChainError> {
        if !tool.pose.is_finite() {
            return Err(ChainError::NotFinite { what: "the pose", name: "tool".into() });
        }
        self.tool = tool;
        Ok(self)
    }

    /// With these measured points.
    ///
    /// # Errors
    /// When a name is empty or stands twice, or a position is not finite.
    pub fn with_targets(mut self, targets: Vec<Target>) -> Result<Self, ChainError> {
        for (index, target) in targets.iter().enumerate() {
            if target.name.is_empty() {
                return Err(ChainError::EmptyName { what: "target", number: index + 1 });
            }
            if targets[..index].iter().any(|other| other.name == target.name) {
                return Err(ChainError::DuplicateName { what: "targets", name: target.name.clone() });
            }
            if !target.position.iter().all(|v| v.is_finite()) {
                return Err(ChainError::NotFinite { what: "the position", name: target.name.clone() });
            }
        }
        self.targets = targets;
        Ok(self)
    }

    /// With this gravity.
    ///
    /// # Errors
    /// When the vector is not finite.
    pub fn with_gravity(mut self, gravity: Gravity) -> Result<Self, ChainError> {
        if !gravity.vector.iter().all(|v| v.is_finite()) {
            return Err(ChainError::NotFinite { what: "gravity", name: self.name });
        }
        self.gravity = gravity;
        Ok(self)
    }

    /// The robot's name.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Measurement frame → frame 0.
    pub fn base(&self) -> &Placed {
        &self.base
    }

    /// Frame n → tool frame.
    pub fn tool(&self) -> &Placed {
        &self.tool
    }

    /// The measured points.
    #[inline]
    pub fn targets(&self) -> &[Target] {
        &self.targets
    }

    /// Gravity as described.
    pub fn gravity(&self) -> &Gravity {
        &self.gravity
    }

    /// All joints, base to tip, fixed ones included.
    #[inline]
    pub fn joints(&self) -> &[Joint] {
        &self.joints
    }

    /// One joint.
    #[inline]
    pub fn joint(&self, joint: JointId) -> &Joint {
        &self.joints[joint.index()]
    }

    pub(crate) fn joint_mut(&mut self, joint: JointId) -> &mut Joint {
        &mut self.joints[joint.index()]
    }

    /// The joints that move, base to tip: the order of [`crate::Conditions::joints`].
    #[inline]
    pub fn movable(&self) -> &[JointId] {
        &self.movable
    }

    /// Where this joint's variable stands in [`crate::Conditions::joints`]; none for a fixed joint.
    #[inline]
    pub fn coordinate(&self, joint: JointId) -> Option<usize> {
        self.coordinates.get(joint.index()).copied().flatten()
    }

    /// The joint of this name.
    pub fn joint_named(&self, name: &str) -> Option<JointId> {
        self.joints.iter().position(|joint| joint.name == name).map(|index| JointId(index + 1))
    }

    /// The target of this name.
    pub fn target_named(&self, name: &str) -> Option<TargetId> {
        self.targets.iter().position(|target| target.name == name).map(TargetId)
    }

    /// The frame that files call `base`, `tool`, or by the name of the joint in front of it.
    pub fn frame_named(&self, name: &str) -> Option<FrameId> {
        match name {
            "base" => Some(FrameId::BASE),
            "tool" => Some(self.tool_frame()),
            _ => self.joint_named(name).map(|joint| self.frame_after(joint)),
        }
    }

    /// The frame directly after a joint.
    pub fn frame_after(&self, joint: JointId) -> FrameId {
        FrameId(joint.0)
    }

    /// The tool frame, n + 1.
    #[inline]
    pub fn tool_frame(&self) -> FrameId {
        FrameId(self.joints.len() + 1)
    }

    /// All frames: base, one after each joint, tool.
    pub fn frames(&self) -> impl DoubleEndedIterator<Item = FrameId> + ExactSizeIterator + use<> {
        (0..self.joints.len() + 2).map(FrameId)
    }

    /// The word for a frame in files and reports: `base`, a joint's name, or `tool`.
    pub fn frame_word(&self, frame: FrameId) -> &str {
        match frame {
            FrameId::BASE => "base",
            f if f == self.tool_frame() => "tool",
            FrameId(i) => &self.joints[i - 1].name,
        }
    }

    /// How many generalized errors the robot has: six a frame and three a target.
    pub fn site_count(&self) -> usize {
        6 * (self.joints.len() + 2) + 3 * self.targets.len()
    }

    /// Position of a site in a vector of all generalized errors.
    #[inline]
    pub fn site_index(&self, site: Site) -> usize {
        match site {
            Site::Frame(frame, axis) => 6 * frame.0 + axis.index(),
            Site::Target(target, axis) => 6 * (self.joints.len() + 2) + 3 * target.0 + axis.direction(),
        }
    }

    /// The site at a position of the vector of all generalized errors.
    #[inline]
    pub fn site_at(&self, index: usize) -> Site {
        let frames = 6 * (self.joints.len() + 2);
        if index < frames {
            Site::Frame(FrameId(index / 6), Axis::ALL[index % 6])
        } else {
            Site::Target(TargetId((index - frames) / 3), Axis::ALL[(index - frames) % 3])
        }
    }

    /// `y@j2`, `rz@base`, `x@target P1`.
    pub fn site_word(&self, site: Site) -> String {
        match site {
            Site::Frame(frame, axis) => format!("{}@{}", axis.word(), self.frame_word(frame)),
            Site::Target(target, axis) => format!("{}@target {}", axis.word(), self.targets[target.0].name),
        }
    }

    /// The joint's own motion, as a unit twist in the frame where its axis stands still; none for a fixed joint.
    #[inline]
    pub fn joint_motion(&self, joint: JointId) -> Option<JointMotion> {
        let described = self.joint(joint);
        let (frame, axis) = match described.placement {
            Placement::Dh { .. } => (FrameId(joint.0 - 1), Vector3::z()),
            Placement::Mdh { .. } => (FrameId(joint.0), Vector3::z()),
            Placement::Origin { axis, .. } => (FrameId(joint.0), axis.into_inner()),
        };
        described.moves().then_some(JointMotion { joint, kind: described.kind, frame, axis })
    }

    /// A length typical of the arm, m: the sum of the nominal distances between neighbouring frames,
    /// travels of slides included. Angles times this length compare with lengths.
    pub fn characteristic_length(&self) -> f64 {
        let mut length = self.tool.pose.translation.norm();
        for joint in &self.joints {
            length += joint.transform(0.0).translation.norm();
            if joint.kind == JointKind::Prismatic
                && let Some((lower, upper)) = joint.limits
                && (upper - lower).is_finite()
            {
                length += upper - lower;
            }
        }
        let farthest = self.targets.iter().map(|t| t.position.norm()).fold(0.0, f64::max);
        let total = length + farthest;
        if total > 1e-6 { total } else { 1.0 }
    }

    /// Gravity in the axes of the measurement frame, m/s².
    pub fn gravity_in_measurement_frame(&self) -> Vector3<f64> {
        match self.gravity.frame {
            GravityFrame::Measurement => self.gravity.vector,
            GravityFrame::Base => self.base.pose.rotation * self.gravity.vector,
        }
    }

    /// The joints with their constants worked out, and where their variables stand.
    pub(crate) fn prepared(&self) -> impl Iterator<Item = (&PreparedJoint, Option<usize>)> {
        self.prepared.iter().zip(self.coordinates.iter().copied())
    }

    /// One joint (0…) with its constants worked out.
    #[inline]
    pub(crate) fn prepared_joint(&self, index: usize) -> &PreparedJoint {
        &self.prepared[index]
    }

    /// Nominal pose of the tool in the measurement frame; `joints` in rad or m, movable joints only.
    pub fn forward(&self, joints: &[f64]) -> Pose {
        let mut pose = self.base.pose;
        for (joint, coordinate) in self.prepared.iter().zip(&self.coordinates) {
            let q = coordinate.map_or(0.0, |k| joints[k]);
            pose = pose * joint.transform(q, sin_cos(q));
        }
        pose * self.tool.pose
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::samples;

    #[test]
    fn sites_come_back_from_their_index() {
        let robot = samples::pps();
        for index in 0..robot.site_count() {
            assert_eq!(robot.site_index(robot.site_at(index)), index);
        }
        assert_eq!(robot.site_word(robot.site_at(6 * 8)), "x@target P1");
    }

    #[test]
    fn ur10_stands_stretched_out_at_zero() {
        // Universal Robots' own numbers: a2 + a3 along −x, d4 + d6 along −y, d1 − d5 along z.
        let pose = samples::ur10().forward(&[0.0; 6]);
        let expected = Vector3::new(-0.612 - 0.5723, -0.163941 - 0.0922, 0.1273 - 0.1157);
        assert!((pose.translation - expected).norm() < 1e-12, "{}", pose.translation);
    }

    #[test]
    fn what_is_wrong_is_said() {
        let joint = |name: &str| {
            Joint::new(name, JointKind::Fixed, Placement::Dh { theta: 0.0, d: 0.0, a: 0.0, alpha: 0.0 })
        };
        assert_eq!(Chain::new("r", vec![]), Err(ChainError::NoJoints));
        assert_eq!(Chain::new("r", vec![joint("a")]), Err(ChainError::NothingMoves));
        let twice = Chain::new("r", vec![joint("a"), joint("a")]).unwrap_err();
        assert_eq!(twice.to_string(), "two joints bear the name `a`; names must be different");
    }
}
