//! The nominal robot.

use crate::couplings::Couplings;
use crate::kept_length::KeptLength;
use crate::prepared::PreparedJoint;
use crate::sines::sin_cos;
use crate::{
    ChainError, FrameId, Joint, JointId, JointMotion, Placed, Placement, Pose, Site, Target, TargetId, Tool,
    ToolId,
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

/// A robot: `T = B · A_1(q_1) … A_n(q_n) · tool`, with measured points in the tool frame.
///
/// Where joints branch ([`Chain::with_parents`]) the product is that of the joints between base and tool, and each branch can have a tool
/// of its own ([`Chain::with_tools`]).
/// Immutable once made: the `with_…` functions return a changed copy.
#[derive(Debug, Clone, PartialEq)]
pub struct Chain {
    name: String,
    base: Placed,
    joints: Vec<Joint>,
    /// One at least.
    pub(crate) tools: Vec<Tool>,
    targets: Vec<Target>,
    /// How many of them the description has.
    described: usize,
    gravity: Gravity,
    /// Frames and targets that stand where measurements of this robot put them.
    found: (Vec<FrameId>, Vec<TargetId>),
    /// The frame in front of each joint.
    pub(crate) parents: Vec<FrameId>,
    /// By tool and frame, whether the frame carries the tool; empty where one chain of joints carries one tool.
    pub(crate) paths: Vec<Vec<bool>>,
    movable: Vec<JointId>,
    coordinates: Vec<Option<usize>>,
    /// The joints with their constants worked out.
    prepared: Vec<PreparedJoint>,
    /// Between the controller's values and the joints' variables.
    pub(crate) couplings: Couplings,
    /// Kept with the joints, tools and targets of which it is the length.
    pub(crate) length: KeptLength,
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
            tools: vec![Tool::at_the_end_of(&joints)],
            parents: (0..joints.len()).map(FrameId).collect(),
            paths: Vec::new(),
            joints,
            targets: Vec::new(),
            described: 0,
            gravity: Gravity::default(),
            found: Default::default(),
            movable,
            coordinates,
            couplings: Couplings::default(),
            length: KeptLength::default(),
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

    /// With this tool, the first one: frame in front of it (the last joint's, unless it is declared otherwise) → tool frame.
    ///
    /// # Errors
    /// When the pose is not finite.
    pub fn with_tool(mut self, tool: Placed) -> Result<Self, ChainError> {
        if !tool.pose.is_finite() {
            return Err(ChainError::NotFinite { what: "the pose", name: "tool".into() });
        }
        self.tools[0].placed = tool;
        self.length = KeptLength::default();
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
        if let Some(target) = targets.iter().find(|target| target.tool.0 >= self.tools.len()) {
            return Err(ChainError::NoSuchTool { target: target.name.clone() });
        }
        let own = targets.iter().position(|target| target.name.starts_with(crate::SEEN));
        self.described = own.unwrap_or(targets.len());
        self.targets = targets;
        self.length = KeptLength::default();
        Ok(self)
    }

    /// With these frames and targets standing where measurements of this robot put them, besides those that did before.
    #[must_use]
    pub fn with_found(mut self, frames: &[FrameId], targets: &[TargetId]) -> Self {
        self.found.0.extend(frames);
        self.found.1.extend(targets);
        self
    }

    /// Whether the place of an error stands where measurements of this robot put it: its nominal pose is an estimate, and says nothing of how large
    /// the error is expected to be.
    pub fn was_found(&self, site: Site) -> bool {
        match site {
            Site::Frame(frame, _) => self.found.0.contains(&frame),
            Site::Target(target, _) => self.found.1.contains(&target),
        }
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

    /// Of the first tool: the frame in front of it → tool frame.
    pub fn tool(&self) -> &Placed {
        &self.tools[0].placed
    }

    /// The measured points.
    #[inline]
    pub fn targets(&self) -> &[Target] {
        &self.targets
    }

    /// The measured points of the description: all but those that rows have of their own ([`crate::SEEN`]), which come last.
    pub fn described_targets(&self) -> &[Target] {
        &self.targets[..self.described]
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
        self.length = KeptLength::default();
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

    /// The joint's own motion, as a unit twist in the frame where its axis stands still; none for a fixed joint.
    #[inline]
    pub fn joint_motion(&self, joint: JointId) -> Option<JointMotion> {
        let described = self.joint(joint);
        let (frame, axis) = match described.placement {
            Placement::Dh { .. } => (self.before(joint), Vector3::z()),
            Placement::Mdh { .. } => (FrameId(joint.0), Vector3::z()),
            Placement::Origin { axis, .. } => (FrameId(joint.0), axis.into_inner()),
        };
        described.moves().then_some(JointMotion { joint, kind: described.kind, frame, axis })
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

    /// Nominal pose of the first tool in the measurement frame; `joints` in rad or m, movable joints only.
    pub fn forward(&self, joints: &[f64]) -> Pose {
        self.forward_to(ToolId::FIRST, joints)
    }

    /// Nominal pose of a tool in the measurement frame; `joints` in rad or m, movable joints only.
    pub fn forward_to(&self, tool: ToolId, joints: &[f64]) -> Pose {
        let mut pose = self.base.pose;
        for (index, (joint, coordinate)) in self.prepared.iter().zip(&self.coordinates).enumerate() {
            if self.carries(FrameId(index + 1), tool) {
                let q = coordinate.map_or(0.0, |k| joints[k]);
                pose = pose * joint.transform(q, sin_cos(q));
            }
        }
        pose * self.tools[tool.0].placed.pose
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::JointKind;
    use crate::samples;

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
