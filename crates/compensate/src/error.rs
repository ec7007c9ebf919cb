//! What can be wrong before the first command.

use crate::exported_accuracy::Accuracy;
use thiserror::Error;
use truepose_errormodel::ModelError;
use truepose_kinematics::ChainError;

/// A model that cannot be compensated, mapped or exported as requested.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum CompensateError {
    /// The model does not fit the signals that the controller has.
    #[error(transparent)]
    Model(#[from] ModelError),
    /// A kinematics file cannot have the structure of this maker.
    #[error("{reason}")]
    Style {
        /// Why.
        reason: String,
    },
    /// A robot that branches, in a form that holds one chain of joints.
    #[error("the robot branches: {what} are those of one chain of joints")]
    Branches {
        /// What is asked for.
        what: &'static str,
    },
    /// A robot with more joints than a command has room for.
    #[error("the robot has {have} movable joints; commands have room for {most}")]
    TooManyJoints {
        /// Movable joints of the robot.
        have: usize,
        /// Room in a command.
        most: usize,
    },
    /// A model that reads more channels than a command can report on.
    #[error("the model reads {have} channels; commands have room for {most}")]
    TooManyChannels {
        /// Channels that the model reads.
        have: usize,
        /// Room in a command.
        most: usize,
    },
    /// An option that makes no sense.
    #[error("the option `{option}` is {value}; it has to be {need}")]
    Option {
        /// Which option.
        option: &'static str,
        /// Its value.
        value: f64,
        /// What it has to be.
        need: &'static str,
    },
    /// A coefficient that is not a number.
    #[error("coefficient `{name}` of the fit is not a finite number")]
    NotFinite {
        /// The column's name.
        name: String,
    },
    /// Conditions that do not fit the model's channels or the robot's joints.
    #[error("the conditions have {have} {what}; {need} are needed")]
    Conditions {
        /// Which list.
        what: &'static str,
        /// Its length.
        have: usize,
        /// The length it should have.
        need: usize,
    },
    /// Two axes so near to parallel that the common normal between them lies nowhere sensible.
    #[error(
        "joints `{first}` and `{second}` are parallel to {angle_rad:.1e} rad, where a table of Denavit and Hartenberg \
         would need an offset of {offset_m:.1} m; allow Hayati's parameter, or export joint origins"
    )]
    ParallelAxes {
        /// The joint in front.
        first: String,
        /// The joint behind it.
        second: String,
        /// Angle between their axes, rad.
        angle_rad: f64,
        /// The offset that would stand in the table, m.
        offset_m: f64,
    },
    /// A length in a table that no robot of this size has.
    #[error(
        "joint `{joint}` would get {what} = {value_m:.1} m on a robot of {size_m:.1} m; export joint origins instead"
    )]
    AbsurdLength {
        /// The joint.
        joint: String,
        /// `a` or `d`.
        what: &'static str,
        /// The value, m.
        value_m: f64,
        /// The robot's characteristic length, m.
        size_m: f64,
    },
    /// A description of which no numbers describe the corrected robot.
    #[error(
        "the corrected robot cannot be described in the numbers of its own description (two axes on one line, or rows of different \
         conventions); export joint origins instead (urdf or ros)"
    )]
    NotInRows,
    /// An export with which the robot would be less accurate than without.
    #[error(
        "the file would be worse than the nominal robot: RMS {:.4} mm against {:.4} mm with the best base and tool for each, {:.4} mm \
         against {:.4} mm as written; keep the nominal geometry, and see what the fit says of its own accuracy",
        1e3 * export.aligned, 1e3 * nominal.aligned, 1e3 * export.as_written, 1e3 * nominal.as_written
    )]
    WorseThanNominal {
        /// The robot as it was described.
        nominal: Accuracy,
        /// The export.
        export: Accuracy,
    },
    /// Corrected geometry that describes no robot.
    #[error("the corrected geometry is not a valid robot: {0}")]
    Geometry(#[from] ChainError),
}
