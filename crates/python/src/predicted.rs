//! Predictions and commands as columns.

use crate::arrays::{beside as beside_rows, vector};
use crate::error::{input, of_io, warnings};
use crate::table::Table;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::path::Path;
use truepose_compensate::RosStyle;
use truepose_errormodel::{Coverage, Dataset, FittedModel};
use truepose_io::{CsvInfo, Prediction, poses_in_memory};
use truepose_workflow::command::{CommandOptions, Expected, command, held_joints, known_poses};
use truepose_workflow::{WorkflowError, beyond, predict, predict_rows, recorded_columns, targets_seen};

/// Columns, and warnings.
pub type Told<'py> = PyResult<(Bound<'py, PyDict>, Vec<String>)>;

/// Commands for desired poses, with these joints held; and warnings.
pub fn compensated<'py>(py: Python<'py>, fitted: &FittedModel, poses: &Table, hold: &[String]) -> Told<'py> {
    let chain = fitted.chain();
    let (mut poses, _, said) =
        poses_in_memory(poses.table.clone(), chain, &recorded_columns(fitted)).map_err(of_io)?;
    let mut said = warnings(&said);
    said.extend(known_poses(fitted, &poses, Path::new("poses")).map_err(input)?);
    let hold = held_joints(fitted, hold, &poses).map_err(|words| input(format!("hold: {words}")))?;
    let options = CommandOptions { hold, ..CommandOptions::default() };
    let found = py.detach(|| command(fitted, &mut poses, &options, &|| ()));
    let (commands, expected) = found.map_err(input)?;
    let channels = poses.rows.derived_for(fitted.model()).map_err(input)?.schema.channels.clone();
    let beyond = |of: &Expected| beyond::words(&of.beyond, chain, &channels);
    let all = PyDict::new(py);
    let mut joints: Vec<Vec<f64>> = vec![Vec::new(); chain.movable().len()];
    for command in &commands {
        let mut values = command.joints;
        chain.joints_to_controller(&mut values);
        joints.iter_mut().zip(values.iter()).for_each(|(column, value)| column.push(*value));
    }
    all.set_item("q", beside_rows(py, commands.len(), &joints))?;
    all.set_item("status", commands.iter().map(|c| c.status.word()).collect::<Vec<_>>())?;
    all.set_item("within_95", vector(py, expected.iter().map(|of| of.within_95).collect()))?;
    let left: Vec<f64> = commands.iter().map(|c| c.position_error).collect();
    all.set_item("position_error", vector(py, left))?;
    all.set_item("corrected", vector(py, expected.iter().map(|of| of.corrected).collect::<Vec<bool>>()))?;
    all.set_item("beyond", expected.iter().map(beyond).collect::<Vec<_>>())?;
    Ok((all, said))
}

/// Predictions of rows, each in its session, and warnings.
pub fn predicted(
    fitted: &FittedModel,
    data: &Dataset,
    info: &CsvInfo,
) -> Result<(Vec<Prediction>, Vec<String>), WorkflowError> {
    let warnings = targets_seen(fitted, data)?;
    if fitted.sessions.is_empty() {
        let inputs = data.derived_for(fitted.model())?;
        let coverage = Coverage::new(fitted, &inputs.schema)?;
        return Ok((predict_rows(fitted, &coverage, &inputs).0, warnings));
    }
    Ok((predict(fitted, &mut data.clone(), info, None, &info.file)?.predicted, warnings))
}

/// The form of a maker's kinematics file.
pub fn maker(word: &str) -> PyResult<RosStyle> {
    RosStyle::ALL.into_iter().find(|style| style.word() == word).ok_or_else(|| {
        let known: Vec<&str> = RosStyle::ALL.iter().map(|style| style.word()).collect();
        input(format!("unknown style `{word}` (known: {})", known.join(", ")))
    })
}
