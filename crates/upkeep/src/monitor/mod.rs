//! Whether a robot has changed since it was calibrated.
//!
//! ```text
//! T_0 = rᵀ Q r ~ χ²(m − k)                                          anything at all
//! G_i = gᵀ (H_iᵀ Q H_i)⁻¹ g ~ χ²(n_i),   g = H_iᵀ Q r               the coefficients of suspect i
//! Δ_i = (H_iᵀ Q H_i)⁻¹ g ± z √diag (H_iᵀ Q H_i)⁻¹
//! p = min(1, 2 min(p_0, K min_i p_i))                               Bonferroni over both tests and K suspects
//! ```
//!
//! Q as in [`crate::transfer`]: residuals weighed with noise and with what the fit leaves open, an installation that is found anew projected out.
//! Source: score tests, Rao (1948). A change that one coefficient explains is looked for in the directions of the suspects; any other one in
//! T_0.

mod spending;
mod suspects;

pub use spending::level;

use crate::UpkeepError;
use crate::installation::Installation;
use crate::prediction::{Prediction, Weighing, seen};
use nalgebra::{Cholesky, DMatrix, DVector};
use serde::Serialize;
use statrs::distribution::{ChiSquared, ContinuousCDF, Normal};
use suspects::{Suspect, suspects};
use truepose_errormodel::{Dataset, FittedModel, Visits};
use truepose_identify::place_fitted;

/// Share of a suspect's information that what is known otherwise takes, above which its change cannot be seen.
const ABSORBED: f64 = 1e-6;
/// Suspects whose −2 ln L is within this of the best one are listed beside it: odds below ten to one.
const TIED: f64 = 4.6;
/// Power with which a detectable change is found.
const POWER: f64 = 0.9;

/// How a robot is looked at.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MonitorOptions {
    /// Probability that an unchanged robot ever raises an alarm, over all looks.
    pub alpha: f64,
    /// Looks before this one.
    pub looks: usize,
    /// What is found anew from these data, because instrument, base, tool or targets were moved.
    pub installation: Installation,
}

impl Default for MonitorOptions {
    fn default() -> Self {
        MonitorOptions { alpha: 0.01, looks: 0, installation: Installation::SAME }
    }
}

/// The change of one coefficient.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Coefficient {
    /// Its name in the fit.
    pub name: String,
    /// Δ, in its unit.
    pub change: f64,
    /// 95 % interval.
    pub ci95: [f64; 2],
    /// Its unit.
    pub unit: String,
}

/// The change of a constant error, or of an effect, if it alone has changed.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Change {
    /// What: `rz@j3`, `transmission j1`.
    pub what: String,
    /// Family of the effect.
    pub family: String,
    /// Its coefficients.
    pub coefficients: Vec<Coefficient>,
    /// RMS by which it moves the measured positions, m.
    pub moves: f64,
    /// Of this suspect alone, as a single test.
    pub p_value: f64,
    /// −2 ln L of the best suspect less that of this one.
    pub behind: f64,
}

/// The smallest change that these poses show.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Detectable {
    /// What.
    pub what: String,
    /// Smallest change of one coefficient found with 90 % probability at the level of this look, in its unit.
    pub change: f64,
    /// Its unit.
    pub unit: String,
    /// RMS by which that moves the measured positions, m.
    pub moves: f64,
}

/// What one look says.
#[derive(Debug, Clone, PartialEq)]
pub struct Look {
    /// Rows and pose measurements.
    pub rows: usize,
    /// Pose measurements.
    pub poses: usize,
    /// 3-D RMS of the residual, m.
    pub rms: f64,
    /// What to expect of an unchanged robot, m.
    pub expected: f64,
    /// p of the look.
    pub p_value: f64,
    /// p of anything at all.
    pub p_overall: f64,
    /// Level of this look.
    pub level: f64,
    /// Whether p is below it.
    pub changed: bool,
    /// Suspects, the best first; those that these poses cannot show are left out.
    pub changes: Vec<Change>,
    /// How many of the first ones these poses cannot tell apart.
    pub tied: usize,
    /// What change would be found, the least visible first.
    pub detectable: Vec<Detectable>,
    /// Suspects that these poses cannot show.
    pub invisible: Vec<String>,
    /// What was found anew.
    pub placed: Vec<String>,
}

