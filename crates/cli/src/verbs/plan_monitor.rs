//! `truepose plan --for monitor`: the poses of a fit that show changes of the robot best.

use super::poses_of_fit;
use super::print_json;
use crate::args::Plan;
use crate::failure::Failure;
use crate::terminal;
use crate::watch::Watch;
use truepose_report::{count, significant};
use truepose_upkeep::{MonitorOptions, check_poses};

/// Poses where the user gives no number: as many as a quick look takes.
const POSES: usize = 12;
/// Changes that are printed; the JSON has all.
const LISTED: usize = 6;

/// Runs the verb.
pub fn run(args: &Plan, watch: &Watch) -> Result<(), Failure> {
    let (file, fitted) = poses_of_fit::read(args, "a look")?;
    watch.doing("choosing poses");
    let made = check_poses(&fitted, args.count.unwrap_or(POSES), MonitorOptions::default().alpha)
        .map_err(|error| Failure::Input(format!("{}: {error}", file.display())))?;
    poses_of_fit::write(args, &fitted, &made.poses, "check")?;
    if args.json {
        let one = |found: &truepose_upkeep::Detectable| {
            serde_json::json!({
                "what": found.what, "change": found.change, "unit": found.unit, "moves_mm": 1e3 * found.moves,
            })
        };
        return print_json(&serde_json::json!({
            "poses": made.poses.len(),
            "detectable": made.detectable.iter().map(one).collect::<Vec<_>>(),
            "invisible": made.invisible,
        }));
    }
    let mut text = format!(
        "{}: {} of the fit for looks with truepose monitor; written to {}\n\n",
        fitted.chain().name(),
        count(made.poses.len(), "pose"),
        args.out.display()
    );
    text += "changes that the first look finds in 9 cases of 10, as the RMS by which they move what is measured:\n";
    for found in made.detectable.iter().take(LISTED) {
        text += &format!("  {} mm  {}\n", significant(1e3 * found.moves, 2), found.what);
    }
    if made.detectable.len() > LISTED {
        text += &format!("  and {} more, all of them smaller\n", made.detectable.len() - LISTED);
    }
    if !made.invisible.is_empty() {
        text += &format!("not visible in any of these poses: {}\n", made.invisible.join(", "));
    }
    terminal::print(&text);
    Ok(())
}
