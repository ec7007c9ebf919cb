//! What `plan --for monitor` and `plan --for transfer` share: poses of a fit, written as a plan.

use crate::args::Plan;
use crate::extensions::effects;
use crate::failure::Failure;
use std::path::Path;
use truepose_errormodel::FittedModel;
use truepose_io::{PlannedVisit, check_writable, read_fit, write_plan};
use truepose_kinematics::Conditions;
use truepose_workflow::{in_session, joint_units};

/// The file of the fit and the fit, of the session that was asked for; `what` needs one.
pub fn read<'a>(args: &'a Plan, what: &str) -> Result<(&'a Path, FittedModel), Failure> {
    check_writable(&args.out)?;
    let file = args.fit.as_ref().ok_or_else(|| Failure::Input(format!("--fit: {what} needs a fit")))?;
    Ok((file, in_session(read_fit(file, effects())?, args.session.as_deref(), true)?))
}

/// Writes poses as a plan; `why` is their column of that name.
pub fn write(
    args: &Plan,
    fitted: &FittedModel,
    poses: &[Conditions],
    why: &'static str,
) -> Result<(), Failure> {
    let visit = |pose: &Conditions| PlannedVisit {
        joints: pose.joints.clone(),
        load: pose.load,
        approach: pose.approach.clone(),
        why,
        worth: 0.0,
        observed: Vec::new(),
    };
    let visits: Vec<PlannedVisit> = poses.iter().map(visit).collect();
    let chain = fitted.chain();
    let units = args.units.as_ref().map(|units| joint_units::chosen(chain, &joint_units::si(chain), units));
    Ok(write_plan(&args.out, chain, &visits, units.as_deref())?)
}
