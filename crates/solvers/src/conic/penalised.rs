//! What lasso, elastic net and group lasso share: how the strength is chosen, the path, the refit.
//!
//! minimise ½ ‖W^{1/2} (A x − y)‖² + λ Ω(x / s)
//!
//! λ_max is the least λ whose answer is zero; a path runs down from it. Without given sizes s_j is one over the norm of
//! column j, so that λ is relative to nothing but y.

use super::core::{Core, Inner};
use crate::accumulator::{ColumnScale, Factor};
use crate::folds::GroupedFolds;
use crate::{LeastSquares, Solution, SolveError, Status};
use nalgebra::DVector;

/// How the strength of a penalty that makes zeros is chosen.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub enum Strength {
    /// This λ.
    Fixed(f64),
    /// This fraction of λ_max.
    Ratio(f64),
    /// Least error on groups of rows left out, on a path of `count` strengths down to `least` of λ_max.
    GroupedCv {
        /// How rows are left out.
        folds: GroupedFolds,
        /// Strengths on the path.
        count: usize,
        /// Last fraction of λ_max.
        least: f64,
    },
}

impl Default for Strength {
    fn default() -> Self {
        Strength::GroupedCv { folds: GroupedFolds::default(), count: 20, least: 1e-4 }
    }
}

impl Strength {
    /// Refuses options out of range.
    pub fn validate(&self) -> Result<(), SolveError> {
        let bad = |option, value, expected| Err(SolveError::BadOption { option, value, expected });
        match *self {
            Strength::Fixed(l) if !(l >= 0.0 && l.is_finite()) => bad("lambda", l, "a finite number ≥ 0"),
            Strength::Ratio(r) if !(0.0..=1.0).contains(&r) => bad("ratio", r, "between 0 and 1"),
            Strength::GroupedCv { count, .. } if count < 2 => bad("count", count as f64, "at least 2"),
            Strength::GroupedCv { least, .. } if !(least > 0.0 && least < 1.0) => {
                bad("least", least, "between 0 and 1")
            }
            Strength::GroupedCv { folds, .. } => folds.validate(),
            _ => Ok(()),
        }
    }
}

/// A penalty Ω on v = ω ∘ u in the units of the core.
pub(super) trait Penalty {
    /// Least strength whose answer is zero.
    fn top(&self, core: &Core, omega: &[f64]) -> f64;
    /// The answer at a strength.
    fn solve(&self, core: &Core, omega: &[f64], lambda: f64) -> Inner;
}

/// A factor with the weights that the penalty puts on each unknown.
pub(super) struct Weighted {
    pub core: Core,
    pub omega: Vec<f64>,
}

impl Weighted {
    /// `sizes` are those of the whole problem, so that every fold is penalised alike.
    fn new(factor: &Factor, sizes: &[f64]) -> Result<Self, SolveError> {
        let core = Core::new(factor)?;
        let omega = core.live.iter().zip(&core.unit).map(|(j, unit)| unit / core.size / sizes[*j]).collect();
        Ok(Self { core, omega })
    }

    /// λ is that of the problem; the core is smaller by its size.
    fn solve(&self, penalty: &dyn Penalty, lambda: f64) -> Inner {
        penalty.solve(&self.core, &self.omega, lambda / self.core.size)
    }

    fn top(&self, penalty: &dyn Penalty) -> f64 {
        penalty.top(&self.core, &self.omega) * self.core.size
    }
}

/// Everything that a penalised solver does after validation.
pub(super) fn solve(
    problem: &LeastSquares<'_>,
    penalty: &dyn Penalty,
    strength: Strength,
    refit: bool,
) -> Result<Solution, SolveError> {
    strength.validate()?;
    let factor = Factor::of_valid(problem);
    let sizes = factor.multipliers(problem.column_scale())?;
    let whole = Weighted::new(&factor, &sizes)?;
    let top = whole.top(penalty);
    let lambda = match strength {
        Strength::Fixed(lambda) => lambda,
        Strength::Ratio(ratio) => ratio * top,
        Strength::GroupedCv { folds, count, least } => {
            let grid = strengths(top, least, count);
            let mut errors = vec![Vec::new(); grid.len()];
            for split in folds.split(problem)? {
                let part = Weighted::new(&split.train, &sizes)?;
                let share = split.train.rows as f64 / problem.rows() as f64;
                for (lambda, errors) in grid.iter().zip(&mut errors) {
                    let x = part.solve(penalty, share * lambda).u.map(|u| part.core.x(&u));
                    let x = x
                        .map(|x| if refit { refitted(&split.train, &x, &sizes) } else { Ok(x) })
                        .transpose()?;
                    errors.push(x.map_or(f64::INFINITY, |x| split.error(&x)));
                }
            }
            grid[folds.choose(&errors)]
        }
    };
    at(problem, &factor, &whole, penalty, lambda, refit)
}

/// The answer at every strength of a path of `count` from λ_max down to `least` λ_max.
pub(super) fn path(
    problem: &LeastSquares<'_>,
    penalty: &dyn Penalty,
    count: usize,
    least: f64,
) -> Result<Vec<Solution>, SolveError> {
    Strength::GroupedCv { folds: GroupedFolds::default(), count, least }.validate()?;
    let factor = Factor::of(problem)?;
    let whole = Weighted::new(&factor, &factor.multipliers(problem.column_scale())?)?;
    let grid = strengths(whole.top(penalty), least, count);
    grid.iter().map(|lambda| at(problem, &factor, &whole, penalty, *lambda, false)).collect()
}

fn at(
    problem: &LeastSquares<'_>,
    factor: &Factor,
    whole: &Weighted,
    penalty: &dyn Penalty,
    lambda: f64,
    refit: bool,
) -> Result<Solution, SolveError> {
    let inner = whole.solve(penalty, lambda);
    let mut solution = whole.core.solution(problem, &inner);
    solution.info.strength = Some(lambda);
    if inner.u.is_none() {
        return Ok(solution);
    }
    let support: Vec<usize> = (0..problem.columns()).filter(|j| solution.x[*j] != 0.0).collect();
    if refit && inner.status == Status::Converged {
        let sizes = factor.multipliers(ColumnScale::Norms)?;
        solution.x = refitted(factor, &solution.x, &sizes)?;
        solution = problem.with_true_residual(solution);
    }
    solution.info.effective_parameters = Some(support.len() as f64);
    solution.info.kept = Some(support);
    Ok(solution)
}

/// Plain least squares on the columns that are not zero.
fn refitted(factor: &Factor, x: &DVector<f64>, sizes: &[f64]) -> Result<DVector<f64>, SolveError> {
    let support: Vec<usize> = (0..x.len()).filter(|j| x[*j] != 0.0).collect();
    let part = factor.select(&support);
    let sizes: Vec<f64> = support.iter().map(|j| sizes[*j]).collect();
    let solved = part.solve_pivoted(0, ColumnScale::Given(&sizes), crate::RankRule::Default)?;
    let mut out = DVector::zeros(x.len());
    support.iter().zip(solved.x.iter()).for_each(|(j, v)| out[*j] = *v);
    Ok(out)
}

fn strengths(top: f64, least: f64, count: usize) -> Vec<f64> {
    (0..count).map(|k| top * least.powf(k as f64 / (count - 1) as f64)).collect()
}