/// Holds new measurements against a fit.
///
/// # Errors
/// When the data lacks what the model reads, or does not determine what is found anew; when the fit has no uncertainty.
pub fn monitor(fitted: &FittedModel, data: &Dataset, options: MonitorOptions) -> Result<Look, UpkeepError> {
    if !(options.alpha > 0.0 && options.alpha < 1.0) {
        let value = options.alpha;
        return Err(UpkeepError::Option { option: "alpha", value, expected: "between 0 and 1" });
    }
    let placement = place_fitted(fitted, &options.installation.unknown(fitted.chain())?, data)?;
    if let Some(open) = placement.undetermined.first() {
        return Err(UpkeepError::Undetermined { what: open.what.clone(), advice: open.advice.clone() });
    }
    let (targets, tool_seen) = seen(data);
    let sites = options.installation.sites(fitted.chain(), &targets, tool_seen);
    let fitted = fitted.on(placement.chain)?;
    let rows = Prediction::of(&fitted, &sites, data)?;
    if rows.len() <= sites.len() {
        return Err(UpkeepError::TooFew { have: rows.len(), need: sites.len() + 1 });
    }
    let test = Test::of(&fitted, &rows)?;
    let level = level(options.alpha, options.looks + 1);
    let candidates = suspects(&fitted, &sites);
    let (mut changes, mut invisible) = (Vec::new(), Vec::new());
    let mut detectable = Vec::new();
    let count = candidates.len().max(1) as f64;
    for suspect in &candidates {
        match test.judge(&fitted, &rows, suspect) {
            Some(found) => {
                changes.push(found);
                detectable.extend(test.detectable(&fitted, &rows, suspect, level / (2.0 * count)));
            }
            None => invisible.push(suspect.word.clone()),
        }
    }
    changes.sort_by(|a, b| a.0.total_cmp(&b.0));
    let best = changes.first().map_or(0.0, |first| first.0);
    let least = changes.iter().map(|(_, change)| change.p_value).fold(1.0, f64::min);
    let changes: Vec<Change> =
        changes.into_iter().map(|(deviance, change)| Change { behind: deviance - best, ..change }).collect();
    let p_overall = test.overall();
    let p_value = (2.0 * p_overall.min(count * least)).min(1.0);
    detectable.sort_by(|a, b| b.moves.total_cmp(&a.moves));
    let squares = rows.distances.iter().map(|d| d * d).sum::<f64>() / rows.distances.len().max(1) as f64;
    Ok(Look {
        rows: data.len(),
        poses: Visits::of(data).len(),
        rms: squares.sqrt(),
        expected: test.expected(&fitted, &rows),
        p_value,
        p_overall,
        level,
        changed: p_value < level,
        tied: changes.iter().take_while(|change| change.behind < TIED).count(),
        changes,
        detectable,
        invisible,
        placed: placement.found,
    })
}

/// Residuals with Q.
struct Test {
    weighing: Weighing,
    residual: DMatrix<f64>,
    installation: DMatrix<f64>,
    /// (PᵀS⁻¹P)⁻¹; none without an installation that is found anew.
    inner: Option<Cholesky<f64, nalgebra::Dyn>>,
    chi_square: f64,
    freedom: usize,
}

impl Test {
    fn of(fitted: &FittedModel, rows: &Prediction) -> Result<Self, UpkeepError> {
        let weighing = Weighing::of(rows, fitted.covariance())?;
        let installation = rows.installation.clone();
        let inner = match installation.ncols() {
            0 => None,
            _ => Some(Cholesky::new(weighing.product(&installation, &installation)).ok_or(
                UpkeepError::Undetermined {
                    what: "the installation".into(),
                    advice: "measure poses that differ more, or more targets".into(),
                },
            )?),
        };
        let residual = DMatrix::from_column_slice(rows.len(), 1, rows.residual.as_slice());
        let freedom = rows.len() - installation.ncols();
        let mut test = Test { weighing, residual, installation, inner, chi_square: 0.0, freedom };
        test.chi_square = test.product(&test.residual, &test.residual)[(0, 0)].max(0.0);
        Ok(test)
    }

    /// aᵀ Q b.
    fn product(&self, a: &DMatrix<f64>, b: &DMatrix<f64>) -> DMatrix<f64> {
        let whole = self.weighing.product(a, b);
        match &self.inner {
            None => whole,
            Some(inner) => {
                let (p_a, p_b) = (
                    self.weighing.product(&self.installation, a),
                    self.weighing.product(&self.installation, b),
                );
                whole - p_a.tr_mul(&inner.solve(&p_b))
            }
        }
    }

    fn overall(&self) -> f64 {
        ChiSquared::new(self.freedom as f64).map_or(1.0, |law| law.sf(self.chi_square))
    }

