//! A candidate beside the model: normal equations of `[A | X | y]` over any part of the observations.
//!
//! ```text
//! G_S = Σ_{i∈S} z_iᵀ z_i,   Z = V^{-1/2} [A | X | y],   (G_S + P) [β; γ] = g_S
//! ```
//!
//! | symbol | here | shape |
//! | --- | --- | --- |
//! | A, X | columns of the model and of the candidate, in m or rad per expected size | m × r, m × k |
//! | G_S, g_S | Gram matrix of the columns, and its last column, over the observations S | n × n, n |
//! | P | [`precision`]: what the priors of β and γ add | n × n |
//!
//! Every question about a candidate is one of these: its likelihood (S: all observations), its prediction of a fold (S: all others), its
//! estimate on a half (S: the half), an error without some effects (fewer columns of A). The score test of a screen
//! ([`crate::problem::projection`]) is the first step of the same equations with A eliminated once.

use crate::error::DiscoverError;
use crate::statistics::product::{cholesky, gram_matrix};
use crate::statistics::triangular::inverse_lower;
use nalgebra::{Cholesky, DMatrix, DVector, Dyn};
use std::ops::Range;
use truepose_solvers::kernels;

/// Whitened rows of `[A | X | y]`, with their Gram matrix.
#[derive(Clone)]
pub(crate) struct Equations {
    white: DMatrix<f64>,
    gram: DMatrix<f64>,
}

impl Equations {
    /// From whitened rows.
    pub fn new(white: DMatrix<f64>) -> Self {
        let gram = gram_matrix(&white);
        Equations { white, gram }
    }

    /// Whitened `[A | X | y]`.
    pub fn white(&self) -> &DMatrix<f64> {
        &self.white
    }

    /// G over all observations.
    pub fn all(&self) -> &DMatrix<f64> {
        &self.gram
    }

    /// G over these observations, summed: a column that they do not see has no rounding of the others in it.
    pub fn of(&self, observations: &[usize]) -> DMatrix<f64> {
        gram_matrix(&self.white.select_rows(observations))
    }

    /// G over all but these observations.
    pub fn without(&self, observations: &[usize]) -> DMatrix<f64> {
        &self.gram - self.of(observations)
    }
}

/// The Gram matrix of `[A_s | X | y]` from that of `[A | y]`: `stay` are the columns s, `along` is `[A | y]ᵀ X` (r + 1 rows) and
/// `own` is `XᵀX`.
pub(crate) fn bordered(
    gram: &DMatrix<f64>,
    stay: &[usize],
    along: &DMatrix<f64>,
    own: &DMatrix<f64>,
) -> DMatrix<f64> {
    let (s, k) = (stay.len(), own.ncols());
    let of_model: Vec<usize> = stay.iter().copied().chain([gram.ncols() - 1]).collect();
    let place = |at: usize| if at < s { at } else { s + k };
    let mut whole = DMatrix::zeros(s + k + 1, s + k + 1);
    for (j, &column) in of_model.iter().enumerate() {
        for (i, &row) in of_model.iter().enumerate() {
            whole[(place(i), place(j))] = gram[(row, column)];
        }
        for i in 0..k {
            whole[(s + i, place(j))] = along[(column, i)];
            whole[(place(j), s + i)] = along[(column, i)];
        }
    }
    whole.view_mut((s, s), (k, k)).copy_from(own);
    whole
}

/// P: that of the model's prior (r × r) for its columns `stay`, and for each of k candidate's coefficients a standard deviation of `width` expected sizes.
pub(crate) fn precision(of_model: &DMatrix<f64>, stay: &[usize], k: usize, width: f64) -> DMatrix<f64> {
    let s = stay.len();
    let mut precision = DMatrix::zeros(s + k, s + k);
    precision.view_mut((0, 0), (s, s)).copy_from(&of_model.select_rows(stay).select_columns(stay));
    (s..s + k).for_each(|at| precision[(at, at)] = 1.0 / (width * width));
    precision
}

/// `(G + P) x = g` of a Gram matrix whose last column is that of y, in scaled unknowns.
pub(crate) fn solved(
    gram: &DMatrix<f64>,
    precision: &DMatrix<f64>,
) -> Result<(DVector<f64>, Scaled), DiscoverError> {
    let n = gram.ncols() - 1;
    let scale: Vec<f64> = (0..n)
        .map(|k| {
            let size = gram[(k, k)] + precision[(k, k)];
            if size > 0.0 { 1.0 / size.sqrt() } else { 1.0 }
        })
        .collect();
    // Its lower triangle.
    let normal = |ridge: f64| {
        DMatrix::from_fn(n, n, |i, j| match i >= j {
            true => {
                let own = (gram[(i, j)] + precision[(i, j)]) * scale[i] * scale[j];
                if i == j { own + ridge } else { own }
            }
            false => 0.0,
        })
    };
    let right = DVector::from_fn(n, |i, _| gram[(i, n)] * scale[i]);
    // Columns that the data cannot distinguish at all stay where the prior holds them.
    let mut ridge = 0.0;
    for _ in 0..8 {
        if let Some(factor) = cholesky(normal(ridge)) {
            let solution = factor.solve(&right).component_mul(&DVector::from_column_slice(&scale));
            if solution.iter().all(|v| v.is_finite()) {
                return Ok((solution, Scaled { factor, scale }));
            }
        }
        ridge = if ridge > 0.0 { 10.0 * ridge } else { 1e-13 };
    }
    Err(truepose_identify::IdentifyError::NoAnswer {
        solver: "generalized least squares".into(),
        status: "the columns of the model are not finite or all alike".into(),
    }
    .into())
}

