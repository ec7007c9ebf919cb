//! Solvers that weigh rows or hold unknowns by a penalty of their own: from the plain fit to theirs, no further than the linear picture holds.
//!
//! ```text
//! c ← c + t (ĉ − c)     Q(c) = Σ w r²     accepted when  Q(c + t δ) ≤ Q̂(t) + ½ |Q(c) − Q̂(t)|
//! ```
//!
//! | symbol | here | shape |
//! | --- | --- | --- |
//! | ĉ, w | the solver's answer to the rows at c, and the weights of the rows that it ended with | r, m |
//! | Q̂(t) | Q as the linear picture at c has it | 1 |
//!
//! Such a solver minimises an objective that only it knows, in a linear picture. A fit of plain squares comes first: it has an objective to
//! be held to (with a prior, where the solver has a penalty of its own), finds structure, noise and prior, and leads to where one linear picture holds all that the solver will still change. The
//! noise that wrong visits have blown up is brought down by the robust scale of the solver, and the prior asked for anew by the weighted rows.

use super::state::{Outcome, STILL, State, WORSE, squares_of};
use crate::fit::options::NoiseSource;
use crate::linearise::{Rows, collect, left_over_rows};
use crate::reduction::Reduction;
use crate::{IdentifyError, Prior};
use nalgebra::{DMatrix, DVector};
use truepose_solvers::accumulator::{Factor, Triangular};
use truepose_solvers::order::high_median;
use truepose_solvers::{Need, Solution, Solver};

/// Rounds at most, halvings of a step at most, and looks at noise and prior.
const MOST: usize = 40;
const HALVINGS: usize = 10;
const LOOKS: usize = 4;
/// Share of its standard deviation that no unknown moves by any more; penalties that are chosen anew in each round move by the
/// resolution of that choice.
const RESTS: f64 = 1e-2;
/// What the squares may rise by beyond the linear picture: a tenth of one number's.
const TENTH: f64 = 0.1;
/// Deviations of a robust scale from the noise in one look: more is no correction, but another fit.
const MOST_SCALED: f64 = 4.0;

impl<'a> State<'a> {
    /// From where the plain fit ended to the fit of this solver, and whether it was taken.
    pub(in crate::fit) fn follow(
        &mut self,
        solver: &'a dyn Solver,
        prior: Prior,
        reduction: &Reduction,
        plain: Outcome,
    ) -> Result<(Outcome, bool), IdentifyError> {
        let scales: Vec<f64> = reduction.kept.iter().map(|&c| self.model.columns()[c].scale).collect();
        let robust = solver.supports(Need::Outliers);
        let start = self.spoilable();
        let yardstick = Yardstick::new(&self.rows_at(&start.1)?);
        self.solver = solver;
        self.prior = prior;
        let (mut rounds, mut looks) = (plain.rounds, 0);
        let mut converged = false;
        let mut solution = plain.solution.clone();
        for _ in 0..MOST {
            rounds += 1;
            let rows = collect(self.model, self.data, self.visits, self.noise, &self.coefficients)?;
            solution = self.solve_rows(reduction, &rows, &scales)?;
            if !solution.x.iter().all(|v| v.is_finite()) {
                break;
            }
            let weights = weights(&solution, rows.residual.len());
            let now = DVector::from_vec(reduction.grouped(&self.coefficients));
            let change = &solution.x - &now;
            let moved = reduction.select(&rows.a) * &change;
            let Some(share) = self.share(reduction, &rows, &weights, &now, &change, &moved)? else {
                break;
            };
            let deviations = weighted(&moved, &weights) + self.prior.penalty(change.as_slice());
            let explained = weighted(&(&rows.a * DVector::from_column_slice(&self.coefficients)), &weights);
            let still = deviations.sqrt() < RESTS || deviations.sqrt() < STILL * (1.0 + explained.sqrt());
            if still && share >= 1.0 {
                converged = true;
                break;
            }
            // Where the solver left every weight as it was, noise and prior are those of the plain fit.
            let weighed = weights.iter().any(|weight| *weight < 1.0);
            if robust && weighed && share >= 1.0 && looks < LOOKS {
                looks += 1;
                self.look_by_weights(reduction, &rows, &solution, &weights)?;
            }
        }
        // In the noise of the plain fit, as that was measured.
        let (model, data, visits, at) = (self.model, self.data, self.visits, &*self.coefficients);
        let left = left_over_rows(model, data, visits, start.2, at)?;
        let fallen_back = robust && !yardstick.bears(&left, reduction.rank());
        if fallen_back {
            self.back_to(start);
            return Ok((plain, false));
        }
        let (residuals, _) = self.misfit()?;
        let factor = self.linearise(Some(&reduction.kept))?;
        debug_assert!(squares_of(&factor).is_finite());
        Ok((Outcome { solution, rounds, converged, factor, residuals }, true))
    }

