//! Data of which only a part is fitted and judged at once, and the result of that part with the figures of all rows.
//!
//! Structure, repeatability limit, intervals of nonlinear parameters and competing hypotheses are those of the part: they need no more rows.
//! Coefficients, residuals and held-out errors are those of all rows.

use crate::accept::model::Model;
use crate::census::all_rows::AllRows;
use crate::census::blocks::Blocks;
use crate::census::gross::gross;
use crate::conclude::diagnosis::Diagnosis;
use crate::conclude::held_out::{HeldOutIntervals, clusters};
use crate::conclude::partition::RowSplit;
use crate::conclude::report::{at_run_time, errors, parameters};
use crate::error::DiscoverError;
use crate::hypotheses::candidate::Candidate;
use crate::model::prepared::{found_in, with_found, without};
use crate::options::DiscoverOptions;
use nalgebra::Vector3;
use rand::SeedableRng;
use rand::seq::SliceRandom;
use rand_chacha::ChaCha8Rng;
use std::borrow::Cow;
use truepose_errormodel::{Dataset, Visits};
use truepose_identify::Residuals;

/// Data with its partition.
pub(crate) struct Partitioned<'a> {
    pub data: &'a Dataset,
    /// Training and held-out rows.
    pub rows: &'a RowSplit,
}

/// A part of it.
pub(crate) struct Part {
    pub data: Dataset,
    pub rows: RowSplit,
    /// Its rows among all.
    of: Vec<usize>,
}

impl Partitioned<'_> {
    /// About `most` training rows and as large a part of the held-out ones, whole poses at random; none where they are few enough.
    pub fn part(&self, seed: u64, most: usize) -> Option<Part> {
        let (train, held) = self.rows;
        if train.len() <= most + most / 4 {
            return None;
        }
        let share = most as f64 / train.len() as f64;
        let mut taken = vec![0u8; self.data.len()];
        let mut random = ChaCha8Rng::seed_from_u64(seed ^ 0x3b19_77d0);
        for (mark, rows) in [(1, train), (2, held)] {
            let mut visits: Vec<usize> = rows.iter().map(|&row| self.data.visit[row]).collect();
            visits.sort_unstable();
            visits.dedup();
            visits.shuffle(&mut random);
            visits.truncate((share * visits.len() as f64).ceil() as usize);
            visits.sort_unstable();
            let own = rows.iter().filter(|&&row| visits.binary_search(&self.data.visit[row]).is_ok());
            own.for_each(|&row| taken[row] = mark);
        }
        let of: Vec<usize> = (0..taken.len()).filter(|&row| taken[row] > 0).collect();
        let marked = |mark: u8| (0..of.len()).filter(|&k| taken[of[k]] == mark).collect();
        Some(Part { data: self.data.select(&of), rows: (marked(1), marked(2)), of })
    }

    /// Residuals of the declared and of the enlarged model on all held-out rows; NaN in gross ones.
    pub fn held_out_errors(&self, model: &Model) -> Result<[Residuals; 2], DiscoverError> {
        let held = self.data.select(&self.rows.1);
        let mut pair = [
            Residuals::of(&model.declared.fit.fitted, &held)?,
            Residuals::of(&model.current.fit.fitted, &with_found(&held, &model.current.found))?,
        ];
        let gross = gross(&pair[1], &held);
        for residuals in &mut pair {
            for &row in &gross {
                residuals.position[row] = Vector3::repeat(f64::NAN);
                residuals.orientation[row] = None;
            }
        }
        Ok(pair)
    }
}

impl Part {
    /// What was found in this part, with the coefficients, residuals and errors of all rows.
    pub fn widened(
        &self,
        mut found: Diagnosis,
        all: &Partitioned<'_>,
        options: &DiscoverOptions,
    ) -> Result<Diagnosis, DiscoverError> {
        let back = |rows: &mut Vec<usize>| rows.iter_mut().for_each(|row| *row = self.of[*row]);
        back(&mut found.suspects);
        for finding in &mut found.findings {
            back(&mut finding.rows);
            finding.poses.iter_mut().for_each(back);
        }
        let causes: Vec<Candidate> = found.findings.iter().map(|finding| finding.candidate.clone()).collect();
        let every = found_in(Cow::Borrowed(all.data), &causes);
        let far = gross(&Residuals::of(&found.fit.fitted, &every)?, &every);
        let blocks = Blocks::new(without(&every, &far));
        let scatter = found.fit.residuals.clone();
        found.fit = AllRows::of(&found.fit, &blocks, options)?.fit;
        found.fit.residuals = scatter;
        drop(blocks);
        at_run_time(&mut found.fit, &causes, all.data);
        let effects: usize = causes.iter().map(|cause| cause.effects().len()).sum();
        let mut first = found.fit.fitted.model().effects().len() - effects;
        for (finding, cause) in found.findings.iter_mut().zip(&causes) {
            let own = first..first + cause.effects().len();
            finding.parameters = parameters(&found.fit, cause, own.clone());
            first = own.end;
        }
        found.before = errors(&found.declared, &all.data.select(&all.rows.0), &all.data.select(&all.rows.1))?;
        let (train, held) = (every.select(&all.rows.0), every.select(&all.rows.1));
        found.after = errors(&found.fit, &train, &held)?;
        let outliers = [gross(&found.after.train, &train), gross(&found.after.holdout, &held)];
        found.before.outliers.clone_from(&outliers);
        found.after.outliers = outliers;
        let clusters = clusters(&held, found.dependence.as_ref());
        let draws = options.budget.bootstrap;
        found.intervals =
            HeldOutIntervals::of([&found.before, &found.after], &clusters, None, draws, options.seed);
        found.holdout_rows.clone_from(&all.rows.1);
        found.rows = all.data.len();
        found.visits = Visits::of(all.data).len();
        Ok(found)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::problem::synthetic::data;

    #[test]
    fn a_part_has_whole_poses_of_both_sides_and_few_rows_are_no_part() {
        let (_, data) = data(200, 3, &|_, _, _| [0.0; 3]);
        let rows = (0..data.len()).partition(|&row| data.visit[row] % 5 != 0);
        let all = Partitioned { data: &data, rows: &rows };
        assert!(all.part(0, rows.0.len()).is_none());
        let part = all.part(0, 90).unwrap();
        assert!((88..=92).contains(&part.rows.0.len()) && (20..=26).contains(&part.rows.1.len()));
        for (own, whole) in [(&part.rows.0, &rows.0), (&part.rows.1, &rows.1)] {
            let taken: Vec<usize> = own.iter().map(|&row| part.of[row]).collect();
            assert!(taken.iter().all(|row| whole.contains(row)));
            for &row in &taken {
                let pose = (0..data.len()).filter(|&other| data.visit[other] == data.visit[row]);
                assert!(pose.into_iter().all(|other| taken.contains(&other)));
            }
        }
    }
}
