//! The generated family: problems of which everything is known.
//!
//! ```text
//! A = √m U diag(d) Vᵀ S⁻¹,  d_1 … d_p = 1 … 1/κ,   y = A x + e,   e ~ N(0, 1), wrong visits far off
//! ```
//!
//! | symbol | name | shape |
//! | --- | --- | --- |
//! | U, V | random orthonormal columns | m × p, p × p |
//! | κ | condition number of the scaled matrix | 1 |
//! | S | true sizes of the unknowns, over six decades; the prior given to a solver is off by a factor of about 1.5 | p, diagonal |
//! | x | truth: S times unit normals; whole effects of three columns are zero when it is sparse | p |
//!
//! A row is in units of its noise; the noise is given relative to the signal. A visit has two rows, and one that is wrong is
//! wrong in both.

use crate::prelude::*;
use truepose_solvers::Bounds;

/// Unknowns p.
pub const UNKNOWNS: usize = 24;
/// Columns of one effect.
const EFFECT: usize = 3;
/// Rows of one visit.
const VISIT: usize = 2;

/// What is asked for.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Recipe {
    /// Condition number κ.
    pub condition: f64,
    /// Standard deviation of the noise over that of the signal.
    pub noise: f64,
    /// Share of the visits that are wrong.
    pub outliers: f64,
    /// Rows m.
    pub rows: usize,
    /// How many of the eight effects are real.
    pub effects: usize,
    /// Seed.
    pub seed: u64,
}

/// A problem and its truth.
pub struct Problem {
    pub a: DMatrix<f64>,
    pub y: DVector<f64>,
    pub visits: Vec<usize>,
    pub groups: Vec<usize>,
    /// Prior standard deviations given to a solver.
    pub scale: Vec<f64>,
    /// Tolerances: four such sizes to either side.
    pub bounds: Bounds,
    pub truth: DVector<f64>,
    /// True sizes.
    pub sizes: Vec<f64>,
    /// Which rows are wrong.
    pub wrong: Vec<bool>,
}

impl Problem {
    /// The problem of a recipe.
    pub fn new(recipe: &Recipe) -> Self {
        let mut g = Gauss(ChaCha8Rng::seed_from_u64(recipe.seed));
        let (m, p) = (recipe.rows, UNKNOWNS);
        let u = DMatrix::from_fn(m, p, |_, _| g.normal()).qr().q();
        let v = DMatrix::from_fn(p, p, |_, _| g.normal()).qr().q();
        let spectrum = DVector::from_fn(p, |k, _| {
            (m as f64).sqrt() * recipe.condition.powf(-(k as f64) / (p - 1) as f64)
        });
        let sizes: Vec<f64> = (0..p).map(|_| 10f64.powf(6.0 * g.uniform() - 3.0)).collect();
        let scale = sizes.iter().map(|s| s * (0.4 * g.normal()).exp()).collect::<Vec<f64>>();
        let groups: Vec<usize> = (0..p).map(|j| j / EFFECT).collect();
        // The real effects are spread over the columns: 5 and 8 have no common divisor.
        let real = |j: usize| (5 * groups[j]) % (p / EFFECT) < recipe.effects;
        let unit = DVector::from_fn(p, |j, _| if real(j) { g.normal().clamp(-2.5, 2.5) } else { 0.0 });
        let scaled = u * DMatrix::from_diagonal(&spectrum) * v.transpose();
        let signal = &scaled * &unit;
        let sigma = recipe.noise * (signal.norm_squared() / m as f64).sqrt();
        let mut y = signal / sigma + DVector::from_fn(m, |_, _| g.normal());
        let a = DMatrix::from_fn(m, p, |i, j| scaled[(i, j)] / (sizes[j] * sigma));
        let mut wrong = vec![false; m];
        for visit in 0..m / VISIT {
            if g.uniform() < recipe.outliers {
                let size = (5.0 + 45.0 * g.uniform()) * if g.uniform() < 0.7 { 1.0 } else { -1.0 };
                for row in VISIT * visit..VISIT * (visit + 1) {
                    wrong[row] = true;
                    y[row] += size * (1.0 + 0.2 * g.normal());
                }
            }
        }
        let bounds = (0..p).fold(Bounds::free(p), |b, j| b.with(j, -4.0 * scale[j], 4.0 * scale[j]));
        let truth = DVector::from_fn(p, |j, _| unit[j] * sizes[j]);
        let visits = (0..m).map(|i| i / VISIT).collect();
        Problem { a, y, visits, groups, scale, bounds, truth, sizes, wrong }
    }

    /// These rows, with everything that a solver may use except the bounds.
    pub fn rows(&self, rows: &[usize]) -> Rows {
        Rows {
            a: self.a.select_rows(rows),
            y: self.y.select_rows(rows),
            visits: rows.iter().map(|&i| self.visits[i]).collect(),
        }
    }

    /// Root mean square of the parameters' errors in true sizes.
    pub fn parameter_error(&self, x: &DVector<f64>) -> f64 {
        let sum: f64 = (0..x.len()).map(|j| ((x[j] - self.truth[j]) / self.sizes[j]).powi(2)).sum();
        (sum / x.len() as f64).sqrt()
    }
}

/// Some rows of a problem.
pub struct Rows {
    pub a: DMatrix<f64>,
    pub y: DVector<f64>,
    visits: Vec<usize>,
}

impl Rows {
    /// What a solver is given.
    pub fn problem<'a>(&'a self, whole: &'a Problem, bounded: bool) -> LeastSquares<'a> {
        let problem = LeastSquares::new(&self.a, &self.y)
            .with_row_groups(&self.visits)
            .with_column_groups(&whole.groups)
            .with_scale(&whole.scale);
        if bounded { problem.with_bounds(&whole.bounds) } else { problem }
    }
}

/// Unit normals by Box and Muller.
struct Gauss(ChaCha8Rng);

impl Gauss {
    fn uniform(&mut self) -> f64 {
        self.0.random::<f64>()
    }

    fn normal(&mut self) -> f64 {
        (-2.0 * (1.0 - self.uniform()).ln()).sqrt() * (std::f64::consts::TAU * self.uniform()).cos()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_problem_is_as_its_recipe_says() {
        let recipe = Recipe { condition: 1e6, noise: 0.01, outliers: 0.1, rows: 600, effects: 2, seed: 3 };
        let problem = Problem::new(&recipe);
        let scaled = DMatrix::from_fn(600, UNKNOWNS, |i, j| problem.a[(i, j)] * problem.sizes[j]);
        let values = scaled.singular_values();
        assert!((values.max() / values.min() / 1e6 - 1.0).abs() < 1e-6);
        assert_eq!(problem.truth.iter().filter(|x| **x != 0.0).count(), 2 * EFFECT);
        let right: Vec<f64> = (&problem.y - &problem.a * &problem.truth)
            .iter()
            .zip(&problem.wrong)
            .filter(|(_, wrong)| !**wrong)
            .map(|(r, _)| r * r)
            .collect();
        let variance = right.iter().sum::<f64>() / right.len() as f64;
        assert!((variance - 1.0).abs() < 0.2, "{variance}");
        let share = problem.wrong.iter().filter(|w| **w).count() as f64 / 600.0;
        assert!((share - 0.1).abs() < 0.05, "{share}");
        assert!(problem.bounds.contains(&[0.0; UNKNOWNS]));
    }
}
