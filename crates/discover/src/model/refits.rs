//! How well a model predicts poses that its fit has not seen: cross-validation by whole refits.
//!
//! ```text
//! e_i = y_i − ŷ_i(c_{−F(i)}),   c_{−F} = fit of the same structure to all training rows outside of fold F
//! ```
//!
//! | symbol | here | unit |
//! | --- | --- | --- |
//! | F(i) | fold of row i: whole configurations, [`FOLDS`] at random | 1 |
//! | e_i | [`Refits::residuals`]: exact prediction, nothing linearised | m, rad |
//!
//! The evidence of a candidate ([`crate::accept::evidence`]) comes from the linearised problem. A weak direction, a far pose or a fit that does not converge
//! do their harm where the picture is not linear, so every change of the model is compared here once more before it is kept. Structure,
//! nonlinear parameters, noise and prior are those of all training rows; coefficients are refitted in each fold.

use crate::error::DiscoverError;
use crate::model::current::{Ground, Working};
use rayon::prelude::*;
use truepose_errormodel::configurations;
use truepose_identify::{FitOptions, Folds, NoiseModel, NoiseSource, Residuals, Split, fit_again};

/// Folds of the refits.
const FOLDS: usize = 5;

/// Residuals of the training rows, each by a fit that has not seen its configuration.
#[derive(Debug, Clone)]
pub(crate) struct Refits {
    pub residuals: Residuals,
    /// Whether every refit converged.
    pub converged: bool,
}

/// Two models on the same unseen rows.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Comparison {
    /// Mean squared deviation of all observations, of the second model over the first, in the first one's standard deviations.
    pub deviation: f64,
    /// RMS of the 3-D position error, second over first; one where no position was measured.
    pub position: f64,
}

/// Share of the position error that counts: what an effect has to gain to matter at all.
const COUNTS: f64 = 0.02;

impl Comparison {
    /// Whether the second model, with an effect more, predicts no better than the first. Where positions and orientations weigh against each
    /// other the position may lose what does not count.
    pub fn is_no_gain(&self) -> bool {
        let gain = self.deviation < 1.0 && self.position < 1.0 + COUNTS;
        !gain
    }

    /// Whether the second model predicts worse than the first by something that counts.
    pub fn is_loss(&self) -> bool {
        let as_good = self.deviation.sqrt() < 1.0 + COUNTS && self.position < 1.0 + COUNTS;
        !as_good
    }
}

impl Ground<'_> {
    /// Refits a model with each fold of the training rows left out. Rows that are kept out of its fit are not judged.
    pub fn refits(&self, working: &Working, seed: u64) -> Result<Refits, DiscoverError> {
        let data = &working.data;
        let count = configurations(data).iter().max().map_or(0, |last| last + 1);
        let folds = Folds::new(data, &Split::Random { folds: FOLDS.min(count), seed })?;
        let options = FitOptions { noise: NoiseSource::Fixed(working.fit.noise), ..self.fit.clone() };
        let parts: Vec<(Vec<usize>, Residuals, bool)> = (0..folds.count)
            .into_par_iter()
            .map(|fold| -> Result<_, DiscoverError> {
                let (held, kept): (Vec<usize>, Vec<usize>) =
                    (0..data.len()).partition(|&row| folds.of_visit[data.visit[row]] == fold);
                let fit = fit_again(&working.fit, &data.select(&kept), self.solver, &options)?;
                let residuals = Residuals::of(&fit.fitted, &data.select(&held))?;
                Ok((held, residuals, fit.converged))
            })
            .collect::<Result<_, _>>()?;
        let mut all = Residuals {
            position: vec![nalgebra::Vector3::repeat(f64::NAN); data.len()],
            orientation: vec![None; data.len()],
        };
        let mut converged = true;
        for (held, residuals, settled) in parts {
            converged &= settled;
            for (k, row) in held.into_iter().enumerate() {
                all.position[row] = residuals.position[k];
                all.orientation[row] = residuals.orientation[k];
            }
        }
        Ok(Refits { residuals: all, converged })
    }
}

/// The second model against the first, on the rows that both predict. None where they have none in common.
pub(crate) fn compared(first: &Residuals, second: &Residuals, noise: NoiseModel) -> Option<Comparison> {
    let (mut sums, mut squares, mut seen) = ([0.0; 2], [0.0; 2], [0usize; 2]);
    for row in 0..first.position.len() {
        for axis in 0..3 {
            let pair = [first.position[row][axis], second.position[row][axis]];
            if pair.iter().all(|v| v.is_finite()) {
                let sd = noise.position(f64::NAN).hypot(noise.visit_sd);
                (0..2).for_each(|k| sums[k] += (pair[k] / sd).powi(2));
                seen[0] += 1;
            }
        }
        if let (Some(a), Some(b)) = (first.distance(row), second.distance(row)) {
            squares[0] += a * a;
            squares[1] += b * b;
            seen[1] += 1;
        }
        if let (Some(a), Some(b)) = (first.orientation[row], second.orientation[row]) {
            let sd = noise.orientation(f64::NAN);
            sums[0] += (a / sd).norm_squared();
            sums[1] += (b / sd).norm_squared();
            seen[0] += 1;
        }
    }
    if seen[0] == 0 || sums[0] <= 0.0 {
        return None;
    }
    let position = if seen[1] > 0 && squares[0] > 0.0 { (squares[1] / squares[0]).sqrt() } else { 1.0 };
    Some(Comparison { deviation: sums[1] / sums[0], position })
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Vector3;

    fn of(rows: &[[f64; 3]]) -> Residuals {
        Residuals {
            position: rows.iter().map(|&row| Vector3::from(row)).collect(),
            orientation: vec![None; rows.len()],
        }
    }

    #[test]
    fn only_rows_that_both_predict_count() {
        let first = of(&[[1e-4, 0.0, 0.0], [f64::NAN; 3], [0.0, 2e-4, 0.0]]);
        let second = of(&[[5e-5, 0.0, 0.0], [9.0, 0.0, 0.0], [0.0, 1e-4, 0.0]]);
        let compared = compared(&first, &second, NoiseModel::default()).expect("two rows in common");
        assert!((compared.position - 0.5).abs() < 1e-12 && (compared.deviation - 0.25).abs() < 1e-12);
        assert!(!compared.is_no_gain() && !compared.is_loss());
    }

    #[test]
    fn a_model_that_is_as_good_as_the_other_is_no_gain() {
        let rows = of(&[[1e-4, 0.0, 0.0], [0.0, 2e-4, 0.0]]);
        let compared = compared(&rows, &rows, NoiseModel::default()).expect("rows");
        assert!(compared.is_no_gain() && !compared.is_loss());
    }

    #[test]
    fn nothing_in_common_is_no_comparison() {
        let nothing = of(&[[f64::NAN; 3]]);
        assert_eq!(compared(&nothing, &nothing, NoiseModel::default()), None);
    }
}
