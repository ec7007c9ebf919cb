//! All whitened rows in one matrix, for what has to see rows.

use super::lineariser::Lineariser;
use crate::{IdentifyError, NoiseModel};
use nalgebra::{DMatrix, DVector};
use truepose_errormodel::{Dataset, ErrorModel, Visits};

/// All whitened rows at once.
#[derive(Debug, Clone, PartialEq)]
pub struct Rows {
    /// A, rows × p.
    pub a: DMatrix<f64>,
    /// r, rows.
    pub residual: DVector<f64>,
    /// The visit of each row.
    pub visit: Vec<usize>,
}

/// The whitened residuals of all rows, in the order of [`collect`], without any column.
pub(crate) fn left_over_rows(
    model: &ErrorModel,
    data: &Dataset,
    visits: &Visits,
    noise: NoiseModel,
    coefficients: &[f64],
) -> Result<Rows, IdentifyError> {
    gathered(Lineariser::new(model, data, noise, coefficients)?.of_columns(&[]), visits)
}

/// All whitened rows as one matrix, for solvers that have to see rows.
///
/// # Errors
/// When the model and the data do not fit.
pub fn collect(
    model: &ErrorModel,
    data: &Dataset,
    visits: &Visits,
    noise: NoiseModel,
    coefficients: &[f64],
) -> Result<Rows, IdentifyError> {
    gathered(Lineariser::new(model, data, noise, coefficients)?, visits)
}

fn gathered(mut lineariser: Lineariser<'_>, visits: &Visits) -> Result<Rows, IdentifyError> {
    let width = lineariser.width();
    let (mut flat, mut visit) = (Vec::new(), Vec::new());
    for (k, rows) in visits.rows.iter().enumerate() {
        let block = lineariser.visit(rows);
        flat.extend_from_slice(block.rows);
        visit.resize(visit.len() + block.source.len(), k);
    }
    let whole = DMatrix::from_row_slice(visit.len(), width, &flat);
    let residual = whole.column(width - 1).into_owned();
    Ok(Rows { a: whole.remove_column(width - 1), residual, visit })
}
