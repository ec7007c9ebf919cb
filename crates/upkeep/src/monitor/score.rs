//! Score tests of what may have changed: the residual weighed with Q, for one suspect after the other.

use super::suspects::Suspect;
use super::{Change, Coefficient, Detectable};
use crate::UpkeepError;
use crate::noise_law::NoiseLaw;
use crate::prediction::{Prediction, Weighing};
use crate::tails::Tails;
use nalgebra::{Cholesky, DMatrix, DVector, Dyn, SymmetricEigen};
use statrs::distribution::{ContinuousCDF, Normal};
use truepose_errormodel::FittedModel;

/// Share of a suspect's information that what is known otherwise takes, above which its change cannot be seen.
pub(super) const ABSORBED: f64 = 1e-6;
/// Power with which a detectable change is found.
const POWER: f64 = 0.9;

/// The residual with Q.
pub(super) struct ScoreTest {
    weighing: Weighing,
    residual: DMatrix<f64>,
    installation: DMatrix<f64>,
    /// (PᵀS⁻¹P)⁻¹; none without an installation that is found anew.
    inner: Option<Cholesky<f64, Dyn>>,
    chi_square: f64,
    freedom: usize,
    law: NoiseLaw,
    /// Degrees of freedom of a squared number, over those of a normal one.
    share: f64,
    /// Whitened numbers for one of these.
    unit: f64,
}

impl ScoreTest {
    /// `tails`: those by which the rows were bounded.
    pub fn of(fitted: &FittedModel, rows: &Prediction, tails: Option<Tails>) -> Result<Self, UpkeepError> {
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
        let (share, unit) = tails.map_or((1.0, 1.0), |tails| (tails.freedom, tails.unit()));
        let law = NoiseLaw::of(fitted).share(share);
        let mut test =
            ScoreTest { weighing, residual, installation, inner, chi_square: 0.0, freedom, law, share, unit };
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

    /// HᵀQH of all columns of the model.
    pub fn information(&self, rows: &Prediction) -> DMatrix<f64> {
        self.product(&rows.arm, &rows.arm)
    }

    pub fn overall(&self) -> f64 {
        self.law.beyond_of(self.share * self.chi_square, self.share * self.freedom as f64)
    }

    /// The whitened columns X of a suspect and their information XᵀQX; none where these rows do not show it.
    pub fn visible(&self, rows: &Prediction, suspect: &Suspect) -> Option<(DMatrix<f64>, DMatrix<f64>)> {
        let x = rows.arm.select_columns(&suspect.columns);
        let information = self.product(&x, &x);
        let alone = x.tr_mul(&x);
        let seen =
            (0..x.ncols()).any(|k| information[(k, k)] > ABSORBED * alone[(k, k)] && alone[(k, k)] > 0.0);
        seen.then_some((x, information))
    }

    /// −2 ln L relative to no change (negative), and the change.
    pub fn judge(&self, fitted: &FittedModel, rows: &Prediction, suspect: &Suspect) -> Option<(f64, Change)> {
        let (x, information) = self.visible(rows, suspect)?;
        let pull = self.product(&x, &self.residual).column(0).into_owned();
        let (inverse, rank) = pseudo_inverse(&information)?;
        let change: DVector<f64> = &inverse * &pull;
        let gain = pull.dot(&change).max(0.0);
        let p_value = self.law.beyond(gain, rank);
        let coefficients = suspect.columns.iter().enumerate().map(|(k, &column)| {
            let about = &fitted.model().columns()[column];
            let half = self.law.half() * inverse[(k, k)].max(0.0).sqrt();
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
        let change = Change { what, also: Vec::new(), family, coefficients, moves, p_value, behind: 0.0 };
        Some((deviance, change))
    }

    /// 3-D RMS, m, of a whitened move of the measured numbers.
    fn moves(&self, fitted: &FittedModel, rows: &Prediction, whitened: &DVector<f64>) -> f64 {
        (3.0 * whitened.norm_squared() / rows.len() as f64).sqrt() * fitted.noise.position_sd * self.unit
    }

    pub fn detectable(
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
pub(super) fn pseudo_inverse(information: &DMatrix<f64>) -> Option<(DMatrix<f64>, usize)> {
    let n = information.ncols();
    if n == 0 {
        return None;
    }
    let scale: Vec<f64> = (0..n)
        .map(|k| if information[(k, k)] > 0.0 { 1.0 / information[(k, k)].sqrt() } else { 0.0 })
        .collect();
    let scaled = DMatrix::from_fn(n, n, |i, j| information[(i, j)] * scale[i] * scale[j]);
    let eigen = SymmetricEigen::new(scaled);
    let kept: Vec<usize> = (0..n).filter(|&k| eigen.eigenvalues[k] > 1e-9).collect();
    let mut inverse = DMatrix::zeros(n, n);
    for &k in &kept {
        let v = eigen.eigenvectors.column(k);
        inverse += v * v.transpose() / eigen.eigenvalues[k];
    }
    let inverse = DMatrix::from_fn(n, n, |i, j| inverse[(i, j)] * scale[i] * scale[j]);
    (!kept.is_empty()).then_some((inverse, kept.len()))
}
