//! `truepose plan --for transfer`: the poses of a fit from which a new installation is found best.

use super::joint_units;
use super::print_json;
use super::sessions::chosen;
use crate::args::Plan;
use crate::extensions::effects;
use crate::failure::Failure;
use crate::terminal;
use crate::watch::Watch;
use truepose_io::{PlannedVisit, check_writable, read_fit, write_plan};
use truepose_report::{count, millimetres};
use truepose_upkeep::{Installation, transfer_poses};

/// Poses where the user gives no number.
const POSES: usize = 8;

/// Runs the verb.
pub fn run(args: &Plan, watch: &Watch) -> Result<(), Failure> {
    check_writable(&args.out)?;
    let file = args.fit.as_ref().ok_or_else(|| Failure::Input("--fit: a transfer needs a fit".into()))?;
    let fitted = chosen(read_fit(file, effects())?, args.session.as_deref(), true)?;
    watch.doing("choosing poses");
    let installation = Installation { base: true, tool: args.tool, targets: args.targets };
    let made = transfer_poses(&fitted, args.count.unwrap_or(POSES), installation)
        .map_err(|error| Failure::Input(format!("{}: {error}", file.display())))?;
    let visits: Vec<PlannedVisit> = made
        .poses
        .iter()
        .map(|pose| PlannedVisit {
            joints: pose.joints.clone(),
            load: pose.load,
            approach: pose.approach.clone(),
            why: "transfer",
            worth: 0.0,
        })
        .collect();
    let chain = fitted.chain();
    let units = args.units.as_ref().map(|units| joint_units::chosen(chain, &joint_units::si(chain), units));
    write_plan(&args.out, chain, &visits, units.as_deref())?;
    if args.json {
        return print_json(&serde_json::json!({
            "poses": made.poses.len(), "unknowns": made.unknowns, "band_mm": 1e3 * made.band,
        }));
    }
    terminal::print(&format!(
        "{}: {} of the fit for truepose transfer, {} of the installation; written to {}\n\
         They leave open {} RMS of a predicted position, over the configurations of the fit (3-D standard deviation).\n",
        chain.name(),
        count(made.poses.len(), "pose"),
        count(made.unknowns, "unknown"),
        args.out.display(),
        millimetres(made.band)
    ));
    Ok(())
}