    /// 3-D RMS that an unchanged robot would have, m: noise, and what the fit leaves open.
    fn expected(&self, fitted: &FittedModel, rows: &Prediction) -> f64 {
        let sd = fitted.noise.position_sd;
        let own = (rows.installation.ncols() as f64 / rows.len() as f64).min(1.0);
        // Whitened columns: m² of a component is one of V.
        let spread =
            (&rows.arm * crate::prediction::root(fitted.covariance())).norm_squared() / rows.len() as f64;
        (3.0 * sd * sd * (1.0 + spread) * (1.0 - own)).sqrt()
    }

    /// Columns that these rows can show, scaled to one standard deviation of what is seen: (columns of the model, X, information, scale).
    fn visible(&self, rows: &Prediction, suspect: &Suspect) -> Option<(DMatrix<f64>, DMatrix<f64>)> {
        let x = rows.arm.select_columns(&suspect.columns);
        let information = self.product(&x, &x);
        let alone = x.tr_mul(&x);
        let seen =
            (0..x.ncols()).any(|k| information[(k, k)] > ABSORBED * alone[(k, k)] && alone[(k, k)] > 0.0);
        seen.then_some((x, information))
    }

    /// −2 ln L relative to no change (negative), and the change.
    fn judge(&self, fitted: &FittedModel, rows: &Prediction, suspect: &Suspect) -> Option<(f64, Change)> {
        let (x, information) = self.visible(rows, suspect)?;
        let pull = self.product(&x, &self.residual).column(0).into_owned();
        let (inverse, rank) = pseudo_inverse(&information)?;
        let change: DVector<f64> = &inverse * &pull;
        let gain = pull.dot(&change).max(0.0);
        let p_value = ChiSquared::new(rank as f64).map_or(1.0, |law| law.sf(gain));
        let coefficients = suspect.columns.iter().enumerate().map(|(k, &column)| {
            let about = &fitted.model().columns()[column];
            let half = 1.959_963_985 * inverse[(k, k)].max(0.0).sqrt();
            Coefficient {
                name: about.name.clone(),
                change: change[k],
                ci95: [change[k] - half, change[k] + half],
                unit: about.unit.clone(),
            }
        });
        // A coefficient more has to gain as much as it takes by chance.
        let deviance = -gain + rank as f64 * (self.freedom as f64).ln();
        let moves = self.moves(fitted, rows, &(&x * &change));
        let (what, family) = (suspect.word.clone(), suspect.family.clone());
        let coefficients = coefficients.collect();
        Some((deviance, Change { what, family, coefficients, moves, p_value, behind: 0.0 }))
    }

    /// 3-D RMS, m, of a whitened move of the measured numbers.
    fn moves(&self, fitted: &FittedModel, rows: &Prediction, whitened: &DVector<f64>) -> f64 {
        (3.0 * whitened.norm_squared() / rows.len() as f64).sqrt() * fitted.noise.position_sd
    }

    fn detectable(
        &self,
        fitted: &FittedModel,
        rows: &Prediction,
        suspect: &Suspect,
        level: f64,
    ) -> Option<Detectable> {
        let (x, information) = self.visible(rows, suspect)?;
        let normal = Normal::standard();
        let need = -normal.inverse_cdf(0.5 * level) + normal.inverse_cdf(POWER);
        // The coefficient that is seen least.
        let (k, change) = (0..x.ncols())
            .filter(|&k| information[(k, k)] > 0.0)
            .map(|k| (k, need / information[(k, k)].sqrt()))
            .max_by(|a, b| a.1.total_cmp(&b.1))?;
        let about = &fitted.model().columns()[suspect.columns[k]];
        let moves = self.moves(fitted, rows, &(x.column(k) * change));
        Some(Detectable { what: suspect.word.clone(), change, unit: about.unit.clone(), moves })
    }
}

/// Inverse over the directions that the data shows, and how many they are.
fn pseudo_inverse(information: &DMatrix<f64>) -> Option<(DMatrix<f64>, usize)> {
    let n = information.ncols();
    let scale: Vec<f64> = (0..n)
        .map(|k| if information[(k, k)] > 0.0 { 1.0 / information[(k, k)].sqrt() } else { 0.0 })
        .collect();
    let scaled = DMatrix::from_fn(n, n, |i, j| information[(i, j)] * scale[i] * scale[j]);
    let eigen = nalgebra::SymmetricEigen::new(scaled);
    let kept: Vec<usize> = (0..n).filter(|&k| eigen.eigenvalues[k] > 1e-9).collect();
    let mut inverse = DMatrix::zeros(n, n);
    for &k in &kept {
        let v = eigen.eigenvectors.column(k);
        inverse += v * v.transpose() / eigen.eigenvalues[k];
    }
    let inverse = DMatrix::from_fn(n, n, |i, j| inverse[(i, j)] * scale[i] * scale[j]);
    (!kept.is_empty()).then_some((inverse, kept.len()))
}
