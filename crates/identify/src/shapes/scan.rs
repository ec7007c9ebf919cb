//! The first look: every shape parameter over its whole range, one after the other, the others as found so far.

use super::grid::values;
use super::picture::Picture;
use super::refine::{descend, left};
use crate::IdentifyError;
use nalgebra::DMatrix;
use rayon::prelude::*;
use truepose_errormodel::NonlinearParameter;

/// Visits on which the first look is taken.
pub(super) const VISITS: usize = 1500;
/// Valleys that are descended into.
const VALLEYS: usize = 3;

/// The best parameters over their ranges.
pub(super) fn best(
    picture: &Picture<'_>,
    shapes: &[NonlinearParameter],
    start: &[f64],
) -> Result<Vec<f64>, IdentifyError> {
    let mut theta = start.to_vec();
    let owner = &picture.trial.owner;
    let mut placed = vec![false; picture.trial.len()];
    // With several parameters the first was looked for while the others were absent: once more, then.
    for _ in 0..if shapes.len() > 1 { 2 } else { 1 } {
        for k in 0..shapes.len() {
            let others: Vec<usize> = (0..placed.len()).filter(|&e| placed[e] && e != owner[k]).collect();
            let beside = beside(picture, &others, &theta)?;
            theta = along(picture, shapes, &theta, k, &beside)?;
            placed[owner[k]] = true;
        }
    }
    Ok(theta)
}

/// What the effects that were placed already explain.
fn beside(picture: &Picture<'_>, others: &[usize], theta: &[f64]) -> Result<DMatrix<f64>, IdentifyError> {
    let mut all = DMatrix::zeros(picture.target.len(), 0);
    for &effect in others {
        all = beside_each_other(&all, &picture.beyond(picture.columns(effect, theta)?));
    }
    Ok(all)
}

fn beside_each_other(left: &DMatrix<f64>, right: &DMatrix<f64>) -> DMatrix<f64> {
    let mut both = left.clone().resize_horizontally(left.ncols() + right.ncols(), 0.0);
    both.columns_mut(left.ncols(), right.ncols()).copy_from(right);
    both
}

/// One parameter over its grid; the best valleys are descended into.
fn along(
    picture: &Picture<'_>,
    shapes: &[NonlinearParameter],
    theta: &[f64],
    k: usize,
    beside: &DMatrix<f64>,
) -> Result<Vec<f64>, IdentifyError> {
    let grid = values(&shapes[k], picture.data, picture.chain());
    let with = |value: f64| {
        let mut trial = theta.to_vec();
        trial[k] = value;
        trial
    };
    let effect = picture.trial.owner[k];
    let unexplained = |trial: &[f64]| {
        let columns = picture.beyond(picture.columns(effect, trial)?);
        left(&beside_each_other(beside, &columns), &picture.target)
    };
    let heights: Vec<f64> =
        grid.par_iter().map(|&value| unexplained(&with(value))).collect::<Result<_, _>>()?;
    let lowest = |a: &usize, b: &usize| heights[*a].total_cmp(&heights[*b]);
    let mut valleys: Vec<usize> = (0..grid.len())
        .filter(|&i| {
            (i == 0 || heights[i] <= heights[i - 1]) && heights.get(i + 1).is_none_or(|h| heights[i] <= *h)
        })
        .collect();
    valleys.sort_by(lowest);
    let mut best: Option<(f64, Vec<f64>)> = None;
    for &valley in valleys.iter().take(VALLEYS) {
        let found = descend(picture, shapes, &with(grid[valley]), &[k], false)?;
        let height = unexplained(&found)?;
        if best.as_ref().is_none_or(|b| height < b.0) {
            best = Some((height, found));
        }
    }
    Ok(best.map_or_else(|| theta.to_vec(), |b| b.1))
}