/// `‖y − [A | X] x‖²`, whitened, from the Gram matrix.
pub(crate) fn squares(gram: &DMatrix<f64>, solution: &DVector<f64>) -> f64 {
    let n = solution.len();
    let squares = gram[(n, n)] - 2.0 * gram.view((0, n), (n, 1)).dot(solution)
        + (gram.view((0, 0), (n, n)) * solution).dot(solution);
    squares.max(0.0)
}

/// A Cholesky factor of scaled normal equations.
pub(crate) struct Scaled {
    factor: Cholesky<f64, Dyn>,
    scale: Vec<f64>,
}

impl Scaled {
    /// How many of these unknowns, whose prior is diagonal, the data determines: Σ 1 − prior · covariance.
    pub fn determined(&self, which: Range<usize>, precision: &DMatrix<f64>) -> f64 {
        let (first, n) = (which.start, self.scale.len());
        // Of L⁻¹ e only what is below e is not zero.
        let below = self.factor.l_dirty().view((first, first), (n - first, n - first)).into_owned();
        let inverse = inverse_lower(&below);
        let held = which.zip(inverse.column_iter());
        held.map(|(at, half)| 1.0 - precision[(at, at)] * half.norm_squared() * self.scale[at].powi(2)).sum()
    }

    /// `L⁻¹ S H` of columns H, n × k, with S the scale of each unknown.
    pub fn half(&self, mut columns: DMatrix<f64>) -> DMatrix<f64> {
        columns.row_iter_mut().zip(&self.scale).for_each(|(mut row, &scale)| row *= scale);
        kernels::solve_lower_many(&self.factor.l(), &mut columns);
        columns
    }

    /// The covariance of the unknowns from this one on.
    pub fn covariance(&self, first: usize) -> DMatrix<f64> {
        let n = self.scale.len();
        // Of L⁻¹ e only what is below e is not zero.
        let mut half = DMatrix::identity(n - first, n - first);
        let lower = self.factor.l_dirty();
        lower.view((first, first), (n - first, n - first)).solve_lower_triangular_mut(&mut half);
        let mut covariance = gram_matrix(&half);
        for i in 0..n - first {
            for j in 0..n - first {
                covariance[(i, j)] *= self.scale[first + i] * self.scale[first + j];
            }
        }
        covariance
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::problem::synthetic::wave;
    use crate::statistics::product::cross;

    fn rows() -> DMatrix<f64> {
        DMatrix::from_fn(40, 6, |i, j| wave(17 * i + 5 * j))
    }

    #[test]
    fn parts_of_the_observations_add_up() {
        let equations = Equations::new(rows());
        let part: Vec<usize> = (0..40).filter(|i| i % 3 == 0).collect();
        let rest: Vec<usize> = (0..40).filter(|i| i % 3 != 0).collect();
        assert!((equations.of(&part) + equations.of(&rest) - equations.all()).amax() < 1e-12);
        assert!((equations.without(&part) - equations.of(&rest)).amax() < 1e-12);
    }

    #[test]
    fn a_bordered_gram_matrix_is_that_of_the_chosen_columns() {
        let all = rows();
        // [A | y] with three columns of A, two of X.
        let (model, x) = (all.select_columns(&[0, 1, 2, 5]), all.columns(3, 2).into_owned());
        let gram = bordered(&gram_matrix(&model), &[0, 2], &cross(&model, &x), &gram_matrix(&x));
        assert!((gram - gram_matrix(&all.select_columns(&[0, 2, 3, 4, 5]))).amax() < 1e-12);
    }

    #[test]
    fn a_solution_is_that_of_least_squares_with_the_priors_rows() {
        let (all, deviation) = (rows(), 0.3f64);
        let precision = DMatrix::from_diagonal_element(5, 5, deviation.powi(-2));
        let (solution, factor) = solved(&gram_matrix(&all), &precision).unwrap();
        let mut tall = all.clone().resize_vertically(45, 0.0);
        (0..5).for_each(|k| tall[(40 + k, k)] = 1.0 / deviation);
        let (a, y) = (tall.columns(0, 5).into_owned(), tall.column(5).into_owned());
        let expected = a.clone().svd(true, true).solve(&y, 0.0).unwrap();
        assert!((&solution - expected).amax() < 1e-12);
        let covariance = a.tr_mul(&a).try_inverse().unwrap();
        assert!((factor.covariance(2) - covariance.view((2, 2), (3, 3))).amax() < 1e-12);
        let left = all.column(5) - all.columns(0, 5) * &solution;
        assert!((squares(&gram_matrix(&all), &solution) - left.norm_squared()).abs() < 1e-11);
        let taken: f64 = (0..5).map(|k| 1.0 - precision[(k, k)] * covariance[(k, k)]).sum();
        assert!((factor.determined(0..5, &precision) - taken).abs() < 1e-12);
    }

    #[test]
    fn columns_that_are_one_share_what_they_explain() {
        let mut all = rows();
        let twin = all.column(0).into_owned();
        all.set_column(1, &twin);
        let (solution, _) = solved(&gram_matrix(&all), &DMatrix::zeros(5, 5)).unwrap();
        let left = all.column(5) - all.columns(0, 5) * &solution;
        assert!(left.dot(&twin).abs() < 1e-6 && solution.iter().all(|v| v.is_finite()));
    }
}
