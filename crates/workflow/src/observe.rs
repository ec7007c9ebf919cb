//! Which sockets to touch from where, what to look at, and with which gauge.

use crate::campaign;
use crate::error::WorkflowError;
use std::any::Any;
use std::path::Path;
use truepose_errormodel::observation::{Camera, KINDS};
use truepose_errormodel::{Dataset, FittedModel, Landmark, Surroundings};
use truepose_identify::{PlanOptions, Within, plan_observed as chosen, within_reach};
use truepose_io::{CsvInfo, PlannedRow, PlannedVisit};
use truepose_kinematics::{Chain, Pose, TargetId};
use truepose_report::ObservedPlanSummary;

/// What visits are chosen from.
#[derive(Debug, Clone, Copy)]
pub enum PlanFrom<'a> {
    /// These rows.
    Rows(&'a Dataset),
    /// Postures within reach, in which this target observes.
    Reach(Option<TargetId>),
}

/// Chooses what to observe; `surroundings` as the fit has found them ([`found_before`]).
///
/// # Errors
/// When nothing can be planned with them.
pub fn plan_observed(
    fitted: &FittedModel,
    surroundings: &Surroundings,
    from: PlanFrom<'_>,
    goals: Option<&Dataset>,
    options: &PlanOptions,
) -> Result<(Vec<PlannedVisit>, ObservedPlanSummary), WorkflowError> {
    let reached;
    let (rows, left_out, within) = match from {
        PlanFrom::Rows(rows) => (rows, Vec::new(), false),
        PlanFrom::Reach(target) => {
            let Within { rows, left_out } = within_reach(fitted, surroundings, target, options)?;
            reached = rows;
            (&reached, left_out, true)
        }
    };
    let made = chosen(fitted, (rows, surroundings), goals, options)?;
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
pub fn found_before(surroundings: &mut Surroundings, fitted: &FittedModel) {
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

/// The target of this name, or the first; none where there is none.
///
/// # Errors
/// When there is none of this name.
pub fn observing_target(name: Option<&str>, fitted: &FittedModel) -> Result<Option<TargetId>, WorkflowError> {
    let targets = fitted.chain().targets();
    let Some(name) = name else { return Ok((!targets.is_empty()).then_some(TargetId(0))) };
    let names = || targets.iter().map(|target| target.name.as_str()).collect::<Vec<_>>().join(", ");
    let number = targets.iter().position(|target| target.name == *name);
    let unknown = || {
        WorkflowError::option(
            "target",
            format!("the robot has no target `{name}` (its targets: {})", names()),
        )
    };
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

/// What the robot file states of the landmarks of a table of this file; where it names none, all of them are unknown. Rows are numbered as it does.
///
/// # Errors
/// When a landmark is used otherwise than it is declared.
pub fn declared_landmarks(
    known: Surroundings,
    file: &Path,
    chain: &Chain,
    data: &mut Dataset,
    info: &CsvInfo,
) -> Result<Surroundings, WorkflowError> {
    campaign::declared(known, file, chain, data, info)
}
