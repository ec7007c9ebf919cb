//! `truepose plan --observe`: which sockets to touch from where, what to look at, and with which gauge.

use super::declared_landmarks::declared;
use super::plan_options::{goals, options};
use super::sessions::chosen;
use super::{joint_units, robot, told};
use crate::args::{Plan, Robot};
use crate::extensions::effects;
use crate::failure::Failure;
use crate::terminal;
use crate::watch::Watch;
use std::any::Any;
use std::path::Path;
use truepose_errormodel::observation::{Camera, KINDS};
use truepose_errormodel::{Dataset, FittedModel, Landmark, Surroundings};
use truepose_identify::{IdentifyError, PlanOptions, Within, plan_observed, unmeasured, within_reach};
use truepose_io::{
    PlannedRow, PlannedVisit, check_writable, read_fit, read_measurements, read_model, robot_surroundings,
    write_plan,
};
use truepose_kinematics::{Pose, TargetId};
use truepose_report::ObservedPlanSummary;

/// Runs the verb; `file` describes the robot with its landmarks and sensors.
pub fn run(args: &Plan, file: &Path, watch: &Watch) -> Result<(), Failure> {
    check_writable(&args.out)?;
    let registry = effects();
    let mut surroundings = robot_surroundings(file)?;
    let fitted = match (&args.fit, &args.model) {
        (Some(fit), _) => chosen(read_fit(fit, registry)?, args.session.as_deref(), true)?,
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
            let surroundings = declared(surroundings, among, fitted.chain(), &mut data, &info)?;
            (Some(data), surroundings)
        }
        None => (None, surroundings),
    };
    let from = match &among {
        Some(rows) => From::Rows(rows),
        None => From::Reach(target(args.target.as_deref(), &fitted)?),
    };
    let (visits, summary) =
        planned(&fitted, &surroundings, from, goals.as_ref(), &options).map_err(|error| {
            Failure::Input(format!("{}: {error}", args.among.as_deref().unwrap_or(file).display()))
        })?;
    let chain = fitted.chain();
    let units = args.units.as_ref().map(|units| joint_units::chosen(chain, &joint_units::si(chain), units));
    write_plan(&args.out, chain, &visits, units.as_deref())?;
    told(&summary, args.json, &args.out)
}

/// What visits are chosen from.
pub(crate) enum From<'a> {
    /// These rows.
    Rows(&'a Dataset),
    /// Postures within reach, in which this target observes.
    Reach(Option<TargetId>),
}

/// Chooses what to observe; `surroundings` as the fit has found them.
pub(crate) fn planned(
    fitted: &FittedModel,
    surroundings: &Surroundings,
    from: From<'_>,
    goals: Option<&Dataset>,
    options: &PlanOptions,
) -> Result<(Vec<PlannedVisit>, ObservedPlanSummary), IdentifyError> {
    let reached;
    let (rows, left_out, within) = match from {
        From::Rows(rows) => (rows, Vec::new(), false),
        From::Reach(target) => {
            let Within { rows, left_out } = within_reach(fitted, surroundings, target, options)?;
            reached = rows;
            (&reached, left_out, true)
        }
    };
    let made = plan_observed(fitted, (rows, surroundings), goals, options)?;
    let visits: Vec<PlannedVisit> = made
        .visits
        .iter()
        .filter_map(|visit| {
            let conditions = rows.conditions(*visit.rows.first()?);
            Some(PlannedVisit {
                joints: conditions.joints,
                load: conditions.load,
                approach: conditions.approach,
                why: "new",
                worth: visit.worth,
                observed: observed(rows, &visit.rows, surroundings, fitted),
            })
        })
        .collect();
    let names: Vec<Vec<String>> =
        visits.iter().map(|visit| visit.observed.iter().map(|row| row.landmark.clone()).collect()).collect();
    let left_out =
        left_out.into_iter().map(|(k, why)| (surroundings.landmarks[k].name.clone(), why)).collect();
    let summary = ObservedPlanSummary::new(&made, &names, left_out, within);
    Ok((visits, summary))
}

/// Landmarks and cameras where the fit has found them; landmarks that the robot file does not list are those that the fit has found.
pub(crate) fn found_before(surroundings: &mut Surroundings, fitted: &FittedModel) {
    let of =
        |key: &str| fitted.provenance.get(key).and_then(serde_json::Value::as_object).into_iter().flatten();
    for (name, place) in of("landmarks_m") {
        let Ok(place) = serde_json::from_value::<[f64; 3]>(place.clone()) else { continue };
        let own = surroundings.landmarks.iter_mut().find(|landmark| landmark.name == *name);
        match own {
            Some(own) if !own.known && own.observed.is_none() => own.position = Some(place.into()),
            Some(_) => {}
            None => surroundings.landmarks.push(Landmark {
                name: name.clone(),
                position: Some(place.into()),
                ..Landmark::default()
            }),
        }
    }
    for (name, place) in of("cameras") {
        let numbers = |key: &str| serde_json::from_value::<[f64; 3]>(place.get(key)?.clone()).ok();
        let (Some(xyz), Some(rpy)) = (numbers("xyz_m"), numbers("rpy_rad")) else { continue };
        let own = surroundings.landmarks.iter_mut().find(|landmark| landmark.name == *name);
        let Some(observed) = own.and_then(|own| own.observed.as_mut()) else { continue };
        if let Some(camera) = (&**observed as &dyn Any).downcast_ref::<Camera>()
            && !camera.known
        {
            *observed = Box::new(Camera { place: Some(Pose::from_xyz_rpy(xyz, rpy)), ..camera.clone() });
        }
    }
}

/// The target that is asked for, or the first; none where there is none.
pub(crate) fn target(name: Option<&str>, fitted: &FittedModel) -> Result<Option<TargetId>, Failure> {
    let targets = fitted.chain().targets();
    let Some(name) = name else { return Ok((!targets.is_empty()).then_some(TargetId(0))) };
    let names = || targets.iter().map(|target| target.name.as_str()).collect::<Vec<_>>().join(", ");
    let number = targets.iter().position(|target| target.name == *name);
    let unknown =
        || Failure::Input(format!("--target: the robot has no target `{name}` (its targets: {})", names()));
    number.map(|number| Some(TargetId(number))).ok_or_else(unknown)
}

/// What is observed in some rows: each thing once.
fn observed(
    rows: &Dataset,
    own: &[usize],
    surroundings: &Surroundings,
    fitted: &FittedModel,
) -> Vec<PlannedRow> {
    let mut all: Vec<PlannedRow> = Vec::new();
    for &row in own {
        let thing = rows.landmark(row).and_then(|k| surroundings.landmarks.get(k));
        let kind =
            rows.kind(row).map_or(if thing.is_some() { "same_point" } else { "position" }, |k| KINDS[k]);
        let target = rows.target[row].and_then(|target| fitted.chain().targets().get(target.0));
        let planned = PlannedRow {
            kind,
            landmark: thing.map_or_else(String::new, |thing| thing.name.clone()),
            target: target.map_or_else(String::new, |target| target.name.clone()),
        };
        if !all.contains(&planned) {
            all.push(planned);
        }
    }
    all
}
