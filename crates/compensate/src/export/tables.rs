//! What depends on the joints as tables of component errors, one a joint, in the way of ISO 230-1.
//!
//! ```text
//! ε(q) ≈ ε(q_0) + Σ_j [ ε(q_0 with q_j) − ε(q_0) ]
//! ```
//!
//! | symbol | here | shape | unit | frame |
//! | --- | --- | --- | --- | --- |
//! | q_0 | `reference` | joints | rad, m | the middle of the ranges |
//! | ε(q_0) | `constant` | sites | m, rad | each in its frame |
//! | the bracket | [`ErrorTable`](super::ErrorTable) | values × sites | m, rad | each in its frame |
//!
//! ISO 230-1 has six errors an axis (EXX, EYX, …, ECX for X), all of its own carriage; here a joint has a column for
//! every component that moves with it, wherever it sits. What two joints do together is not in the sum: the error left
//! states how much that is. Between the entries one interpolates linearly.
//!
//! The constants, and one factor for each joint's table, are then those that come nearest to the whole model at the configurations of
//! the fit: with all factors zero these are the constants alone, so that tables are never worse there.

use super::comparison::of_chain;
use super::error_tables::{ErrorTable, ErrorTables};
use super::geometry::with_errors;
use super::options::{ExportOptions, ranges, table_conditions};
use super::project::project;
use super::reference::Reference;
use super::remaining::{Exported, judged};
use crate::CompensateError;
use crate::accuracy::everything;
use truepose_errormodel::FittedModel;
use truepose_kinematics::Site;

/// A component that changes by less than this, m or rad, over a joint's whole range has no column.
const NEGLIGIBLE: f64 = 1e-9;

/// Tables with so many entries a joint.
///
/// # Errors
/// When the conditions do not fit the model, or fewer than two or more than 100 000 entries are requested.
pub fn error_tables(
    fitted: &FittedModel,
    options: &ExportOptions,
    entries: usize,
) -> Result<Exported<ErrorTables>, CompensateError> {
    if !fitted.chain().is_serial() {
        return Err(CompensateError::Branches { what: "component errors of ISO 230-1" });
    }
    if !(2..=100_000).contains(&entries) {
        let value = entries as f64;
        return Err(CompensateError::Option { option: "entries", value, need: "2 to 100 000" });
    }
    let chain = fitted.chain();
    let (schema, mut conditions) = everything(fitted, &table_conditions(fitted, options))?;
    let mut predictor = fitted.bind(&schema)?;
    let ranges = ranges(fitted);
    let reference: Vec<f64> = ranges.iter().map(|(lower, upper)| 0.5 * (lower + upper)).collect();
    let all: Vec<Site> = (0..chain.site_count()).map(|k| chain.site_at(k)).collect();
    conditions.joints.copy_from_slice(&reference);
    let still = predictor.errors(&conditions).clone();
    let constant =
        all.iter().map(|&site| (site, still.get(site))).filter(|(_, value)| *value != 0.0).collect();
    let mut tables = Vec::new();
    for ((k, &joint), &(lower, upper)) in chain.movable().iter().enumerate().zip(&ranges) {
        let at: Vec<f64> =
            (0..entries).map(|i| lower + (upper - lower) * i as f64 / (entries - 1) as f64).collect();
        let mut columns = vec![Vec::with_capacity(entries); all.len()];
        for &q in &at {
            conditions.joints[k] = q;
            let moved = predictor.errors(&conditions);
            for (column, &site) in columns.iter_mut().zip(&all) {
                column.push(moved.get(site) - still.get(site));
            }
        }
        conditions.joints[k] = reference[k];
        let (sites, columns): (Vec<Site>, Vec<Vec<f64>>) = all
            .iter()
            .copied()
            .zip(columns)
            .filter(|(_, column)| column.iter().any(|v| v.abs() > NEGLIGIBLE))
            .unzip();
        if !sites.is_empty() {
            tables.push(ErrorTable { joint, at, sites, columns });
        }
    }
    let mut value = ErrorTables { reference, constant, tables };
    let rows = Reference::of(fitted, options)?;
    let projected = project(chain, &rows, &still, Some(&value))?;
    value.constant = all
        .iter()
        .map(|&site| (site, projected.constants.get(site)))
        .filter(|(_, value)| *value != 0.0)
        .collect();
    for (table, gain) in value.tables.iter_mut().zip(&projected.gains) {
        table.columns.iter_mut().flatten().for_each(|v| *v *= gain);
    }
    let mut broken = None;
    let found =
        judged(fitted, &rows, |row| match with_errors(chain, &value.errors(chain, &row.conditions.joints)) {
            Ok(real) => of_chain(&real, row),
            Err(error) => {
                broken = Some(error);
                (truepose_kinematics::Pose::IDENTITY, nalgebra::Vector3::zeros())
            }
        });
    if let Some(error) = broken {
        return Err(error);
    }
    let (remaining_error, comparison) = found?;
    let mut left_out: Vec<&'static str> = Vec::new();
    for effect in fitted.model().effects() {
        if !effect.needs().is_empty() && !left_out.contains(&effect.kind()) {
            left_out.push(effect.kind());
        }
    }
    Ok(Exported { value, left_out, remaining_error, comparison })
}
