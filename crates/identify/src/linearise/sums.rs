//! What accumulators make of all blocks: triangles, Gram matrices, rows by visits, and what is left of the measurements.

use super::accumulate::{WORTH_TWO_SUMS, WORTH_TWO_TRIANGLES, accumulate, by_blocks};
use super::blocks::{Blocks, batches};
use super::rows::collect;
use crate::{IdentifyError, NoiseModel, Residuals};
use nalgebra::{DMatrix, Vector3};
use rayon::prelude::*;
use truepose_errormodel::batch::Lanes;
use truepose_errormodel::lanes::LANES;
use truepose_errormodel::{Dataset, Equilibrium, ErrorModel, Visits};
use truepose_solvers::accumulator::{Factor, LeftOut, Triangular};
use truepose_solvers::{Gram, RankRule, Solution};

/// The triangular factor of `[A | r]` over all visits, over all columns or over these: as [`gram`], with all digits.
///
/// # Errors
/// When the model and the data do not fit, or a number is not finite.
pub fn triangular(
    model: &ErrorModel,
    data: &Dataset,
    visits: &Visits,
    noise: NoiseModel,
    coefficients: &[f64],
    columns: Option<&[usize]>,
) -> Result<Triangular, IdentifyError> {
    let width = columns.map_or(model.columns().len(), <[usize]>::len);
    let of = |range, threads| {
        triangle(Blocks::new(model, data, noise, coefficients, columns)?.on_threads(threads), visits, range)
    };
    let mut parts = by_blocks(visits, width, WORTH_TWO_TRIANGLES, of)?.into_iter();
    let mut whole = parts.next().unwrap_or_else(|| Triangular::new(width, 1));
    for part in parts {
        whole.merge(&part)?;
    }
    Ok(whole)
}

/// The triangular factor of all visits over all columns, or over these: in parallel over fixed blocks that are merged in order.
///
/// # Errors
/// As [`accumulate`].
pub fn factorise(
    model: &ErrorModel,
    data: &Dataset,
    visits: &Visits,
    noise: NoiseModel,
    coefficients: &[f64],
    columns: Option<&[usize]>,
) -> Result<Factor, IdentifyError> {
    Ok(triangular(model, data, visits, noise, coefficients, columns)?.into_factor())
}

/// The same over some of the visits, by one thread.
///
/// # Errors
/// As [`triangular`].
pub fn triangular_of(
    model: &ErrorModel,
    data: &Dataset,
    visits: &Visits,
    noise: NoiseModel,
    coefficients: &[f64],
    columns: Option<&[usize]>,
    which: impl Iterator<Item = usize> + Clone,
) -> Result<Triangular, IdentifyError> {
    triangle(Blocks::new(model, data, noise, coefficients, columns)?, visits, which)
}

fn triangle(
    blocks: Blocks<'_>,
    visits: &Visits,
    which: impl Iterator<Item = usize> + Clone,
) -> Result<Triangular, IdentifyError> {
    let Some(batches) = blocks.batches(visits, which.clone()) else {
        return accumulate(blocks.row_by_row()?, visits, which);
    };
    let mut triangle = Triangular::new(blocks.width(), 1);
    blocks.in_turn(&batches, |whole| {
        Ok(triangle.update_columns(&whole.active, whole.rows, whole.rows, &whole.numbers)?)
    })?;
    Ok(triangle)
}

/// The whitened rows of `[A | r]` over all visits, over all columns or over these, in the order of their blocks.
///
/// # Errors
/// When the model and the data do not fit.
pub fn dense(
    model: &ErrorModel,
    data: &Dataset,
    visits: &Visits,
    noise: NoiseModel,
    coefficients: &[f64],
    columns: Option<&[usize]>,
) -> Result<DMatrix<f64>, IdentifyError> {
    let mut blocks = Blocks::new(model, data, noise, coefficients, columns)?;
    let Some(batches) = blocks.batches(visits, 0..visits.len()) else {
        let rows = collect(model, data, visits, noise, coefficients)?;
        let a = columns.map_or_else(|| rows.a.clone(), |columns| rows.a.select_columns(columns));
        let width = a.ncols();
        let mut dense = a.insert_column(width, 0.0);
        dense.set_column(width, &rows.residual);
        return Ok(dense);
    };
    let wholes = blocks.wholes(&batches)?;
    let (rows, width) = (wholes.iter().map(|whole| whole.rows).sum(), blocks.width());
    let mut dense = DMatrix::zeros(rows, width + 1);
    let mut first = 0;
    for whole in wholes.iter().filter(|whole| whole.rows > 0) {
        let columns = whole.active.iter().copied().chain([width]);
        for (column, numbers) in columns.zip(whole.numbers.chunks_exact(whole.rows)) {
            dense.column_mut(column).as_mut_slice()[first..first + whole.rows].copy_from_slice(numbers);
        }
        first += whole.rows;
    }
    Ok(dense)
}

/// The rows of `[A | r]` by visits, for cross-validation of the linear fit; visits are its groups.
///
/// # Errors
/// When the model and the data do not fit, or a visit is longer than a block.
pub fn left_out(
    model: &ErrorModel,
    data: &Dataset,
    visits: &Visits,
    noise: NoiseModel,
    coefficients: &[f64],
    columns: Option<&[usize]>,
) -> Result<LeftOut, IdentifyError> {
    let mut blocks = Blocks::new(model, data, noise, coefficients, columns)?;
    let all = batches(data, visits, 0..visits.len());
    let batches = all.ok_or(IdentifyError::LongVisit { most: LANES })?;
    let wholes = blocks.wholes(&batches)?;
    let parts = wholes.iter().map(|w| (w.active.as_slice(), w.groups.as_slice(), w.numbers.as_slice()));
    Ok(LeftOut::new(blocks.width(), visits.len(), parts)?)
}

