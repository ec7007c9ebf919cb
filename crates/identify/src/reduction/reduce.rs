//! Which columns are kept: by the structural null space, then by that of the data.

use super::echelon::echelon;
use super::groups::{Cause, Dropped, Group, Reduction};
use super::priority::preference;
use super::structural::spread_factor;
use crate::IdentifyError;
use nalgebra::DMatrix;
use truepose_errormodel::{Dataset, ErrorModel};
use truepose_solvers::RankRule;
use truepose_solvers::accumulator::{ColumnScale, Factor};

/// Reduces by the structural null space and then by what the data, given as its triangular factor, leaves unexcited; both
/// linearised at these coefficients.
///
/// # Errors
/// When the model does not fit the data or a factorisation fails.
pub fn reduce(
    model: &ErrorModel,
    data: &Dataset,
    factor: &Factor,
    rule: RankRule,
    coefficients: &[f64],
) -> Result<Reduction, IdentifyError> {
    reduce_in_order(model, data, factor, rule, coefficients, &preference(model))
}

/// As [`reduce`], at a robot on which a reduction is known already: its kept columns are preferred to all others, so that
/// they stay.
///
/// # Errors
/// As [`reduce`].
pub fn reduce_further(
    model: &ErrorModel,
    data: &Dataset,
    factor: &Factor,
    rule: RankRule,
    coefficients: &[f64],
    known: &Reduction,
) -> Result<Reduction, IdentifyError> {
    let (mut order, others): (Vec<usize>, Vec<usize>) =
        preference(model).into_iter().partition(|column| known.kept.contains(column));
    order.extend(others);
    reduce_in_order(model, data, factor, rule, coefficients, &order)
}

fn reduce_in_order(
    model: &ErrorModel,
    data: &Dataset,
    factor: &Factor,
    rule: RankRule,
    coefficients: &[f64],
    order: &[usize],
) -> Result<Reduction, IdentifyError> {
    let scales: Vec<f64> = model.columns().iter().map(|column| column.scale).collect();
    let spread = spread_factor(model, data, factor, coefficients)?;
    let structural = spread.null_space(ColumnScale::Given(&scales), rule)?;
    let mut dropped = relations(&structural.basis, order, &scales, Cause::Structural);

    let left: Vec<usize> = (0..scales.len()).filter(|c| dropped.iter().all(|d| d.column != *c)).collect();
    let inner = factor.select(&left);
    let inner_scales: Vec<f64> = left.iter().map(|&c| scales[c]).collect();
    // Mostly the data excites all that is left, which the triangle's inverse shows without singular values.
    let sure = match rule {
        RankRule::Default => inner.certainly_full(ColumnScale::Given(&inner_scales))?,
        _ => None,
    };
    let (practical, unexcited) = match sure {
        Some(decision) => (decision, DMatrix::zeros(left.len(), 0)),
        None => {
            let found = inner.null_space(ColumnScale::Given(&inner_scales), rule)?;
            (found.decision, found.basis)
        }
    };
    let mut reduction = Reduction {
        kept: left,
        dropped: Vec::new(),
        groups: Vec::new(),
        structural: structural.decision,
        practical,
    };
    std::mem::swap(&mut reduction.dropped, &mut dropped);
    drop_more(&mut reduction, &unexcited, order, &scales, Cause::Unexcited);
    regroup(&mut reduction);
    Ok(reduction)
}

/// Relations of a null space over all columns.
fn relations(null: &DMatrix<f64>, order: &[usize], scales: &[f64], cause: Cause) -> Vec<Dropped> {
    let form = echelon(null, order);
    form.dropped
        .iter()
        .enumerate()
        .map(|(row, &column)| {
            let relation = (0..scales.len())
                .filter(|&j| j != column && form.relations[(row, j)].abs() > 1e-9)
                .map(|j| (j, tidy(form.relations[(row, j)] * scales[j] / scales[column])))
                .collect();
            Dropped { column, relation, cause }
        })
        .collect()
}

/// Snaps a coefficient that is a whole number but for round-off, so that groups read the same everywhere.
fn tidy(value: f64) -> f64 {
    let nearest = value.round();
    if nearest != 0.0 && (value - nearest).abs() < 1e-9 { nearest } else { value }
}

/// Drops further columns by a null space over the kept ones, and rewrites the relations of those dropped before.
fn drop_more(reduction: &mut Reduction, null: &DMatrix<f64>, order: &[usize], scales: &[f64], cause: Cause) {
    if null.ncols() == 0 {
        return;
    }
    let place: Vec<Option<usize>> =
        (0..scales.len()).map(|c| reduction.kept.iter().position(|&kept| kept == c)).collect();
    let inner_order: Vec<usize> = order.iter().filter_map(|&c| place[c]).collect();
    let inner_scales: Vec<f64> = reduction.kept.iter().map(|&c| scales[c]).collect();
    let kept = reduction.kept.clone();
    let more = relations(null, &inner_order, &inner_scales, cause).into_iter().map(|d| Dropped {
        column: kept[d.column],
        relation: d.relation.iter().map(|&(j, c)| (kept[j], c)).collect(),
        cause,
    });
    for new in more {
        for old in &mut reduction.dropped {
            // J^old = −Σ c_j J^j with J^new among them: put −Σ d_k J^k in its place.
            let Some(at) = old.relation.iter().position(|&(j, _)| j == new.column) else { continue };
            let (_, share) = old.relation.remove(at);
            for &(k, d) in &new.relation {
                match old.relation.iter_mut().find(|(j, _)| *j == k) {
                    Some((_, c)) => *c -= share * d,
                    None => old.relation.push((k, -share * d)),
                }
            }
            old.relation
                .retain(|&(j, c)| (c * scales[j] / scales[old.column]).abs() > 1e-9 || c.abs() > 1e-9);
        }
        reduction.kept.retain(|&c| c != new.column);
        reduction.dropped.push(new);
    }
}

/// β_j = ε_j − Σ_p c_pj ε_p for every kept column.
fn regroup(reduction: &mut Reduction) {
    reduction.dropped.sort_by_key(|d| d.column);
    for dropped in &mut reduction.dropped {
        dropped.relation.sort_by_key(|&(j, _)| j);
    }
    reduction.groups = reduction
        .kept
        .iter()
        .map(|&column| {
            let members = reduction
                .dropped
                .iter()
                .filter_map(|d| d.relation.iter().find(|(j, _)| *j == column).map(|&(_, c)| (d.column, -c)));
            Group { column, members: members.collect() }
        })
        .collect();
}