    /// Where the coefficients are, as if rounds had ended there: a start that is known needs none.
    pub(in crate::fit) fn here(
        &mut self,
        reduction: &Reduction,
        factor: Factor,
    ) -> Result<Outcome, IdentifyError> {
        let scales: Vec<f64> = reduction.kept.iter().map(|&c| self.model.columns()[c].scale).collect();
        let (solution, _) = self.solve(reduction, &factor, &scales, 0.0)?;
        let (residuals, _) = self.misfit()?;
        Ok(Outcome { solution, rounds: 0, converged: true, factor, residuals })
    }

    /// Takes the largest share of the step at which the linear picture still holds; none where it holds nowhere.
    fn share(
        &mut self,
        reduction: &Reduction,
        rows: &Rows,
        weights: &[f64],
        now: &DVector<f64>,
        change: &DVector<f64>,
        moved: &DVector<f64>,
    ) -> Result<Option<f64>, IdentifyError> {
        let start = self.coefficients.clone();
        let placement = self.placement(reduction);
        let before = weighted(&rows.residual, weights);
        let mut share = 1.0;
        for _ in 0..HALVINGS {
            let expected = weighted(&(&rows.residual - moved * share), weights);
            let to = now + change * share;
            self.coefficients = reduction.expand(to.as_slice(), start.len());
            let found = weighted(&self.rows_at(&self.coefficients)?.residual, weights);
            let most = expected + 0.5 * (before - expected).abs() + TENTH.max(WORSE * before);
            if found <= most {
                return Ok(Some(share));
            }
            if !self.solver.supports(Need::Outliers) {
                // The valley bends because base, tool and targets have to follow: not to be had where wrong visits pull at them.
                self.settle(reduction, &placement)?;
                if weighted(&self.rows_at(&self.coefficients)?.residual, weights) <= most {
                    return Ok(Some(0.5 * share));
                }
            }
            share *= 0.5;
        }
        self.coefficients = start;
        Ok(None)
    }

    /// Whitened residuals at these coefficients, without columns.
    pub(in crate::fit) fn rows_at(&self, coefficients: &[f64]) -> Result<Rows, IdentifyError> {
        left_over_rows(self.model, self.data, self.visits, self.noise, coefficients)
    }

    /// Noise by the robust scale of the solver, and the prior by the rows as it weighs them.
    fn look_by_weights(
        &mut self,
        reduction: &Reduction,
        rows: &Rows,
        solution: &Solution,
        weights: &[f64],
    ) -> Result<(), IdentifyError> {
        let scale = solution.info.noise.unwrap_or(1.0).clamp(1.0 / MOST_SCALED, MOST_SCALED);
        if self.options.noise == NoiseSource::Estimate && scale.is_finite() {
            self.noise.position_sd *= scale;
            self.noise.visit_sd *= scale;
            self.noise.orientation_sd *= scale;
        }
        if self.options.prior.asks_the_data() {
            let factor = weighted_factor(reduction, rows, weights, &self.coefficients, scale)?;
            self.look_at_prior(reduction, &factor)?;
        }
        Ok(())
    }
}

