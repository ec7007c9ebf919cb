//! Residuals of visits by the robust fit of all others, without solving again.
//!
//! e_g = r_g + P_g w_g r_g,  V_g = I + P_g,  P_g = M_g (I − K_g M_g)⁻¹,  M_g = A_g D⁻¹ A_gᵀ
//! D = Σ A_gᵀ K_g A_g,  K_g = w_g I + (w'(t_g) / (t_g n_g σ²)) r_g r_gᵀ
//!
//! | symbol | name | shape | unit |
//! | --- | --- | --- | --- |
//! | r_g, A_g | whitened residuals and rows of a visit | n_g, n_g × p | 1 |
//! | w_g, t_g | factor that the loss put on the weights of its rows, and where it was taken: u_g / σ | 1 | 1 |
//! | D, K_g | second derivative of the sum of losses, and what a visit adds to it | p × p, n_g × n_g | 1 |
//! | e_g | residuals of the visit by the fit without it, to first order of the change in all other weights | n_g | 1 |
//! | V_g | covariance of e_g over σ²: noise of the visit and uncertainty of the fit | n_g × n_g | 1 |
//!
//! Without a loss, K_g = I, and this is the exact formula of Cook and Weisberg, *Residuals and Influence in Regression* (1982), §2.2; with one it
//! is one Newton step of the estimate (Huber and Ronchetti 2009, §7.6). A visit of weight 0 was left out already: its residual is larger than the
//! noise by the leverage, that of a visit that the fit rests on is smaller. Where D is not positive definite the fit is no minimum that
//! the data determines.

use crate::accumulator::{ColumnScale, Factor};
use crate::dense::solve_upper_transposed;
use crate::{LeastSquares, RankRule, SolveError};
use nalgebra::{DMatrix, DVector};

/// What the fit without a visit leaves of it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct LeftOut {
    /// eᵀ V⁻¹ e: σ² χ² of as many degrees of freedom as the visit has rows.
    pub square: f64,
    /// ln det V.
    pub log_determinant: f64,
    /// Rows of the visit that have a weight.
    pub rows: usize,
}

/// How a loss weighs a visit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Weighting {
    /// w_g.
    pub factor: f64,
    /// w'(t_g) / (t_g n_g σ²), at most zero.
    pub slope: f64,
}

impl Weighting {
    /// As measured.
    pub const PLAIN: Self = Self { factor: 1.0, slope: 0.0 };
}

/// Each group of rows as the fit without it leaves it; none for a visit without which a direction is lost, or without rows that count.
/// Nothing where the fit is no minimum. `residual` holds W^{1/2} (A x − y).
pub(super) fn left_out(
    problem: &LeastSquares<'_>,
    groups: &[Vec<usize>],
    residual: &DVector<f64>,
    weighting: &[Weighting],
) -> Result<Option<Vec<Option<LeftOut>>>, SolveError> {
    let mut weights: Vec<f64> = (0..problem.rows()).map(|row| problem.root_weight(row).powi(2)).collect();
    for (group, by) in groups.iter().zip(weighting) {
        group.iter().for_each(|row| weights[*row] *= by.factor);
    }
    let factor = Factor::of(&problem.with_weights(&weights))?;
    let pivoted = factor.solve_pivoted(0, ColumnScale::Norms, RankRule::Default)?;
    let kept = pivoted.info.kept.unwrap_or_else(|| (0..problem.columns()).collect());
    let triangle = factor.select(&kept).r;
    // In coordinates in which Aᵀ W A is one.
    let visits: Vec<(DMatrix<f64>, DVector<f64>)> = groups
        .iter()
        .map(|group| {
            let rows: Vec<usize> =
                group.iter().copied().filter(|row| problem.root_weight(*row) > 0.0).collect();
            let mut reached = DMatrix::zeros(kept.len(), rows.len());
            for (k, &row) in rows.iter().enumerate() {
                let of_row: Vec<f64> =
                    kept.iter().map(|&column| problem.root_weight(row) * problem.a[(row, column)]).collect();
                reached.set_column(k, &solve_upper_transposed(&triangle, &of_row));
            }
            (reached, DVector::from_fn(rows.len(), |k, _| residual[rows[k]]))
        })
        .collect();
    let mut second = DMatrix::identity(kept.len(), kept.len());
    for ((reached, residual), by) in visits.iter().zip(weighting).filter(|(_, by)| by.slope < 0.0) {
        let pulled = reached * residual;
        second.ger(by.slope, &pulled, &pulled, 1.0);
    }
    let Some(second) = second.cholesky() else { return Ok(None) };
    let leave = |((reached, residual), &by): (&(DMatrix<f64>, DVector<f64>), &Weighting)| {
        let leverage = reached.tr_mul(&second.solve(reached));
        without(&leverage, residual, by)
    };
    Ok(Some(visits.iter().zip(weighting).map(leave).collect()))
}