/// The Gram matrix of `[A | r]` over all visits, over all columns or over these: in parallel over fixed blocks, merged in order.
///
/// # Errors
/// When the model and the data do not fit.
pub fn gram(
    model: &ErrorModel,
    data: &Dataset,
    visits: &Visits,
    noise: NoiseModel,
    coefficients: &[f64],
    columns: Option<&[usize]>,
) -> Result<Gram, IdentifyError> {
    let width = columns.map_or(model.columns().len(), <[usize]>::len);
    let parts = by_blocks(visits, width, WORTH_TWO_SUMS, |range, _| {
        let mut blocks = Blocks::new(model, data, noise, coefficients, columns)?;
        let mut gram = Gram::new(blocks.width(), 1);
        match blocks.batches(visits, range.clone()) {
            Some(batches) => {
                for batch in &batches {
                    blocks.each(batch, |c| Ok(gram.update_columns(c.active, c.rows, LANES, c.numbers)?))?;
                }
            }
            None => {
                let mut lineariser = blocks.row_by_row()?;
                for visit in range {
                    gram.update_rows(lineariser.visit(&visits.rows[visit]).rows)?;
                }
            }
        }
        Ok(gram)
    })?;
    let mut parts = parts.into_iter();
    let mut whole = parts.next().unwrap_or_else(|| Gram::new(width, 1));
    whole.flush();
    for part in parts {
        whole.merge(&part)?;
    }
    Ok(whole)
}

/// The basic least squares of `[A | r]` over all visits by their Gram matrix, refined on the rows ([`Gram::solve_refined`]), which are kept for
/// that; none where it cannot be had, or where they are too many to be kept. x has an entry for each of these columns; the limit of the condition
/// number and the rule of the rank are those of `solve_refined`.
///
/// # Errors
/// When the model and the data do not fit, or a number is not finite.
pub fn refined(
    model: &ErrorModel,
    data: &Dataset,
    visits: &Visits,
    noise: NoiseModel,
    coefficients: &[f64],
    columns: Option<&[usize]>,
    (limit, rule): (f64, RankRule),
) -> Result<Option<Solution>, IdentifyError> {
    /// Numbers that are kept: 64 MB.
    const MOST: usize = 1 << 23;
    let mut blocks = Blocks::new(model, data, noise, coefficients, columns)?;
    let width = blocks.width();
    let numbers = 3 * (data.len() + data.orientation.iter().flatten().count());
    if numbers.saturating_mul(width + 1) > MOST {
        return Ok(None);
    }
    let Some(batches) = blocks.batches(visits, 0..visits.len()) else { return Ok(None) };
    let wholes = blocks.wholes(&batches)?;
    let mut gram = Gram::new(width, 1);
    for whole in &wholes {
        gram.update_columns(&whole.active, whole.rows, whole.rows, &whole.numbers)?;
    }
    gram.flush();
    let parts = wholes.iter().map(|whole| (whole.active.as_slice(), whole.rows, whole.numbers.as_slice()));
    Ok(gram.solve_refined(limit, rule, parts)?)
}

/// Residuals `y − y(c) − P J_e Φ δ` of every row, in metres and radians.
///
/// # Errors
/// When the model and the data do not fit.
pub fn left_over(
    model: &ErrorModel,
    data: &Dataset,
    coefficients: &[f64],
    change: &[f64],
) -> Result<Residuals, IdentifyError> {
    data.validate(model.chain())?;
    let bound = model.bind(&data.schema)?;
    let soft = Equilibrium::is_soft(model, data, coefficients)?;
    const ROWS: usize = 4 * LANES;
    let parts: Vec<Vec<f64>> = (0..data.len().div_ceil(ROWS))
        .into_par_iter()
        .map(|part| {
            let mut lanes = Lanes::new(bound.clone()).soft(soft);
            let rows: Vec<usize> = (part * ROWS..((part + 1) * ROWS).min(data.len())).collect();
            let mut numbers = vec![0.0; rows.len().div_ceil(LANES) * 6 * LANES];
            for (rows, numbers) in rows.chunks(LANES).zip(numbers.chunks_exact_mut(6 * LANES)) {
                lanes.gather(data, rows);
                lanes.settle(data, coefficients);
                lanes.left(data, change, numbers);
            }
            numbers
        })
        .collect();
    let mut residuals = Residuals {
        position: vec![Vector3::repeat(f64::NAN); data.len()],
        orientation: vec![None; data.len()],
    };
    for row in 0..data.len() {
        let block = &parts[row / ROWS][row % ROWS / LANES * 6 * LANES..][..6 * LANES];
        let at = |component: usize| block[component * LANES + row % LANES];
        match data.ray(row) {
            Some(w) => residuals.position[row] = w * (at(0) / w.norm_squared()),
            None => (0..3)
                .filter(|&k| !data.position[row][k].is_nan())
                .for_each(|k| residuals.position[row][k] = at(k)),
        }
        residuals.orientation[row] = data.orientation[row].map(|_| Vector3::new(at(3), at(4), at(5)));
    }
    Ok(residuals)
}
