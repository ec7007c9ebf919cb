//! Start from the visits that agree best with each other: least trimmed squares by concentration.
//!
//! minimise over x and over sets H of h visits:  Σ_{g ∈ H} n_g u_g(x)²
//!
//! Fit, keep the h visits of smallest u, fit these, and so on: every step lowers the sum. Source: Rousseeuw and Van
//! Driessen (2006), FAST-LTS. Begun from the plain fit, from a Huber fit and from random handfuls; the best of them
//! wins.

use super::Loss;
use super::visits::Visits;
use crate::folds::shuffle;
use crate::{Fallback, Solution, SolveError, Solver};

/// How to find the visits that agree.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Trimming {
    /// Share of the visits that are kept, from 0.5 to 1.
    pub keep: f64,
    /// Random starts beside the plain and the Huber one.
    pub starts: usize,
    /// Seed of the random starts.
    pub seed: u64,
}

impl Default for Trimming {
    fn default() -> Self {
        Self { keep: 0.75, starts: 8, seed: 1 }
    }
}

impl Trimming {
    /// Refuses options out of range.
    pub fn validate(&self) -> Result<(), SolveError> {
        if !(0.5..=1.0).contains(&self.keep) {
            return Err(SolveError::BadOption {
                option: "keep",
                value: self.keep,
                expected: "between 0.5 and 1",
            });
        }
        Ok(())
    }

    /// The start, or the plain fit when there are too few visits to leave any out.
    pub(super) fn start(
        &self,
        inner: &dyn Solver,
        visits: &Visits<'_>,
        plain: Solution,
    ) -> Result<(Solution, Option<Fallback>), SolveError> {
        const FIRST: usize = 3;
        const LAST: usize = 30;
        let total = visits.groups.len();
        let keep = (self.keep * total as f64).ceil() as usize;
        let rows: usize = visits.groups.iter().map(Vec::len).sum();
        let too_few = keep * rows < 2 * plain.rank * total || keep >= total;
        if too_few {
            return Ok((plain, Some(Fallback::PlainStart)));
        }
        let huber = visits.iterate(inner, Loss::huber(), plain.clone(), 30, 1e-4)?;
        let plain_rank = plain.rank;
        let mut begins = vec![plain, huber];
        for start in 0..self.starts {
            let mut order: Vec<usize> = (0..total).collect();
            shuffle(&mut order, self.seed.wrapping_add(start as u64));
            // Just enough rows for the unknowns: the fewer, the likelier that all of them are good.
            let mut factors = vec![0.0; total];
            let mut taken = 0;
            for g in order {
                if taken > plain_rank {
                    break;
                }
                factors[g] = 1.0;
                taken += visits.groups[g].len();
            }
            begins.push(visits.solve(inner, &factors)?);
        }
        let mut best: Option<(f64, Solution)> = None;
        for begin in begins {
            let (objective, solution) = concentrate(inner, visits, begin, keep, FIRST)?;
            if best.as_ref().is_none_or(|(o, _)| objective < *o) {
                best = Some((objective, solution));
            }
        }
        match best {
            Some((_, solution)) => Ok((concentrate(inner, visits, solution, keep, LAST)?.1, None)),
            None => Ok((inner.solve(visits.problem)?, Some(Fallback::PlainStart))),
        }
    }
}

/// Up to `steps` concentration steps; the sum over the kept visits with the answer.
fn concentrate(
    inner: &dyn Solver,
    visits: &Visits<'_>,
    start: Solution,
    keep: usize,
    steps: usize,
) -> Result<(f64, Solution), SolveError> {
    let mut solution = start;
    let mut objective = f64::INFINITY;
    for _ in 0..steps {
        let (kept, sum) = closest(&visits.residuals(&solution.x), keep);
        if sum >= objective * (1.0 - 1e-12) {
            break;
        }
        objective = sum;
        let next = visits.solve(inner, &kept)?;
        if !next.status.is_success() {
            break;
        }
        solution = next;
    }
    Ok((closest(&visits.residuals(&solution.x), keep).1, solution))
}

/// Factor 1 for the `keep` visits of smallest residual, and the sum of their squares.
fn closest(residuals: &[(f64, usize)], keep: usize) -> (Vec<f64>, f64) {
    let mut order: Vec<usize> = (0..residuals.len()).collect();
    order.sort_by(|a, b| residuals[*a].0.total_cmp(&residuals[*b].0));
    let mut factors = vec![0.0; residuals.len()];
    let mut sum = 0.0;
    for &g in order.iter().take(keep) {
        factors[g] = 1.0;
        sum += residuals[g].0.powi(2) * residuals[g].1 as f64;
    }
    (factors, sum)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{LeastSquares, PivotedQr, Robust};
    use nalgebra::{DMatrix, DVector};

    /// Three visits in ten wrong in the same way, at the end of the range where they pull most.
    #[test]
    fn thirty_percent_that_agree_with_each_other_do_not_win() {
        let a = DMatrix::from_fn(300, 2, |i, j| if j == 0 { 1.0 } else { (i / 3) as f64 / 100.0 });
        let y = DVector::from_fn(300, |i, _| {
            let visit = i / 3;
            let good = 1.0 + 2.0 * visit as f64 / 100.0 + 0.01 * ((i * i) as f64 * 0.77).sin();
            if visit >= 70 { good - 4.0 } else { good }
        });
        let ids: Vec<usize> = (0..300).map(|i| i / 3).collect();
        let problem = LeastSquares::new(&a, &y).with_row_groups(&ids);
        let error =
            |s: &dyn Solver| (s.solve(&problem).unwrap().x - DVector::from_column_slice(&[1.0, 2.0])).norm();
        let mut tukey = Robust::tukey(PivotedQr::default());
        tukey.start = super::super::Start::Trimmed(Trimming { keep: 0.6, starts: 20, seed: 3 });
        assert!(error(&PivotedQr::default()) > 1.0);
        assert!(error(&tukey) < 0.01, "{}", error(&tukey));
    }
}
