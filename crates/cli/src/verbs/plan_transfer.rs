//! `truepose plan --for transfer`: the poses of a fit from which a new installation is found best.

use super::poses_of_fit;
use super::print_json;
use crate::args::Plan;
use crate::failure::Failure;
use crate::terminal;
use crate::watch::Watch;
use truepose_report::{count, millimetres};
use truepose_upkeep::{Installation, transfer_poses};

/// Poses where the user gives no number.
const POSES: usize = 8;

/// Runs the verb.
pub fn run(args: &Plan, watch: &Watch) -> Result<(), Failure> {
    let (file, fitted) = poses_of_fit::read(args, "a transfer")?;
    watch.doing("choosing poses");
    let installation = Installation { base: true, tool: args.tool, targets: args.targets };
    let made = transfer_poses(&fitted, args.count.unwrap_or(POSES), installation)
        .map_err(|error| Failure::Input(format!("{}: {error}", file.display())))?;
    poses_of_fit::write(args, &fitted, &made.poses, "transfer")?;
    if args.json {
        return print_json(&serde_json::json!({
            "poses": made.poses.len(), "unknowns": made.unknowns, "band_mm": 1e3 * made.band,
        }));
    }
    terminal::print(&format!(
        "{}: {} of the fit for truepose transfer, {} of the installation; written to {}\n\
         They leave open {} RMS of a predicted position, over the configurations of the fit (3-D standard deviation).\n",
        fitted.chain().name(),
        count(made.poses.len(), "pose"),
        count(made.unknowns, "unknown"),
        args.out.display(),
        millimetres(made.band)
    ));
    Ok(())
}
