//! `plan`: what to measure next.

use crate::arrays::{beside, vector};
use crate::data::Data;
use crate::error::input;
use crate::fit::Fit;
use crate::run::supervised;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use truepose_identify::{PlanOptions, Why, plan as planned};
use truepose_kinematics::nalgebra::Vector3;
use truepose_kinematics::{Load, Payload};
use truepose_report::PlanSummary;

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
    if let Some(mass) = loads.iter().find(|mass| !(mass.is_finite() && **mass >= 0.0)) {
        return Err(input(format!("loads: {mass} is not a mass; give kilograms, 0 or more")));
    }
    let com = Vector3::from(com);
    let loads = loads.iter().map(|&mass| Load::Payload(Payload { mass, com })).collect();
    let options = PlanOptions { count, loads, pool: pool.max(count), seed };
    let (fitted, rival) = (fit.fitted.clone(), rival.map(|rival| rival.fitted.clone()));
    let goals = at.map(|data| data.data.clone());
    let made = supervised(py, None, vec![fit.raised.clone()], move |_| {
        let goals = match &goals {
            Some(data) => Some(data.derived_for(fitted.model()).map_err(input)?.into_owned()),
            None => None,
        };
        planned(&fitted, rival.as_deref(), goals.as_ref(), &options).map_err(input)
    })?;
    let chain = fit.fitted.chain();
    let (mut q, mut approach) =
        (vec![Vec::new(); chain.movable().len()], vec![Vec::new(); chain.movable().len()]);
    for visit in &made.visits {
        let mut values = visit.conditions.joints.clone();
        chain.joints_to_controller(&mut values);
        q.iter_mut().zip(values).for_each(|(column, value)| column.push(value));
        approach.iter_mut().zip(&visit.conditions.approach).for_each(|(column, &side)| column.push(side));
    }
    let all = PyDict::new(py);
    let rows = made.visits.len();
    all.set_item("q", beside(py, rows, &q))?;
    all.set_item("approach", beside(py, rows, &approach))?;
    let mass = |load: Load| match load {
        Load::Payload(payload) => payload.mass,
        _ => 0.0,
    };
    all.set_item("payload", vector(py, made.visits.iter().map(|v| mass(v.conditions.load)).collect()))?;
    let why = |why| if why == Why::New { "new" } else { "repeat" };
    all.set_item("why", made.visits.iter().map(|v| why(v.why)).collect::<Vec<_>>())?;
    all.set_item("worth", vector(py, made.visits.iter().map(|v| v.worth).collect()))?;
    let summary = PlanSummary::new(&made);
    Ok((all, serde_json::to_string(&summary).map_err(input)?, summary.to_string()))
}
