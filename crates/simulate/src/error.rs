//! What can go wrong with a plant, a campaign or their description.

use thiserror::Error;

/// A plant that cannot be built, or that finds no equilibrium.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum SimulateError {
    /// A joint, frame or target that the robot lacks.
    #[error("the robot has no {what} `{name}`; it has: {}", known.join(", "))]
    Unknown {
        /// `joint`, `frame` or `target`.
        what: &'static str,
        /// The options of the run.
        name: String,
        /// What there is.
        known: Vec<String>,
    },
    /// An error of one kind of joint at a joint of another kind.
    #[error("{what} needs a {need} joint, but `{joint}` is {have}")]
    JointKind {
        /// The error.
        what: &'static str,
        /// The joint.
        joint: String,
        /// Its kind.
        have: &'static str,
        /// The kind that is needed.
        need: &'static str,
    },
    /// A size that makes no sense.
    #[error("{what} is {value}; it has to be {need}")]
    Size {
        /// Which quantity.
        what: &'static str,
        /// Its value.
        value: f64,
        /// In words: `positive`, `between 0 and 1`.
        need: &'static str,
    },
    /// A slide without limits, over which nothing can be drawn.
    #[error("joint `{joint}` is a slide without limits; declare its travel")]
    NoLimits {
        /// The joint.
        joint: String,
    },
    /// A list of the wrong length.
    #[error("{what}: {have} where {need} are needed")]
    Shape {
        /// Which list.
        what: &'static str,
        /// Its length.
        have: usize,
        /// The length it should have.
        need: usize,
    },
    /// A robot that is a tree.
    #[error("the robot `{robot}` branches, and only robots whose joints follow one another are simulated")]
    Branches {
        /// The robot.
        robot: String,
    },
    /// A robot that is too soft to stand.
    #[error(
        "the robot `{robot}` finds no equilibrium under its load: after {iterations} steps it still moves by \
         {change_m:.3e} m; its stiffnesses are too low"
    )]
    NoEquilibrium {
        /// The robot.
        robot: String,
        /// Steps made.
        iterations: usize,
        /// Last change, m (angles × 1 m).
        change_m: f64,
    },
    /// A robot description that does not describe a robot.
    #[error(transparent)]
    Chain(#[from] truepose_kinematics::ChainError),
    /// A campaign in which nothing is measured.
    #[error("the campaign has no visits")]
    NoVisits,
    /// A thing of the cell that the real robot neither touches nor shows to a camera.
    #[error(
        "no posture within the joints' limits of {tries} that were tried touches `{name}`, or is seen by it; check where it is, and the limits"
    )]
    OutOfReach {
        /// Its name.
        name: String,
        /// Postures that were tried.
        tries: usize,
    },
    /// A campaign whose joints do not converge where things are touched: each pose depends on the path to it.
    #[error(
        "the postures that touch something do not converge: friction or creep of the joints is too strong for them"
    )]
    Restless,
    /// A thing of the cell whose description is not complete.
    #[error("`{name}`: {why}")]
    Thing {
        /// Its name.
        name: String,
        /// What is missing, and what to do.
        why: String,
    },
    /// A wrong name in a row that has none.
    #[error(
        "row {row} cannot name something else: it is no observation of a landmark (there are {rows} rows)"
    )]
    Misnamed {
        /// The row, from 1.
        row: usize,
        /// Rows in all.
        rows: usize,
    },
    /// A plant description that cannot be read.
    #[error("line {line}, column {column}: {message}")]
    Description {
        /// From 1.
        line: usize,
        /// From 1.
        column: usize,
        /// What is wrong.
        message: String,
    },
}
