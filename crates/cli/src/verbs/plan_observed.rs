//! `truepose plan --observe`: which sockets to touch from where, what to look at, and with which gauge.

use super::plan_options::{goals, options};
use super::{robot, told};
use crate::args::{Plan, Robot};
use crate::extensions::effects;
use crate::failure::Failure;
use crate::terminal;
use crate::watch::Watch;
use std::path::Path;
use truepose_identify::unmeasured;
use truepose_io::{check_writable, read_fit, read_measurements, read_model, robot_surroundings, write_plan};
use truepose_workflow::{
    PlanFrom, declared_landmarks, found_before, in_session, joint_units, observing_target, plan_observed,
};

/// Runs the verb; `file` describes the robot with its landmarks and sensors.
pub fn run(args: &Plan, file: &Path, watch: &Watch) -> Result<(), Failure> {
    check_writable(&args.out)?;
    let registry = effects();
    let mut surroundings = robot_surroundings(file)?;
    let fitted = match (&args.fit, &args.model) {
        (Some(fit), _) => in_session(read_fit(fit, registry)?, args.session.as_deref(), true)?,
        (None, Some(model)) => {
            let chain = robot(&Robot {
                robot: file.into(),
                base: args.base.clone(),
                tip: args.tip.clone(),
                base_known: true,
                tool_known: true,
            })?;
            unmeasured(&chain, &read_model(model, &chain, registry)?, &surroundings)?
        }
        (None, None) => return Err(Failure::Input("--fit or --model: one of them is needed".into())),
    };
    found_before(&mut surroundings, &fitted);
    let goals = goals(args, &fitted)?;
    let options = options(args)?;
    watch.doing("choosing what to observe");
    let (among, surroundings) = match &args.among {
        Some(among) => {
            let (mut data, info, warnings) =
                read_measurements(among, fitted.chain(), &args.grouped.conditions_for(&fitted))?;
            terminal::warn(&warnings);
            let surroundings = declared_landmarks(surroundings, among, fitted.chain(), &mut data, &info)?;
            (Some(data), surroundings)
        }
        None => (None, surroundings),
    };
    let from = match &among {
        Some(rows) => PlanFrom::Rows(rows),
        None => PlanFrom::Reach(observing_target(args.target.as_deref(), &fitted)?),
    };
    let (visits, summary) =
        plan_observed(&fitted, &surroundings, from, goals.as_ref(), &options).map_err(|error| {
            Failure::Input(format!("{}: {error}", args.among.as_deref().unwrap_or(file).display()))
        })?;
    let chain = fitted.chain();
    let units = args.units.as_ref().map(|units| joint_units::chosen(chain, &joint_units::si(chain), units));
    write_plan(&args.out, chain, &visits, units.as_deref())?;
    told(&summary, args.json, &args.out)
}