/// Visits that a robust solver hardly believes, where there are any: of which each row has less than this weight.
pub(in crate::fit) fn doubted(outcome: &Outcome, rows: &[usize]) -> Vec<usize> {
    /// Beyond 5.4 standard deviations for Huber's loss, 3.3 for Tukey's.
    const HARDLY: f64 = 0.25;
    let Some(weights) = &outcome.solution.info.row_weights else { return Vec::new() };
    let mut visits: Vec<usize> =
        rows.iter().zip(weights).filter(|(_, weight)| **weight < HARDLY).map(|(visit, _)| *visit).collect();
    visits.dedup();
    visits
}

/// Weights of the measured rows: those that the solver ended with, or all one.
fn weights(solution: &Solution, rows: usize) -> Vec<f64> {
    match &solution.info.row_weights {
        Some(weights) if weights.len() >= rows => weights[..rows].to_vec(),
        _ => vec![1.0; rows],
    }
}

/// Σ w r².
fn weighted(residual: &DVector<f64>, weights: &[f64]) -> f64 {
    residual.iter().zip(weights).map(|(r, w)| w * r * r).sum()
}

/// The triangular factor of the rows as they are weighed, with absolute coefficients on its right.
fn weighted_factor(
    reduction: &Reduction,
    rows: &Rows,
    weights: &[f64],
    coefficients: &[f64],
    scale: f64,
) -> Result<Factor, IdentifyError> {
    let mut a = reduction.select(&rows.a);
    let mut y = &rows.residual + &rows.a * DVector::from_column_slice(coefficients);
    for (k, weight) in weights.iter().enumerate() {
        let root = weight.sqrt() / scale;
        a.row_mut(k).scale_mut(root);
        y[k] *= root;
    }
    let mut factor = Triangular::new(a.ncols(), 1);
    factor.update(&a, &DMatrix::from_column_slice(y.len(), 1, y.as_slice()))?;
    Ok(factor.finish())
}

/// One measure for fits of any loss: Tukey's, `Σ_g n_g σ² ρ(u_g/σ)` with u_g the root mean square of a visit, in units of the
/// squares of visits that are right, and with σ the scale of the plain fit.
struct Yardstick {
    scale: f64,
    plain: f64,
}

impl Yardstick {
    fn new(rows: &Rows) -> Self {
        let visits = visits(rows);
        let scale = high_median(visits.iter().map(|v| v.0)).unwrap_or(1.0).max(f64::MIN_POSITIVE);
        let plain = Self { scale, plain: 0.0 }.of(&visits);
        Yardstick { scale, plain }
    }

    fn of(&self, visits: &[(f64, usize)]) -> f64 {
        /// Where a visit stops counting, in medians: 4.685 standard deviations.
        const CUT: f64 = 4.685 / 0.6745;
        let rho = |t: f64| {
            let rest = (1.0 - (t / CUT).powi(2)).max(0.0);
            CUT * CUT / 3.0 * (1.0 - rest.powi(3))
        };
        visits.iter().map(|(u, n)| *n as f64 * rho(u / self.scale)).sum()
    }

    /// Whether a fit is no worse than the plain one: no estimate of so many unknowns costs more than a unit for each.
    fn bears(&self, rows: &Rows, rank: usize) -> bool {
        self.of(&visits(rows)) <= self.plain + rank as f64
    }
}

/// Root mean square and number of the rows of each visit.
fn visits(rows: &Rows) -> Vec<(f64, usize)> {
    let mut sums: Vec<(f64, usize)> = Vec::new();
    let mut last = None;
    for (value, visit) in rows.residual.iter().zip(&rows.visit) {
        if last.replace(*visit) != Some(*visit) {
            sums.push((0.0, 0));
        }
        if let Some(sum) = sums.last_mut() {
            sum.0 += value * value;
            sum.1 += 1;
        }
    }
    sums.into_iter().map(|(squares, n)| ((squares / n as f64).sqrt(), n)).collect()
}
