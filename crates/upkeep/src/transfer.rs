//! An identified arm in another installation.
//!
//! ```text
//! δ̂ = D Pᵀ S⁻¹ r,   D = (Pᵀ S⁻¹ P)⁻¹                               installation, arm frozen
//! cov(δ̂ − δ) = D,   cov(δ − δ̂, e) = −D Pᵀ S⁻¹ H C                   what its uncertainty shares with the arm's
//! T = rᵀ S⁻¹ r − rᵀ S⁻¹ P D Pᵀ S⁻¹ r,  T/(m − k) ~ F(m − k, ν)     does the arm still fit?
//! ê = C Hᵀ S⁻¹ (r − P δ̂),   cov(e) = C − C Hᵀ Q H C                  update,  Q = S⁻¹ − S⁻¹ P D Pᵀ S⁻¹
//! ```
//!
//! Symbols as in the crate's README. The frozen arm is not taken to be exact: its covariance is part of S (the *consider* covariance of
//! Schmidt 1966), so that bands of predictions hold in the new installation. The update is the linear Bayes estimate with a flat prior for
//! the installation, linearised again at each step.

use crate::UpkeepError;
use crate::advice::{Advised, advised};
use crate::installation::{Installation, moved, with_columns};
use crate::noise_law::NoiseLaw;
use crate::prediction::{Prediction, Weighing, oriented, seen};
use crate::rows::carried;
use crate::tails::Tails;
use nalgebra::{Cholesky, DMatrix, DVector, Dyn};
use serde::Serialize;
use truepose_errormodel::{Beyond, Coverage, Dataset, Domain, FittedModel};
use truepose_identify::{Residuals, Spread, place_fitted};
use truepose_kinematics::{Chain, Conditions, Site};

/// Steps of the estimate; each is linearised again.
const STEPS: usize = 4;

/// What is found, and what may move.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct TransferOptions {
    /// What is new.
    pub installation: Installation,
    /// Lets the errors of the arm move within their covariance.
    pub update: bool,
}

/// Whether the arm as identified explains the new measurements.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct ArmFits {
    /// T.
    pub chi_square: f64,
    /// m − k.
    pub degrees_of_freedom: usize,
    /// P(χ² ≥ T); `None` without degrees of freedom.
    pub p_value: Option<f64>,
    /// The row (0-based) with the largest residual in standard deviations, and that residual.
    pub worst: Option<(usize, f64)>,
}

/// 3-D standard deviation of predicted positions over the configurations of the fit, m: what coefficients and installation leave open.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Band {
    /// Root mean square.
    pub rms: f64,
    /// Largest.
    pub max: f64,
}

/// A fit in its new installation.
#[derive(Debug, Clone)]
pub struct Transfer {
    /// The fit; its covariance includes that of the installation.
    pub fitted: FittedModel,
    /// What was found, in words: `base`, `tool`, names of targets.
    pub found: Vec<String>,
    /// Standard deviations of base, tool and targets as found: what, axis, m or rad.
    pub deviations: Vec<(Site, f64)>,
    /// 3-D residuals, m.
    pub residual: Spread,
    /// RMS to expect of these rows, m: noise and what the arm leaves open, less what the installation takes.
    pub expected: f64,
    /// Whether the arm still fits.
    pub fits: ArmFits,
    /// In the installation of the fit, and in the new one; `None` where the fit file holds no configurations.
    pub bands: Option<(Band, Band)>,
    /// Rows (0-based) beyond the data of the fit.
    pub beyond: Vec<usize>,
    /// Configurations whose measurement would narrow the band most, best first.
    pub advised: Vec<Advised>,
    /// Largest change of a coefficient by the update, in its standard deviations before; `None` of a frozen arm.
    pub largest_update: Option<f64>,
}

