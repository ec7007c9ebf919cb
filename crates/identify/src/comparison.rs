//! Solver strategies side by side, on the same data and the same folds.
//!
//! | symbol | here | unit |
//! | --- | --- | --- |
//! | e_ik | 3-D squared error of configuration i, held out, by strategy k | m² |
//! | d_f | mean over fold f of e_ik − e_i0 | m² |
//! | t = d̄ / (s_d √(1/K + n_test/n_train)) | ~ Student with K − 1 degrees of freedom | 1 |
//!
//! The variance is corrected for the overlap of the training parts (Nadeau and Bengio 2003): without it, folds that share
//! most of their data would make every difference significant.

use crate::{
    CrossValidation, Fit, FitOptions, Folds, IdentifyError, Method, against_plain, cross_validate, fit,
};
use statrs::distribution::{ContinuousCDF, StudentsT};
use std::time::Instant;
use truepose_errormodel::{Dataset, ErrorModel};
use truepose_solvers::Solver;

/// One strategy.
#[derive(Debug)]
pub struct Compared {
    /// Its name, as it is chosen.
    pub name: String,
    /// What came of it: a fit with its held-out residuals, or why there is none.
    pub outcome: Result<Trial, IdentifyError>,
}

/// What a strategy reached.
#[derive(Debug)]
pub struct Trial {
    /// The fit on all data.
    pub fit: Fit,
    /// Held-out residuals.
    pub held_out: CrossValidation,
    /// Wall time of the fit on all data, s.
    pub seconds: f64,
    /// Against the first strategy that came to an end; none for that one itself.
    pub against_first: Option<Paired>,
    /// Its held-out error, with rows that lie far off bounded, over that of the first strategy; 1 for that one itself.
    pub ratio: f64,
}

impl Trial {
    /// Whether it predicts worse than the first strategy by more than strategies differ.
    pub fn is_worse(&self) -> bool {
        self.ratio > against_plain::WORSE || !self.ratio.is_finite()
    }
}

/// A paired test of held-out squared errors.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Paired {
    /// Mean difference of the squared error, m²: negative is better than the first strategy.
    pub difference: f64,
    /// Student's t with the corrected variance.
    pub t: f64,
    /// Two-sided p-value.
    pub p_value: f64,
}

/// Fits the model with every strategy and cross-validates each on the same folds.
pub fn compare(
    model: &ErrorModel,
    data: &Dataset,
    solvers: &[(String, Box<dyn Solver>)],
    options: &FitOptions,
    folds: &Folds,
    progress: &dyn Fn(&str),
) -> Vec<Compared> {
    let mut compared: Vec<Compared> = solvers
        .iter()
        .map(|(name, solver)| {
            progress(name);
            Compared { name: name.clone(), outcome: trial(model, data, &**solver, options, folds) }
        })
        .collect();
    let simplest = compared.iter().find_map(|c| c.outcome.as_ref().ok()).map(|t| t.held_out.clone());
    if let Some(simplest) = &simplest {
        for trial in compared.iter_mut().filter_map(|c| c.outcome.as_mut().ok()) {
            trial.ratio = against_plain::ratio(simplest, &trial.held_out);
        }
    }
    let first = compared
        .iter()
        .position(|c| c.outcome.is_ok())
        .map(|k| (k, compared[k].outcome.as_ref().map(|t| squares(&t.held_out, data)).unwrap_or_default()));
    if let Some((k, reference)) = first {
        for other in compared.iter_mut().skip(k + 1) {
            if let Ok(trial) = &mut other.outcome {
                trial.against_first = paired(&reference, &squares(&trial.held_out, data), data.len());
            }
        }
    }
    compared
}

fn trial(
    model: &ErrorModel,
    data: &Dataset,
    solver: &dyn Solver,
    options: &FitOptions,
    folds: &Folds,
) -> Result<Trial, IdentifyError> {
    let begun = Instant::now();
    let fit = fit(model, data, solver, options)?;
    let seconds = begun.elapsed().as_secs_f64();
    let held_out = cross_validate(&fit, data, folds, solver, Method::Auto)?;
    Ok(Trial { fit, held_out, seconds, against_first: None, ratio: 1.0 })
}

/// Sum of squared errors and number of rows of each fold.
pub(crate) fn squares(held_out: &CrossValidation, data: &Dataset) -> Vec<(f64, usize)> {
    let mut sums = vec![(0.0, 0); held_out.folds.count];
    for row in 0..data.len() {
        if let Some(d) = held_out.residuals.distance(row) {
            let sum = &mut sums[held_out.folds.of_visit[data.visit[row]]];
            sum.0 += d * d;
            sum.1 += 1;
        }
    }
    sums
}

impl Paired {
    /// Tests held-out squared errors, each given as (sum of squares, number of rows) fold by fold, of `rows` rows in all
    /// against those of a reference on the same folds; none with fewer than two folds.
    pub fn of(reference: &[(f64, usize)], other: &[(f64, usize)], rows: usize) -> Option<Self> {
        paired(reference, other, rows)
    }
}

fn paired(reference: &[(f64, usize)], other: &[(f64, usize)], rows: usize) -> Option<Paired> {
    let differences: Vec<f64> =
        reference.iter().zip(other).filter(|(a, _)| a.1 > 0).map(|(a, b)| (b.0 - a.0) / a.1 as f64).collect();
    let k = differences.len() as f64;
    if k < 2.0 {
        return None;
    }
    let mean = differences.iter().sum::<f64>() / k;
    let variance = differences.iter().map(|d| (d - mean).powi(2)).sum::<f64>() / (k - 1.0);
    let test = rows as f64 / k;
    let scale = (variance * (1.0 / k + test / (rows as f64 - test))).sqrt();
    if scale <= 0.0 {
        return Some(Paired { difference: mean, t: 0.0, p_value: 1.0 });
    }
    let t = mean / scale;
    let p_value = StudentsT::new(0.0, 1.0, k - 1.0).map_or(1.0, |student| 2.0 * student.sf(t.abs()));
    Some(Paired { difference: mean, t, p_value })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_paired_test_sees_a_steady_difference_and_no_noise() {
        let reference: Vec<(f64, usize)> = (0..10).map(|k| (100.0 + f64::from(k % 3), 20)).collect();
        let worse: Vec<(f64, usize)> = reference.iter().map(|&(s, n)| (s * 1.2, n)).collect();
        let noisy: Vec<(f64, usize)> = reference
            .iter()
            .enumerate()
            .map(|(k, &(s, n))| (s + if k % 2 == 0 { 3.0 } else { -3.0 }, n))
            .collect();
        assert!(paired(&reference, &worse, 200).unwrap().p_value < 1e-6);
        assert!(paired(&reference, &noisy, 200).unwrap().p_value > 0.5);
    }
}
