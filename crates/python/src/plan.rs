//! `plan` and `plan_observed`: what to measure, to touch and to look at next.

use crate::arrays::{beside, vector};
use crate::data::Data;
use crate::error::input;
use crate::fit::Fit;
use crate::robot::Robot;
use crate::run::supervised;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use truepose_identify::{PlanOptions, Why, plan as chosen};
use truepose_io::PlannedVisit;
use truepose_kinematics::nalgebra::Vector3;
use truepose_kinematics::{Chain, Load, Payload};
use truepose_report::PlanSummary;
use truepose_workflow::{PlanFrom, found_before, observing_target, plan_observed as observed};

/// Joint values, loads and directions of the planned pose measurements; the summary as JSON and as text.
#[pyfunction]
#[pyo3(signature = (fit, rival, at, count, loads, com, pool, seed))]
#[allow(clippy::too_many_arguments)]
pub fn plan<'py>(
    py: Python<'py>,
    fit: &Fit,
    rival: Option<PyRef<'_, Fit>>,
    at: Option<PyRef<'_, Data>>,
    count: usize,
    loads: Vec<f64>,
    com: [f64; 3],
    pool: usize,
    seed: u64,
) -> PyResult<(Bound<'py, PyDict>, String, String)> {
    let options = options(count, (&loads, com), pool, seed)?;
    let (fitted, rival) =
        (fit.usable(py)?.first()?, rival.map(|rival| rival.usable(py)?.first()).transpose()?);
    let goals = at.map(|data| data.data.clone());
    let made = supervised(py, None, vec![fit.raised.clone()], move |_| {
        let goals = match &goals {
            Some(data) => Some(data.derived_for(fitted.model()).map_err(input)?.into_owned()),
            None => None,
        };
        chosen(&fitted, rival.as_deref(), goals.as_ref(), &options).map_err(input)
    })?;
    let why = |why| if why == Why::New { "new" } else { "repeat" };
    let visits: Vec<Planned<'_>> = made
        .visits
        .iter()
        .map(|visit| Planned {
            joints: &visit.conditions.joints,
            load: visit.conditions.load,
            approach: &visit.conditions.approach,
            why: why(visit.why),
            worth: visit.worth,
        })
        .collect();
    let all = planned(py, fit.fitted.chain(), &visits)?;
    let summary = PlanSummary::new(&made);
    Ok((all, serde_json::to_string(&summary).map_err(input)?, summary.to_string()))
}

/// What to touch and to look at next: the same, with what is observed in each (kind, landmark, target).
#[pyfunction]
#[pyo3(signature = (fit, robot, at, target, count, loads, com, pool, seed))]
#[allow(clippy::too_many_arguments)]
pub fn plan_observed<'py>(
    py: Python<'py>,
    fit: &Fit,
    robot: &Robot,
    at: Option<PyRef<'_, Data>>,
    target: Option<String>,
    count: usize,
    loads: Vec<f64>,
    com: [f64; 3],
    pool: usize,
    seed: u64,
) -> PyResult<(Bound<'py, PyDict>, String, String)> {
    let options = options(count, (&loads, com), pool, seed)?;
    let (fitted, mut surroundings) = (fit.usable(py)?.first()?, (*robot.beside.surroundings).clone());
    let goals = at.map(|data| data.data.clone());
    let (visits, summary) = supervised(py, None, vec![fit.raised.clone()], move |_| {
        let goals = match &goals {
            Some(data) => Some(data.derived_for(fitted.model()).map_err(input)?.into_owned()),
            None => None,
        };
        found_before(&mut surroundings, &fitted);
        let from = PlanFrom::Reach(observing_target(target.as_deref(), &fitted).map_err(input)?);
        observed(&fitted, &surroundings, from, goals.as_ref(), &options).map_err(input)
    })?;
    let all: Vec<Planned<'_>> = visits
        .iter()
        .map(|visit| Planned {
            joints: &visit.joints,
            load: visit.load,
            approach: &visit.approach,
            why: visit.why,
            worth: visit.worth,
        })
        .collect();
    let all = planned(py, fit.fitted.chain(), &all)?;
    let observed = |visit: &PlannedVisit| -> Vec<(&str, String, String)> {
        visit.observed.iter().map(|row| (row.kind, row.landmark.clone(), row.target.clone())).collect()
    };
    all.set_item("observed", visits.iter().map(observed).collect::<Vec<_>>())?;
    Ok((all, serde_json::to_string(&summary).map_err(input)?, summary.to_string()))
}

/// How many pose measurements, with which loads, among how many.
fn options(count: usize, (loads, com): (&[f64], [f64; 3]), pool: usize, seed: u64) -> PyResult<PlanOptions> {
    if let Some(mass) = loads.iter().find(|mass| !(mass.is_finite() && **mass >= 0.0)) {
        return Err(input(format!("loads: {mass} is not a mass; give kilograms, 0 or more")));
    }
    let com = Vector3::from(com);
    let loads = loads.iter().map(|&mass| Load::Payload(Payload { mass, com })).collect();
    Ok(PlanOptions { count, loads, pool: pool.max(count), seed })
}

/// A pose measurement of a plan.
pub struct Planned<'a> {
    pub joints: &'a [f64],
    pub load: Load,
    pub approach: &'a [f64],
    pub why: &'static str,
    pub worth: f64,
}

/// Pose measurements as arrays.
pub fn planned<'py>(py: Python<'py>, chain: &Chain, visits: &[Planned<'_>]) -> PyResult<Bound<'py, PyDict>> {
    let dof = chain.movable().len();
    let (mut q, mut approach) = (vec![Vec::new(); dof], vec![Vec::new(); dof]);
    for visit in visits {
        let mut values = visit.joints.to_vec();
        chain.joints_to_controller(&mut values);
        q.iter_mut().zip(values).for_each(|(column, value)| column.push(value));
        approach.iter_mut().zip(visit.approach).for_each(|(column, &side)| column.push(side));
    }
    let all = PyDict::new(py);
    all.set_item("q", beside(py, visits.len(), &q))?;
    all.set_item("approach", beside(py, visits.len(), &approach))?;
    let mass = |load: Load| match load {
        Load::Payload(payload) => payload.mass,
        _ => 0.0,
    };
    all.set_item("payload", vector(py, visits.iter().map(|visit| mass(visit.load)).collect()))?;
    all.set_item("why", visits.iter().map(|visit| visit.why).collect::<Vec<_>>())?;
    all.set_item("worth", vector(py, visits.iter().map(|visit| visit.worth).collect()))?;
    Ok(all)
}
