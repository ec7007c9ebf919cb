//! What can be wrong with the description of a robot.

use thiserror::Error;

/// A robot description that does not describe a robot.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum ChainError {
    /// A chain without any joint.
    #[error("the robot has no joints; declare at least one")]
    NoJoints,
    /// No joint of the chain moves.
    #[error("none of the robot's joints moves; at least one has to be revolute or prismatic")]
    NothingMoves,
    /// Two joints, or two targets, of one name.
    #[error("two {what} bear the name `{name}`; names must be different")]
    DuplicateName {
        /// `joints` or `targets`.
        what: &'static str,
        /// The name that stands twice.
        name: String,
    },
    /// An empty name.
    #[error("{what} {number} has an empty name")]
    EmptyName {
        /// `joint` or `target`.
        what: &'static str,
        /// Its number, from 1.
        number: usize,
    },
    /// A joint that hangs on one that is declared behind it.
    #[error("joint `{name}` hangs on a joint that is declared behind it; declare joints base first")]
    ParentBehind {
        /// The joint.
        name: String,
    },
    /// A tool behind a joint that the robot does not have.
    #[error("tool `{tool}` is on joint {joint}, and the robot has {joints}")]
    NoSuchJoint {
        /// The tool.
        tool: String,
        /// Number of the joint.
        joint: usize,
        /// Joints of the robot.
        joints: usize,
    },
    /// A list that has not one entry for each joint or tool.
    #[error("{have} {what} are given where {need} are needed")]
    Count {
        /// What the list is of.
        what: &'static str,
        /// Its length.
        have: usize,
        /// The length it should have.
        need: usize,
    },
    /// A target of a tool that the robot does not have.
    #[error("target `{target}` belongs to a tool that the robot does not have")]
    NoSuchTool {
        /// The target.
        target: String,
    },
    /// A number that is not finite.
    #[error("{what} of `{name}` is not a finite number")]
    NotFinite {
        /// Which quantity.
        what: &'static str,
        /// Whose.
        name: String,
    },
    /// The axis of a moving joint has no direction.
    #[error("the axis of joint `{name}` has length zero; give a direction such as [0, 0, 1]")]
    NoAxis {
        /// The joint.
        name: String,
    },
    /// Lower limit above the upper one.
    #[error("the limits of joint `{name}` are the wrong way round: {lower} > {upper}")]
    Limits {
        /// The joint.
        name: String,
        /// Lower limit, rad or m.
        lower: f64,
        /// Upper limit, rad or m.
        upper: f64,
    },
    /// A link of negative mass.
    #[error("the link moved by joint `{name}` has a negative mass: {mass_kg} kg")]
    NegativeMass {
        /// The joint.
        name: String,
        /// Its mass.
        mass_kg: f64,
    },
    /// Joints that drive each other.
    #[error("the couplings form a circle")]
    CouplingCircle,
    /// A coupling that cannot be.
    #[error("coupling {number}: {reason}")]
    Coupling {
        /// Its number, from 1.
        number: usize,
        /// Why.
        reason: &'static str,
    },
    /// A joint that cannot follow another one.
    #[error("joint `{name}` cannot mimic: {reason}")]
    Mimic {
        /// The joint.
        name: String,
        /// Why.
        reason: &'static str,
    },
}
