//! `check`: what a robot, a model and data are understood as.

use crate::data::Data;
use crate::error::input;
use crate::model::Model;
use crate::robot::Robot;
use pyo3::prelude::*;
use truepose_errormodel::ErrorModel;

/// Unknowns of the model (family, name, SI unit, expected size). Raises where model and data do not fit.
#[pyfunction]
#[pyo3(signature = (robot, data, model))]
pub fn check(
    py: Python<'_>,
    robot: &Robot,
    data: Option<&Data>,
    model: Option<Vec<(String, Py<PyAny>)>>,
) -> PyResult<Vec<(&'static str, String, String, f64)>> {
    let model = Model::of(py, model, &robot.chain)?;
    if let Some(data) = data {
        model.prepare(&robot.chain, &data.data)?;
    }
    let made = ErrorModel::new((*robot.chain).clone(), model.effects).map_err(input)?;
    if let Some(data) = data {
        let derived = data.data.derived_for(&made).map_err(input)?;
        made.bind(&derived.schema).map_err(input)?;
    }
    let one = |(k, column): (usize, &truepose_errormodel::Column)| {
        (made.effects()[made.effect_of(k)].kind(), column.name.clone(), column.unit.clone(), column.scale)
    };
    Ok(made.columns().iter().enumerate().map(one).collect())
}