/// Finds base (tool, targets) of an identified arm in a new installation from few poses.
///
/// # Errors
/// When the data lacks what the model reads, or does not determine the installation.
pub fn transfer(
    fitted: &FittedModel,
    data: &Dataset,
    options: TransferOptions,
) -> Result<Transfer, UpkeepError> {
    let unknown = options.installation.unknown(fitted.chain())?;
    let placement = place_fitted(fitted, &unknown, data)?;
    let sites = options.installation.sites(&placement, &seen(data), oriented(fitted, data))?;
    let placement = placement.checked()?;
    let (mut now, places) = with_columns(&fitted.on(placement.chain.clone())?, &sites)?;
    let prior = now.clone();
    let mut estimate = None;
    for _ in 0..STEPS {
        let mut rows = Prediction::of(&now, &sites, data)?;
        if rows.len() < sites.len() {
            return Err(UpkeepError::TooFew { have: rows.len(), need: sites.len() });
        }
        // As seen from where the covariance is centred.
        let away = DVector::from_fn(now.coefficients().len(), |k, _| {
            now.coefficients()[k] - prior.coefficients()[k]
        });
        rows.residual += &rows.arm * away;
        let found = Estimate::of(&rows, prior.covariance())?;
        let chain = moved(now.chain(), &sites, &found.installation)?;
        let coefficients = match options.update {
            true => prior.coefficients().iter().zip(found.arm.iter()).map(|(c, e)| c + e).collect(),
            false => prior.coefficients().to_vec(),
        };
        now = at(&prior, chain, coefficients, prior.covariance().clone())?;
        estimate = Some((rows, found));
    }
    let Some((rows, found)) = estimate else {
        return Err(UpkeepError::TooFew { have: 0, need: sites.len() });
    };
    let covariance = found.covariance(&prior, &places, options.update);
    let moved_by = |k: usize| {
        let sd = prior.covariance()[(k, k)].max(0.0).sqrt();
        if sd > 0.0 { found.arm[k].abs() / sd } else { 0.0 }
    };
    let largest_update = options.update.then(|| (0..found.arm.len()).map(moved_by).fold(0.0, f64::max));
    let mut now = at(&prior, now.chain().clone(), now.coefficients().to_vec(), covariance)?;
    now.domain.sample = carried(fitted, &now)?;
    if options.update {
        now.domain.widen(&Domain::of(data));
    }
    let expected = rows.expected(&prior, prior.covariance());
    let mut fits = found.fits(&rows, NoiseLaw::of(fitted));
    if let Some(tails) = Tails::of(fitted)? {
        let mut rows = rows;
        tails.bound(&mut rows);
        let law = NoiseLaw::of(fitted).share(tails.freedom);
        let bounded = Estimate::of(&rows, prior.covariance())?.chi_square;
        let freedom = tails.freedom * fits.degrees_of_freedom as f64;
        fits.p_value = fits.p_value.map(|_| law.beyond_of(tails.freedom * bounded, freedom));
    }
    let advised = advised(&now, &sites, &found.spread, data)?;
    let bands = match (band(fitted)?, band(&now)?) {
        (Some(before), Some(after)) => Some((before, after)),
        _ => None,
    };
    let beyond = beyond(fitted, data)?;
    let residual = Residuals::of(&now, data)?.positions();
    let deviations = sites.iter().enumerate().map(|(k, &site)| (site, found.spread[(k, k)].sqrt())).collect();
    Ok(Transfer {
        fitted: now,
        found: placement.found,
        deviations,
        residual,
        expected,
        fits,
        bands,
        beyond,
        advised,
        largest_update,
    })
}

/// The fit with another robot, coefficients and covariance.
fn at(
    fitted: &FittedModel,
    chain: Chain,
    coefficients: Vec<f64>,
    covariance: DMatrix<f64>,
) -> Result<FittedModel, UpkeepError> {
    let fallback = fitted.on(chain.clone())?.fallback;
    let moved = FittedModel::new(fitted.model().on(chain)?, coefficients, covariance)?;
    Ok(moved
        .with_channels(fitted.channels.clone())
        .with_domain(fitted.domain.clone())
        .with_noise(fitted.noise)
        .with_repeatability(fitted.repeatability_sd)
        .with_fallback(fallback)
        .with_loads(fitted.loads.clone())
        .with_provenance(fitted.provenance.clone()))
}

/// The installation and the arm, estimated.
struct Estimate {
    /// δ̂.
    installation: DVector<f64>,
    /// ê.
    arm: DVector<f64>,
    /// D.
    spread: DMatrix<f64>,
    /// cov(δ − δ̂, e), k × p.
    shared: DMatrix<f64>,
    /// C Hᵀ Q H C, p × p.
    learned: DMatrix<f64>,
    chi_square: f64,
}

