//! The position of the real robot, from a fit.

use crate::beyond::{self, Tally};
use crate::error::WorkflowError;
use crate::sessions::{Part, parts};
use rayon::prelude::*;
use std::path::Path;
use truepose_compensate::radius_95;
use truepose_errormodel::{Coverage, Dataset, FittedModel};
use truepose_identify::Residuals;
use truepose_io::{CsvInfo, Prediction};
use truepose_kinematics::Conditions;
use truepose_kinematics::nalgebra::Matrix3;

/// Rows that one thread takes at a time.
const CHUNK: usize = 256;

/// Predictions of all rows, each in the session of its row.
#[derive(Debug, Default)]
pub struct Predicted {
    /// In the order of the rows.
    pub predicted: Vec<Prediction>,
    /// Inputs beyond the data of the fit.
    pub beyond: Tally,
    /// Of rows that were measured.
    pub residuals: Residuals,
}

/// Predicts every row in its session; `session` is one for all of them. The rows lose their sessions.
///
/// # Errors
/// When the data lacks a signal of the model or the name of a session.
pub fn predict(
    fitted: &FittedModel,
    data: &mut Dataset,
    info: &CsvInfo,
    session: Option<&str>,
    file: &Path,
) -> Result<Predicted, WorkflowError> {
    let parts = parts(fitted, data, info, session, file)?;
    let Predicted { mut predicted, mut beyond, mut residuals } = Predicted::default();
    for part in &parts {
        let here = data.select(&part.rows);
        let inputs =
            here.derived_for(part.fitted.model()).map_err(|error| WorkflowError::about(file, error))?;
        let coverage =
            Coverage::new(&part.fitted, &inputs.schema).map_err(|error| WorkflowError::about(file, error))?;
        let (some, of_part) = predict_rows(&part.fitted, &coverage, &inputs);
        beyond.join(&of_part);
        predicted.extend(some);
        let of_part = Residuals::of(&part.fitted, &here)?;
        residuals.position.extend(of_part.position);
        residuals.orientation.extend(of_part.orientation);
    }
    in_order(&parts, &mut predicted);
    in_order(&parts, &mut residuals.position);
    in_order(&parts, &mut residuals.orientation);
    Ok(Predicted { predicted, beyond, residuals })
}

/// Brings values that are listed session by session into the order of the rows.
fn in_order<T>(parts: &[Part], values: &mut Vec<T>) {
    let rows = parts.iter().flat_map(|part| part.rows.iter().copied());
    let mut numbered: Vec<(usize, T)> = rows.zip(values.drain(..)).collect();
    numbered.sort_by_key(|(row, _)| *row);
    values.extend(numbered.into_iter().map(|(_, value)| value));
}

/// Warnings about targets that were not measured in the data of the fit.
///
/// # Errors
/// When the place of one is not known; names its first line.
pub fn targets_seen(fitted: &FittedModel, data: &Dataset) -> Result<Vec<String>, WorkflowError> {
    let mut warnings = Vec::new();
    let mut done = Vec::new();
    for (row, &target) in data.target.iter().enumerate().filter(|_| !fitted.domain.targets.is_empty()) {
        if !done.contains(&target) {
            done.push(target);
            let line = data.line.get(row).map_or(String::new(), |line| format!("line {line}: "));
            warnings.extend(
                beyond::seen(fitted, target)
                    .map_err(|words| WorkflowError::Input(format!("{line}{words}")))?,
            );
        }
    }
    Ok(warnings)
}

/// Every row, in order, and what of it lies beyond the data of the fit; of one installation.
pub fn predict_rows(
    fitted: &FittedModel,
    coverage: &Coverage<'_>,
    inputs: &Dataset,
) -> (Vec<Prediction>, Tally) {
    let oriented = beyond::oriented(fitted).is_ok();
    let noise = Matrix3::identity() * fitted.noise.position_sd.powi(2);
    let rows: Vec<usize> = (0..inputs.len()).collect();
    let parts: Vec<(Vec<Prediction>, Tally)> = rows
        .par_chunks(CHUNK)
        .map(|rows| {
            let mut coverage = coverage.clone();
            let mut conditions = Conditions::default();
            let mut tally = Tally::default();
            let one = |&row: &usize| {
                inputs.conditions_into(row, &mut conditions);
                let judged = coverage.judge(&conditions, inputs.target[row]);
                tally.add(&judged.beyond);
                let within_95 = match fitted.determines(inputs.target[row]) {
                    true => radius_95(&(judged.covariance + noise)),
                    false => f64::INFINITY,
                };
                Prediction { pose: judged.pose, oriented, within_95, extrapolates: !judged.beyond.is_empty() }
            };
            let predicted = rows.iter().map(one).collect();
            (predicted, tally)
        })
        .collect();
    let (mut all, mut tally) = (Vec::with_capacity(rows.len()), Tally::default());
    for (predicted, some) in parts {
        all.extend(predicted);
        tally.join(&some);
    }
    (all, tally)
}
