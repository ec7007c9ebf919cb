//! All whitened rows in one matrix, for what has to see rows.

use super::blocks::Blocks;
use super::lineariser::Lineariser;
use crate::{IdentifyError, NoiseModel};
use nalgebra::{DMatrix, DVector};
use std::ops::Range;
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

/// All whitened rows, number by number and visit by visit: m or rad over their standard deviations, as [`crate::NoiseModel`] whitens them.
#[derive(Debug, Clone, PartialEq)]
pub struct ByVisits {
    /// `[a_1 … a_p, r]` of every number, (p + 1) × numbers: per unit of the coefficient of each column; in no fixed order within a visit.
    pub numbers: DMatrix<f64>,
    /// The numbers of each visit, in the order of visits; none of one without measurements.
    pub visits: Vec<Range<usize>>,
}

/// The whitened rows of `[A | r]`, A = W P J_e Φ, over these columns of the model in this order, linearised at these coefficients; visit by visit.
///
/// # Errors
/// When the model and the data do not fit.
pub fn by_visits(
    model: &ErrorModel,
    data: &Dataset,
    visits: &Visits,
    noise: NoiseModel,
    coefficients: &[f64],
    columns: &[usize],
) -> Result<ByVisits, IdentifyError> {
    let height = columns.len() + 1;
    let mut blocks = Blocks::new(model, data, noise, coefficients, Some(columns))?;
    let Some(batches) = blocks.batches(visits, 0..visits.len()) else {
        let mut lineariser = Lineariser::new(model, data, noise, coefficients)?.of_columns(columns);
        let (mut flat, mut ranges) = (Vec::new(), Vec::new());
        for rows in &visits.rows {
            let first = flat.len() / height;
            flat.extend_from_slice(lineariser.visit(rows).rows);
            ranges.push(first..flat.len() / height);
        }
        return Ok(ByVisits {
            numbers: DMatrix::from_vec(height, flat.len() / height, flat),
            visits: ranges,
        });
    };
    let wholes = blocks.wholes(&batches)?;
    let mut counts = vec![0; visits.len()];
    wholes.iter().flat_map(|whole| &whole.groups).for_each(|&visit| counts[visit] += 1);
    let mut end = 0;
    let ranges: Vec<Range<usize>> = counts
        .iter()
        .map(|count| {
            end += count;
            end - count..end
        })
        .collect();
    let mut next: Vec<usize> = ranges.iter().map(|range| range.start).collect();
    let mut numbers = DMatrix::zeros(height, end);
    let into = numbers.as_mut_slice();
    for whole in wholes.iter().filter(|whole| whole.rows > 0) {
        let mut place = |&visit: &usize| {
            next[visit] += 1;
            (next[visit] - 1) * height
        };
        let places: Vec<usize> = whole.groups.iter().map(&mut place).collect();
        let active = whole.active.iter().copied().chain([height - 1]);
        for (column, numbers) in active.zip(whole.numbers.chunks_exact(whole.rows)) {
            places.iter().zip(numbers).for_each(|(place, number)| into[place + column] = *number);
        }
    }
    Ok(ByVisits { numbers, visits: ranges })
}