impl Estimate {
    fn of(rows: &Prediction, covariance: &DMatrix<f64>) -> Result<Self, UpkeepError> {
        let weighing = Weighing::of(rows, covariance)?;
        let (p, h) = (&rows.installation, &rows.arm);
        let r = DMatrix::from_column_slice(rows.len(), 1, rows.residual.as_slice());
        let factor = factor(weighing.product(p, p))?;
        let spread = factor.inverse();
        let pull = weighing.product(p, &r);
        let delta = factor.solve(&pull);
        let p_h = weighing.product(p, h);
        // Hᵀ Q r and Hᵀ Q H.
        let h_r = weighing.product(h, &r) - p_h.tr_mul(&delta);
        let h_h = weighing.product(h, h) - p_h.tr_mul(&factor.solve(&p_h));
        let chi_square = weighing.product(&r, &r)[(0, 0)] - pull.dot(&delta);
        Ok(Estimate {
            installation: delta.column(0).into_owned(),
            arm: (covariance * h_r).column(0).into_owned(),
            shared: -(&spread * &p_h * covariance),
            learned: covariance * h_h * covariance,
            spread,
            chi_square: chi_square.max(0.0),
        })
    }

    /// Of all columns: the arm's, with the installation's at its own places.
    fn covariance(&self, prior: &FittedModel, places: &[usize], update: bool) -> DMatrix<f64> {
        // cov(e − ê): with the update what was learned is gone, and with it what e shares with the installation.
        let mut covariance = prior.covariance().clone();
        if update {
            covariance -= &self.learned;
        }
        let mut whole = covariance;
        for (i, &a) in places.iter().enumerate() {
            for column in 0..whole.ncols() {
                whole[(a, column)] += self.shared[(i, column)];
            }
        }
        for (i, &a) in places.iter().enumerate() {
            for row in 0..whole.nrows() {
                whole[(row, a)] += self.shared[(i, row)];
            }
        }
        for (i, &a) in places.iter().enumerate() {
            for (j, &b) in places.iter().enumerate() {
                whole[(a, b)] += self.spread[(i, j)];
            }
        }
        (&whole + whole.transpose()) * 0.5
    }

    fn fits(&self, rows: &Prediction, law: NoiseLaw) -> ArmFits {
        let degrees_of_freedom = rows.len() - self.installation.len();
        let left = &rows.residual - &rows.installation * &self.installation;
        let worst = left.iter().enumerate().max_by(|a, b| a.1.abs().total_cmp(&b.1.abs()));
        ArmFits {
            chi_square: self.chi_square,
            degrees_of_freedom,
            p_value: (degrees_of_freedom > 0).then(|| law.beyond(self.chi_square, degrees_of_freedom)),
            worst: worst.map(|(at, value)| (rows.numbers[at].row, value.abs())),
        }
    }
}

fn factor(information: DMatrix<f64>) -> Result<Cholesky<f64, Dyn>, UpkeepError> {
    let open = UpkeepError::Undetermined {
        what: "the installation".into(),
        advice: "measure poses that differ more, or more targets".into(),
    };
    Cholesky::new(information).ok_or(open)
}

/// Over the configurations of the fit.
fn band(fitted: &FittedModel) -> Result<Option<Band>, UpkeepError> {
    let sample = fitted.domain.sample.rows();
    if sample.is_empty() {
        return Ok(None);
    }
    let mut predictor = fitted.bind(&sample.schema)?;
    let mut conditions = Conditions::default();
    let (mut sum, mut max) = (0.0, 0.0_f64);
    for row in 0..sample.len() {
        sample.conditions_into(row, &mut conditions);
        let trace = predictor.with_covariance(&conditions, sample.target[row]).1.trace().max(0.0);
        sum += trace;
        max = max.max(trace);
    }
    Ok(Some(Band { rms: (sum / sample.len() as f64).sqrt(), max: max.sqrt() }))
}

/// Rows beyond the ranges of the data of the fit.
fn beyond(fitted: &FittedModel, data: &Dataset) -> Result<Vec<usize>, UpkeepError> {
    let data = &*data.derived_for(fitted.model())?;
    let mut coverage = Coverage::new(fitted, &data.schema)?;
    let mut conditions = Conditions::default();
    // A larger variance than in the fit comes from the installation.
    let ranged = |(what, _): &(Beyond, f64)| *what != Beyond::Leverage;
    let outside = |&row: &usize| {
        data.conditions_into(row, &mut conditions);
        coverage.judge(&conditions, data.target[row]).beyond.iter().any(ranged)
    };
    Ok((0..data.len()).filter(outside).collect())
}
