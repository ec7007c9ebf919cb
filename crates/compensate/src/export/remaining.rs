//! What an export cannot carry, and the error that is left without it.
//!
//! The error left is the distance between the fitted model and the export at the configurations of the fit, or where it holds none at
//! configurations spread over the joints' ranges, under the caller's conditions or over all that the fit has seen.

use super::comparison::{Comparison, compared};
use super::reference::{Reference, Row};
use crate::CompensateError;
use nalgebra::Vector3;
use truepose_errormodel::FittedModel;
use truepose_kinematics::Pose;

/// Distance between the fitted model and an export, m.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RemainingError {
    /// Root of the mean square.
    pub rms: f64,
    /// Largest.
    pub max: f64,
}

/// An export with what it lacks.
#[derive(Debug, Clone, PartialEq)]
pub struct Exported<T> {
    /// The export.
    pub value: T,
    /// Families of the model's effects that it does not carry, each once.
    pub left_out: Vec<&'static str>,
    /// The error left without them.
    pub remaining_error: RemainingError,
    /// Its accuracy beside the nominal robot and the model.
    pub comparison: Comparison,
}

impl<T> Exported<T> {
    /// What the export lacks and what that costs, a sentence a line.
    pub fn statement(&self) -> Vec<String> {
        let lacks = if self.left_out.is_empty() {
            "carries every effect of the fit".into()
        } else {
            format!(
                "cannot carry: {}; the geometry is the least-squares projection of the full model",
                self.left_out.join(", ")
            )
        };
        let RemainingError { rms, max } = self.remaining_error;
        let left = format!(
            "remaining error over the range of the fit: RMS {}, max {}",
            in_millimetres(rms),
            in_millimetres(max)
        );
        let mut lines = vec![lacks, left];
        lines.extend(self.comparison.statement());
        lines
    }
}

fn in_millimetres(metres: f64) -> String {
    if metres < 1e-9 { "below 1 nm".into() } else { format!("{:.6} mm", 1e3 * metres) }
}

/// Holds an export against the model and the nominal robot; `exported` is its tool at a row, and the row's target on it.
///
/// # Errors
/// [`CompensateError::WorseThanNominal`].
pub(super) fn judged(
    fitted: &FittedModel,
    reference: &Reference,
    mut exported: impl FnMut(&Row) -> (Pose, Vector3<f64>),
) -> Result<(RemainingError, Comparison), CompensateError> {
    let comparison = compared(fitted.chain(), reference, &mut exported);
    if comparison.worse() {
        let Comparison { nominal, export, .. } = comparison;
        return Err(CompensateError::WorseThanNominal { nominal, export });
    }
    let (mut sum, mut max) = (0.0, 0.0);
    for row in &reference.rows {
        let (tool, point) = exported(row);
        let off = (row.point - tool.apply(&point)).norm();
        sum += off * off;
        max = f64::max(max, off);
    }
    let rms = (sum / reference.rows.len().max(1) as f64).sqrt();
    Ok((RemainingError { rms, max }, comparison))
}

/// Families of the effects that are not constant generalized errors.
pub(super) fn not_constant(fitted: &FittedModel) -> Vec<&'static str> {
    let model = fitted.model();
    let mut left: Vec<&'static str> = Vec::new();
    for (k, effect) in model.effects().iter().enumerate() {
        let own = model.columns_of(k);
        let mut columns = model.columns()[own.clone()].iter().zip(&fitted.coefficients()[own]);
        let constant = columns.all(|(column, &value)| column.site.is_some() || value == 0.0);
        if !constant && !left.contains(&effect.kind()) {
            left.push(effect.kind());
        }
    }
    left
}
