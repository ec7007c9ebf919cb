//! `truepose plan`: further measurements.

use super::print_json;
use crate::args::Plan;
use crate::failure::Failure;
use crate::terminal;
use crate::watch::Watch;
use truepose_errormodel::EffectRegistry;
use truepose_identify::{PlanOptions, plan};
use truepose_io::{PlannedVisit, check_writable, read_fit, read_measurements, write_plan};
use truepose_kinematics::nalgebra::Vector3;
use truepose_kinematics::{Load, Payload};
use truepose_report::PlanSummary;

/// Runs the verb.
pub fn run(args: &Plan, watch: &Watch) -> Result<(), Failure> {
    check_writable(&args.out)?;
    let registry = EffectRegistry::builtin();
    let fitted = read_fit(&args.fit, &registry)?;
    let rival = args.rival.as_ref().map(|file| read_fit(file, &registry)).transpose()?;
    let goals = match &args.at {
        Some(file) => {
            let options = args.grouped.conditions();
            let (data, _, warnings) = read_measurements(file, fitted.chain(), &options)?;
            terminal::warn(&warnings);
            Some(data.derived_for(fitted.model())?.into_owned())
        }
        None => None,
    };
    if let Some(mass) = args.loads.iter().find(|mass| !(mass.is_finite() && **mass >= 0.0)) {
        return Err(Failure::Input(format!("--loads: {mass} is not a mass; give kilograms, 0 or more")));
    }
    let com = Vector3::from_column_slice(&args.com) * 1e-3;
    let options = PlanOptions {
        count: args.count,
        loads: args.loads.iter().map(|&mass| Load::Payload(Payload { mass, com })).collect(),
        pool: args.pool.max(args.count),
        seed: args.seed,
    };
    watch.doing("choosing pose measurements");
    let made = plan(&fitted, rival.as_ref(), goals.as_ref(), &options)?;
    let visits: Vec<PlannedVisit> = made
        .visits
        .iter()
        .map(|visit| PlannedVisit {
            joints: visit.conditions.joints.clone(),
            load: visit.conditions.load,
            approach: visit.conditions.approach.clone(),
            why: match visit.why {
                truepose_identify::Why::New => "new",
                truepose_identify::Why::Repeat => "repeat",
            },
            worth: visit.worth,
        })
        .collect();
    write_plan(&args.out, fitted.chain(), &visits)?;
    let summary = PlanSummary::new(&made);
    if args.json {
        print_json(&summary)?;
    } else {
        terminal::print(&summary.to_string());
    }
    terminal::log(&format!("wrote {}", args.out.display()));
    Ok(())
}
