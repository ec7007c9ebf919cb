//! The fitted robot in the numbers of its own description: nominal, calibrated, and how well each is known.
//!
//! A row of Denavit and Hartenberg comes back on the branch that it had; a joint's zero offset is a number of its own. Between nearly parallel axes,
//! where no d is sensible, a row gets Hayati's β. Poses of base, tool and URDF joints have x y z and roll, pitch, yaw about the fixed axes. A robot
//! that its rows cannot describe is described by the origins of its joints, which describe any.

mod described;
mod equivalent;
mod known;
mod rows;
mod spread;
mod text;

use super::geometry::{corrected, with_errors};
use super::options::ExportOptions;
use super::reference::Reference;
use super::remaining::Exported;
use crate::CompensateError;
use described::{Described, segments_of};
use equivalent::Equivalent;
use known::Knowledge;
use nalgebra::DMatrix;
use truepose_errormodel::{FittedModel, GeneralizedErrors};
use truepose_kinematics::{Chain, JointId, Pose};

/// Differences of constants, m and rad.
const STEP: f64 = 1e-6;

/// The numbers of a description.
#[derive(Debug, Clone, PartialEq)]
pub struct ParameterTable {
    /// Base, joints, tool and targets, in this order; joints that do not move are not listed.
    pub parts: Vec<ParameterPart>,
    /// Corrections of the joints' zeros: what has to be added to the reading of each.
    pub offsets: Vec<JointOffset>,
    /// The corrected robot, of the same geometry.
    pub(super) chain: Chain,
}

/// Base, joint, tool or target.
#[derive(Debug, Clone, PartialEq)]
pub struct ParameterPart {
    /// `base`, a joint's name, `tool`, or a target's name.
    pub name: String,
    /// What it is.
    pub kind: PartKind,
    /// Its numbers.
    pub parameters: Vec<Parameter>,
}

/// What a part of a description is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PartKind {
    /// Robot base in the measurement frame.
    Base,
    /// A joint with a row of Denavit and Hartenberg.
    Dh(JointId),
    /// A joint with a row in Craig's convention.
    Mdh(JointId),
    /// A joint with an origin.
    Origin(JointId),
    /// Tool in the last joint's frame.
    Tool,
    /// A point in the tool's frame.
    Target,
}

/// One number.
#[derive(Debug, Clone, PartialEq)]
pub struct Parameter {
    /// Its name in the robot file: `theta`, `d`, `a`, `alpha`, `beta` (Hayati), `x` … `yaw`.
    pub name: &'static str,
    /// m or rad.
    pub unit: &'static str,
    /// As described; none where the description has none (`known = false`).
    pub nominal: Option<f64>,
    /// As fitted.
    pub calibrated: f64,
    /// Standard uncertainty; zero where it was not estimated: other numbers take up its changes, or the data does not determine it.
    pub standard_uncertainty: f64,
}

/// The correction of a joint's zero.
#[derive(Debug, Clone, PartialEq)]
pub struct JointOffset {
    /// The joint.
    pub joint: JointId,
    /// True minus reported value of the controller, rad or m.
    pub offset: f64,
    /// The offset of the joint's variable, where it differs: of a joint that is coupled to others.
    pub of_variable: Option<f64>,
    /// Standard uncertainty; zero where it was not estimated.
    pub standard_uncertainty: f64,
    /// Which part of the robot takes up the offset, where it is not distinguishable: `base`, `tool`, or another joint's length.
    pub part_of: Option<&'static str>,
}

/// The fitted robot in its own description. Effects that are not constant are projected onto it, as in every other export.
///
/// # Errors
/// As [`corrected_chain`](crate::corrected_chain); [`CompensateError::NotInRows`] where neither the rows of the description nor origins describe the
/// robot.
pub fn parameter_table(
    fitted: &FittedModel,
    options: &ExportOptions,
) -> Result<Exported<ParameterTable>, CompensateError> {
    if !fitted.chain().is_serial() {
        return Err(CompensateError::Branches { what: "rows of a table" });
    }
    let reference = Reference::of(fitted, options)?;
    let (exported, constants) = corrected(fitted, &reference)?;
    let chain = fitted.chain();
    let by_origins = with_errors(chain, &GeneralizedErrors::zero(chain))?;
    let [described, origins] = [chain, &by_origins].map(|chain| Described::new(fitted.model(), chain));
    let segments = segments_of(&exported.value);
    // Joints that do not move are not listed: they have to be those of the description.
    let listed = || {
        chain.joints().iter().zip(by_origins.joints()).all(|(a, b)| a.moves() || a.placement == b.placement)
    };
    let (equivalent, solution) = Equivalent::solve(&described, &segments)
        .or_else(|| listed().then(|| Equivalent::solve(&origins, &segments)).flatten())
        .ok_or(CompensateError::NotInRows)?;
    let sensitivity = spread::sensitivity(fitted, &reference, &constants, !exported.left_out.is_empty())?;
    let mut ways = Vec::with_capacity(chain.site_count());
    for k in 0..chain.site_count() {
        let moved = |by: f64| -> Result<Vec<Pose>, CompensateError> {
            let mut errors = constants.clone();
            errors.add(chain.site_at(k), by);
            Ok(segments_of(&with_errors(chain, &errors)?))
        };
        ways.push([moved(STEP)?, moved(-STEP)?]);
    }
    let derivative =
        equivalent.derivative(&solution, &segments, &ways, STEP).ok_or(CompensateError::NotInRows)?;
    let kept = derivative * &sensitivity;
    let mut moves = DMatrix::zeros(equivalent.described.numbers.len(), kept.ncols());
    for (row, &number) in equivalent.kept.iter().enumerate() {
        moves.set_row(number, &kept.row(row));
    }
    let found = rows::Found {
        described: equivalent.described,
        values: &solution.values,
        kept: &equivalent.kept,
        knowledge: Knowledge::new(fitted),
        moves: &moves,
        of_sites: &sensitivity,
    };
    let value = found.table(exported.value);
    let Exported { left_out, remaining_error, comparison, .. } = exported;
    Ok(Exported { value, left_out, remaining_error, comparison })
}
