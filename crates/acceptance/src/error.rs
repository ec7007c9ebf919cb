//! Errors.

use truepose_compensate::CompensateError;
use truepose_errormodel::ModelError;

/// Why measurements cannot be assessed, or poses not be planned.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum AcceptanceError {
    /// The model cannot be evaluated, or the data does not fit the robot.
    #[error(transparent)]
    Model(#[from] ModelError),
    /// The robot has no inverse kinematics here.
    #[error(transparent)]
    Compensate(#[from] CompensateError),
    /// No pose was repeated.
    #[error(
        "no pose was measured twice with its whole position: pose accuracy and repeatability need repeats of the same joint values"
    )]
    NoRepeats,
    /// The commanded pose is unknown.
    #[error(
        "the commanded poses are not known: {what} is to be found from the data (`known = false`). Give a fit (--fit), or the columns \
         command_x, command_y, command_z"
    )]
    Commanded {
        /// Base, tool or target.
        what: String,
    },
    /// Some, but not all, command columns.
    #[error(
        "the data has the column `{have}`, but not `{lacks}`: a commanded position needs x, y and z, an orientation rx, ry and rz"
    )]
    CommandColumns {
        /// A column that is there.
        have: String,
        /// One that is not.
        lacks: String,
    },
    /// A command column in a unit of something else.
    #[error("the column `{column}` is in `{unit}`; {need} is needed")]
    CommandUnit {
        /// The column.
        column: String,
        /// Its unit.
        unit: String,
        /// `a length` or `an angle`.
        need: &'static str,
    },
    /// Too few poses for a best fit.
    #[error(
        "{poses} poses do not determine the position of the instrument: a best fit needs three at least that are not on one line"
    )]
    Alignment {
        /// Poses that were measured.
        poses: usize,
    },
    /// A path cannot be assessed.
    #[error("the path cannot be assessed: {reason}")]
    Path {
        /// Why.
        reason: &'static str,
    },
    /// No cube was found.
    #[error(
        "no cube with an edge of {edge:.0} mm or more was found whose five poses and corners the robot reaches in one posture; give the \
         joints' limits in the robot file, or a smaller edge",
        edge = 1e3 * smallest
    )]
    NoCube {
        /// Smallest edge that was tried, m.
        smallest: f64,
    },
    /// An option is out of its range.
    #[error("{option} is {value}; it has to be {expected}")]
    Option {
        /// Its name.
        option: &'static str,
        /// As given.
        value: f64,
        /// What it may be.
        expected: &'static str,
    },
}
