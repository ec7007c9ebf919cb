//! Leaving whole groups of rows out, on factors instead of rows.
//!
//! held-out squares of fold f = ‖R_f x − z_f‖² + rss_f,  with x from the factor of all other folds merged
//!
//! One pass over the rows makes one factor per fold; everything after is of the size of the unknowns.

use crate::accumulator::{Factor, Triangular};
use crate::{LeastSquares, SolveError};
use nalgebra::DVector;

/// How to leave groups of rows out.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GroupedFolds {
    /// Number of parts, at least 2.
    pub folds: usize,
    /// Seed of the shuffle that assigns groups to parts.
    pub seed: u64,
    /// Which strength wins.
    pub choice: Choice,
}

/// Which strength wins a cross-validation.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[non_exhaustive]
pub enum Choice {
    /// The one of least held-out error.
    #[default]
    Minimum,
    /// The strongest within one standard error of the least.
    OneStandardError,
}

impl Default for GroupedFolds {
    fn default() -> Self {
        Self { folds: 5, seed: 1, choice: Choice::Minimum }
    }
}

/// One fold: what is fitted on, and what is held out.
pub(crate) struct Split {
    pub train: Factor,
    pub held: Factor,
}

impl Split {
    /// Mean held-out square per row at `x`.
    pub fn error(&self, x: &DVector<f64>) -> f64 {
        self.held.residual_norm(0, x).powi(2) / self.held.rows.max(1) as f64
    }
}

impl GroupedFolds {
    /// Refuses fewer than two folds.
    pub fn validate(&self) -> Result<(), SolveError> {
        if self.folds < 2 {
            return Err(SolveError::BadOption {
                option: "folds",
                value: self.folds as f64,
                expected: "at least 2",
            });
        }
        Ok(())
    }

    /// Rows of each fold; groups stay whole.
    pub fn rows(&self, problem: &LeastSquares<'_>) -> Result<Vec<Vec<usize>>, SolveError> {
        self.validate()?;
        let mut groups = problem.groups_of_rows();
        if groups.len() < self.folds {
            return Err(SolveError::TooFewGroups { have: groups.len(), need: self.folds });
        }
        // The shuffle is of groups, so the order of the rows within a group does not matter.
        shuffle(&mut groups, self.seed);
        let mut folds = vec![Vec::new(); self.folds];
        for (k, group) in groups.into_iter().enumerate() {
            folds[k % self.folds].extend(group);
        }
        folds.iter_mut().for_each(|f| f.sort_unstable());
        Ok(folds)
    }

    pub(crate) fn split(&self, problem: &LeastSquares<'_>) -> Result<Vec<Split>, SolveError> {
        let p = problem.columns();
        let part_of = |rows: &mut dyn Iterator<Item = usize>| -> Result<Triangular, SolveError> {
            let mut part = Triangular::new(p, 1);
            let mut row = vec![0.0; p + 1];
            for i in rows {
                let root = problem.root_weight(i);
                (0..p).for_each(|j| row[j] = root * problem.a[(i, j)]);
                row[p] = root * problem.y[i];
                part.update_rows(&row)?;
            }
            Ok(part)
        };
        let mut parts = Vec::new();
        for rows in self.rows(problem)? {
            parts.push(part_of(&mut rows.into_iter())?);
        }
        // A prior is known in every fold.
        let prior = part_of(&mut (problem.measured_rows()..problem.rows()))?;
        let mut splits = Vec::new();
        for held in 0..parts.len() {
            let mut train = prior.clone();
            for other in (0..parts.len()).filter(|f| *f != held) {
                train.merge(&parts[other])?;
            }
            splits.push(Split { train: train.finish(), held: parts[held].finish() });
        }
        Ok(splits)
    }

    /// Position of the winner, given errors[strength][fold] with strengths falling.
    pub(crate) fn choose(&self, errors: &[Vec<f64>]) -> usize {
        let mean = |e: &[f64]| e.iter().sum::<f64>() / e.len() as f64;
        let means: Vec<f64> = errors.iter().map(|e| mean(e)).collect();
        let mut best = 0;
        for (k, m) in means.iter().enumerate() {
            if *m < means[best] {
                best = k;
            }
        }
        match self.choice {
            Choice::Minimum => best,
            Choice::OneStandardError => {
                let e = &errors[best];
                let variance =
                    e.iter().map(|v| (v - means[best]).powi(2)).sum::<f64>() / (e.len() - 1) as f64;
                let limit = means[best] + (variance / e.len() as f64).sqrt();
                means.iter().position(|m| *m <= limit).unwrap_or(best)
            }
        }
    }
}

/// Fisher-Yates with a small generator (splitmix64), the same on every machine.
pub(crate) fn shuffle<T>(items: &mut [T], seed: u64) {
    let mut state = seed;
    for k in (1..items.len()).rev() {
        state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = state;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        let pick = ((z ^ (z >> 31)) % (k as u64 + 1)) as usize;
        items.swap(k, pick);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::DMatrix;

    #[test]
    fn groups_stay_whole_and_every_row_is_held_out_once() {
        let a = DMatrix::from_fn(60, 2, |i, j| ((i + 3 * j) as f64).sin());
        let y = DVector::from_fn(60, |i, _| i as f64);
        let ids: Vec<usize> = (0..60).map(|i| i / 3).collect();
        let problem = LeastSquares::new(&a, &y).with_row_groups(&ids);
        let folds = GroupedFolds::default().rows(&problem).unwrap();
        let mut seen: Vec<usize> = folds.concat();
        seen.sort_unstable();
        assert_eq!(seen, (0..60).collect::<Vec<_>>());
        for fold in &folds {
            assert!(fold.iter().all(|r| fold.contains(&(r / 3 * 3))));
        }
        let splits = GroupedFolds::default().split(&problem).unwrap();
        let x = DVector::from_column_slice(&[0.3, -1.0]);
        let total: f64 = splits.iter().map(|s| s.error(&x) * s.held.rows as f64).sum();
        assert!((total - problem.residual(&x).norm_squared()).abs() < 1e-9 * total);
        assert!(matches!(
            GroupedFolds { folds: 30, ..Default::default() }.rows(&problem),
            Err(SolveError::TooFewGroups { have: 20, need: 30 })
        ));
    }
}
