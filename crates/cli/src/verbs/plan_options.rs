//! What plans for a fit are asked for: where accuracy matters, how many, with which loads.

use crate::args::Plan;
use crate::failure::Failure;
use crate::terminal;
use truepose_errormodel::{Dataset, FittedModel};
use truepose_identify::PlanOptions;
use truepose_io::read_measurements;
use truepose_kinematics::nalgebra::Vector3;
use truepose_kinematics::{Load, Payload};

/// Pose measurements where the user gives no number.
const POSES: usize = 30;

/// Where accuracy matters; none where it is not said.
pub(super) fn goals(args: &Plan, fitted: &FittedModel) -> Result<Option<Dataset>, Failure> {
    let Some(file) = &args.at else { return Ok(None) };
    let options = args.grouped.conditions_for(fitted);
    let (data, _, warnings) = read_measurements(file, fitted.chain(), &options)?;
    terminal::warn(&warnings);
    Ok(Some(data.derived_for(fitted.model())?.into_owned()))
}

/// How many, with which loads, among how many.
pub(super) fn options(args: &Plan) -> Result<PlanOptions, Failure> {
    if let Some(mass) = args.loads.iter().find(|mass| !(mass.is_finite() && **mass >= 0.0)) {
        return Err(Failure::Input(format!("--loads: {mass} is not a mass; give kilograms, 0 or more")));
    }
    let com = Vector3::from_column_slice(&args.com) * 1e-3;
    let count = args.count.unwrap_or(POSES);
    Ok(PlanOptions {
        count,
        loads: args.loads.iter().map(|&mass| Load::Payload(Payload { mass, com })).collect(),
        pool: args.pool.max(count),
        seed: args.seed,
    })
}
