//! Reduction to what can be identified (Eq. 8–16): c = B β.
//!
//! | symbol | here | shape | unit |
//! | --- | --- | --- | --- |
//! | c | coefficients of the model | p | each its own |
//! | β | grouped errors | r | as the kept column |
//! | C | relations of dropped columns | (p − r) × p | unscaled |
//!
//! A dropped column p with `J^p = −Σ_j c_j J^j` is left at zero and its error passes into the kept ones:
//! `β_j = ε_j − c_j ε_p`. So B is a selection, and what it selects from is said in words, group by group.
//!
//! Two null spaces are kept apart: the *structural* one, over postures spread within the limits, that no data on this
//! robot with this kind of measurement can fill; and the *practical* one, further directions that this data set
//! leaves unexcited.

mod echelon;
mod grouped;
mod priority;
mod structural;
mod words;

pub use echelon::{Echelon, echelon};
pub use grouped::grouped;
pub use priority::{column_word, preference};
pub use structural::{joint_ranges, spread_factor};
pub use words::group_words;

use crate::IdentifyError;
use nalgebra::DMatrix;
use truepose_errormodel::{Dataset, ErrorModel};
use truepose_solvers::accumulator::{ColumnScale, Factor};
use truepose_solvers::{RankDecision, RankRule};

/// Which columns are kept, and what each kept coefficient stands for.
#[derive(Debug, Clone, PartialEq)]
pub struct Reduction {
    /// Kept columns, ascending.
    pub kept: Vec<usize>,
    /// Dropped columns and why.
    pub dropped: Vec<Dropped>,
    /// What each kept coefficient stands for, in the order of `kept`.
    pub groups: Vec<Group>,
    /// How the structural rank was decided.
    pub structural: RankDecision,
    /// How the rank of the data, on the structurally kept columns, was decided.
    pub practical: RankDecision,
}

/// A column that is left at zero.
#[derive(Debug, Clone, PartialEq)]
pub struct Dropped {
    /// The column.
    pub column: usize,
    /// Kept columns j with their c_j in `J^p = −Σ_j c_j J^j`; empty when the column has no effect at all.
    pub relation: Vec<(usize, f64)>,
    /// Whose null space it belongs to.
    pub cause: Cause,
}

/// Why a column cannot be told from others.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Cause {
    /// No data can tell them apart on this robot with this kind of measurement.
    Structural,
    /// This data set excites their difference not at all.
    Unexcited,
}

/// A grouped error: the kept column and what passes into it.
#[derive(Debug, Clone, PartialEq)]
pub struct Group {
    /// The kept column.
    pub column: usize,
    /// Dropped columns p with −c_j: β = ε_kept + Σ (−c_j) ε_p.
    pub members: Vec<(usize, f64)>,
}

impl Reduction {
    /// Nothing is reduced away: for models whose columns are known to be independent.
    pub fn none(columns: usize) -> Self {
        let clear = RankDecision {
            rank: columns,
            tolerance: 0.0,
            last_kept: 1.0,
            first_dropped: 0.0,
            gap: f64::INFINITY,
            dropped: 0,
        };
        Reduction {
            kept: (0..columns).collect(),
            dropped: Vec::new(),
            groups: (0..columns).map(|column| Group { column, members: Vec::new() }).collect(),
            structural: clear,
            practical: clear,
        }
    }

    /// The rank: how many grouped errors there are.
    pub fn rank(&self) -> usize {
        self.kept.len()
    }

    /// The columns of a p-column matrix that are kept.
    pub fn select(&self, matrix: &DMatrix<f64>) -> DMatrix<f64> {
        matrix.select_columns(&self.kept)
    }

    /// β of the model's coefficients, when the dropped ones are zero.
    pub fn grouped(&self, coefficients: &[f64]) -> Vec<f64> {
        self.kept.iter().map(|&column| coefficients[column]).collect()
    }

    /// β as the model's coefficients: kept ones in their places, zero elsewhere.
    pub fn expand(&self, grouped: &[f64], columns: usize) -> Vec<f64> {
        let mut coefficients = vec![0.0; columns];
        for (&column, &value) in self.kept.iter().zip(grouped) {
            coefficients[column] = value;
        }
        coefficients
    }
}

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

#[cfg(test)]
mod tests;