fn without(leverage: &DMatrix<f64>, residual: &DVector<f64>, by: Weighting) -> Option<LeftOut> {
    /// Share of a direction that has to be known without the visit: half the digits.
    const LEAST: f64 = 1e-8;
    let rows = residual.len();
    if rows == 0 {
        return None;
    }
    let own = DMatrix::identity(rows, rows) * by.factor + residual * residual.transpose() * by.slope;
    let split = (DMatrix::identity(rows, rows) - own * leverage).lu();
    if split.determinant().abs() < LEAST {
        return None;
    }
    let reach = leverage * split.try_inverse()?;
    let error = residual + &reach * residual * by.factor;
    let spread = (DMatrix::identity(rows, rows) + reach).cholesky()?;
    let log_determinant = 2.0 * spread.l_dirty().diagonal().iter().map(|d| d.ln()).sum::<f64>();
    Some(LeftOut { square: error.dot(&spread.solve(&error)), log_determinant, rows })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{PivotedQr, Solver};

    /// Against a fit without the rows, with one visit that the loss had left out and one of half the weight.
    #[test]
    fn the_formula_is_the_fit_without_the_visit() {
        let wave = |i: usize, j: usize| ((i * 19 + j * 31 + i * j) as f64 * 0.77).sin();
        let a = DMatrix::from_fn(24, 4, wave);
        let y = DVector::from_fn(24, |i, _| wave(i, 50));
        let groups: Vec<Vec<usize>> = (0..8).map(|g| vec![3 * g, 3 * g + 1, 3 * g + 2]).collect();
        let factors = [1.0, 0.0, 0.5, 1.0, 1.0, 1.0, 1.0, 1.0];
        let weights: Vec<f64> = (0..24).map(|i| factors[i / 3]).collect();
        let problem = LeastSquares::new(&a, &y);
        let x = PivotedQr::default().solve(&problem.with_weights(&weights)).unwrap().x;
        let weighting: Vec<Weighting> =
            factors.iter().map(|&factor| Weighting { factor, slope: 0.0 }).collect();
        let found = left_out(&problem, &groups, &problem.residual(&x), &weighting).unwrap().unwrap();
        for (g, group) in groups.iter().enumerate() {
            let mut others = weights.clone();
            group.iter().for_each(|i| others[*i] = 0.0);
            let x = PivotedQr::default().solve(&problem.with_weights(&others)).unwrap().x;
            let error = problem.residual(&x).rows(3 * g, 3).into_owned();
            let gram = a.tr_mul(&DMatrix::from_fn(24, 4, |i, j| others[i] * a[(i, j)]));
            let rows = a.rows(3 * g, 3).into_owned();
            let spread = DMatrix::identity(3, 3) + &rows * gram.try_inverse().unwrap() * rows.transpose();
            let square = error.dot(&(spread.clone().try_inverse().unwrap() * &error));
            let left = found[g].unwrap();
            assert!((left.square / square - 1.0).abs() < 1e-9, "visit {g}");
            assert!((left.log_determinant - spread.determinant().ln()).abs() < 1e-9, "visit {g}");
        }
    }
}
