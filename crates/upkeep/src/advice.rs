//! Which configurations of the fit to measure next in a new installation, and which ones before anything is measured there.
//!
//! ```text
//! min Σ_i tr P_i (D⁻¹ + Σ_j P_jᵀP_j/σ²)⁻¹ P_iᵀ        i: configurations of the fit, j: those that are measured
//! ```
//!
//! I-optimal design (Fedorov 1972), D and P as in the crate's README. After a transfer, one configuration after the other is added to what was
//! measured. Before it, D is that of an installation of which nothing is known, and the configurations that were chosen one after the other are
//! exchanged as long as that narrows the band. All targets are taken to be measured at each.

use crate::UpkeepError;
use crate::installation::{Installation, derivatives};
use nalgebra::DMatrix;
use truepose_errormodel::{Dataset, FittedModel};
use truepose_kinematics::{Axis, Conditions, Site, TargetId};

/// Configurations that are compared, evenly taken.
const CONFIGURATIONS: usize = 120;
/// Configurations that are advised.
const ADVISED: usize = 3;
/// Standard deviation, m or rad, of an installation of which nothing is known.
const UNKNOWN: f64 = 1.0;
/// Rounds of exchanges; the second one seldom finds any.
const ROUNDS: usize = 4;

/// A configuration to measure.
#[derive(Debug, Clone, PartialEq)]
pub struct Advised {
    /// One a movable joint, rad or m.
    pub joints: Vec<f64>,
    /// 3-D standard deviation that the installation leaves open then, RMS over the configurations of the fit, m.
    pub band: f64,
}

/// Poses that determine a new installation.
#[derive(Debug, Clone, PartialEq)]
pub struct TransferPoses {
    /// Their conditions.
    pub poses: Vec<Conditions>,
    /// 3-D standard deviation that the installation leaves open then, RMS over the configurations of the fit, m.
    pub band: f64,
    /// Unknowns of the installation.
    pub unknowns: usize,
}

/// Configurations of the fit, and what each tells of an installation.
struct Candidates {
    each: Vec<(Conditions, DMatrix<f64>)>,
    /// Rows of all together, by which the band is a mean.
    points: f64,
    /// 1/σ².
    weight: f64,
}

impl Candidates {
    fn of(fitted: &FittedModel, sites: &[Site], targets: &[Option<TargetId>]) -> Result<Self, UpkeepError> {
        let sample = fitted.domain.sample.rows();
        let mut predictor = fitted.bind(&sample.schema)?;
        let mut each: Vec<(Conditions, DMatrix<f64>)> = Vec::new();
        // Rows of one pose are one configuration.
        let mut first: Vec<usize> = (0..sample.len()).collect();
        first.dedup_by_key(|row| sample.visit[*row]);
        for &row in first.iter().step_by(first.len().div_ceil(CONFIGURATIONS).max(1)) {
            let conditions = sample.conditions(row);
            let tool = predictor.predict(&conditions, None);
            let mut rows = DMatrix::zeros(3 * targets.len(), sites.len());
            for (k, &target) in targets.iter().enumerate() {
                let point = predictor.predict(&conditions, target).translation;
                let part = derivatives(fitted.chain(), sites, (&tool, &point), target);
                rows.rows_mut(3 * k, 3).copy_from(&part.rows(0, 3));
            }
            each.push((conditions, rows));
        }
        let points = (targets.len() * each.len()).max(1) as f64;
        let weight = fitted.noise.position_sd.max(1e-12).powi(-2);
        Ok(Candidates { each, points, weight })
    }

    /// What configuration `at` adds to the information.
    fn told(&self, at: usize) -> DMatrix<f64> {
        let rows = &self.each[at].1;
        rows.tr_mul(rows) * self.weight
    }

    /// RMS over all configurations, m; none where the information is singular.
    fn band(&self, information: &DMatrix<f64>) -> Option<f64> {
        let covariance = information.clone().cholesky()?.inverse();
        let all = self.each.iter().map(|(_, rows)| (rows * &covariance).dot(rows)).sum::<f64>();
        Some((all / self.points).sqrt())
    }

    /// The configuration that narrows the band most, and the band then.
    fn best(&self, information: &DMatrix<f64>) -> Option<(usize, f64)> {
        let bands =
            (0..self.each.len()).filter_map(|at| Some((at, self.band(&(information + self.told(at)))?)));
        bands.min_by(|a, b| a.1.total_cmp(&b.1))
    }
}

/// The configurations that narrow the band most, best first; none where the fit file holds no configurations.
pub(crate) fn advised(
    fitted: &FittedModel,
    sites: &[Site],
    spread: &DMatrix<f64>,
    data: &Dataset,
) -> Result<Vec<Advised>, UpkeepError> {
    let Some(inverse) = spread.clone().cholesky().map(|factor| factor.inverse()) else {
        return Ok(Vec::new());
    };
    let mut targets: Vec<Option<TargetId>> = data.target.clone();
    targets.sort_unstable_by_key(|t| t.map_or(0, |t| t.0 + 1));
    targets.dedup();
    let candidates = Candidates::of(fitted, sites, &targets)?;
    let mut information = inverse;
    let mut list: Vec<Advised> = Vec::new();
    for _ in 0..ADVISED {
        let Some((at, band)) = candidates.best(&information) else { break };
        information += candidates.told(at);
        list.push(Advised { joints: candidates.each[at].0.joints.clone(), band });
    }
    Ok(list)
}

/// Chooses `count` poses of the fit from which [`crate::transfer`] finds such an installation best. A tool and targets that are new are taken to
/// be about where those of the fit are.
///
/// # Errors
/// [`UpkeepError::NoUncertainty`] where the fit holds no configurations, [`UpkeepError::TooFew`] where so few poses do not determine the
/// installation.
pub fn transfer_poses(
    fitted: &FittedModel,
    count: usize,
    installation: Installation,
) -> Result<TransferPoses, UpkeepError> {
    if fitted.domain.sample.rows().is_empty() {
        return Err(UpkeepError::NoUncertainty { what: "the configurations that it was made from" });
    }
    let targets = match fitted.domain.targets.as_slice() {
        [] => vec![None],
        targets => targets.to_vec(),
    };
    let sites = sites(fitted, installation, &targets);
    let candidates = Candidates::of(fitted, &sites, &targets)?;
    let have = 3 * targets.len() * count;
    if have <= sites.len() {
        return Err(UpkeepError::TooFew { have, need: sites.len() });
    }
    let nothing = DMatrix::identity(sites.len(), sites.len()) / UNKNOWN.powi(2);
    let (mut information, mut chosen): (DMatrix<f64>, Vec<usize>) = (nothing, Vec::new());
    let mut band = f64::INFINITY;
    for _ in 0..count {
        let Some((at, then)) = candidates.best(&information) else { break };
        information += candidates.told(at);
        chosen.push(at);
        band = then;
    }
    for _ in 0..ROUNDS {
        let before = band;
        for place in &mut chosen {
            let without = &information - candidates.told(*place);
            if let Some((at, then)) = candidates.best(&without).filter(|(_, then)| *then < band) {
                information = without + candidates.told(at);
                (*place, band) = (at, then);
            }
        }
        if band >= before {
            break;
        }
    }
    let poses = chosen.iter().map(|&at| candidates.each[at].0.clone()).collect();
    Ok(TransferPoses { poses, band, unknowns: sites.len() })
}

/// What an installation consists of, before it is found. Targets that are all new do not show the tool.
fn sites(fitted: &FittedModel, new: Installation, targets: &[Option<TargetId>]) -> Vec<Site> {
    let chain = fitted.chain();
    let mut sites = Vec::new();
    let points = targets.iter().any(Option::is_some);
    if new.base {
        sites.extend(
            chain.frames().next().into_iter().flat_map(|frame| Axis::ALL.map(|a| Site::Frame(frame, a))),
        );
    }
    if new.tool && !(new.targets && points) {
        let axes: &[Axis] = if points { &Axis::ALL } else { &Axis::TRANSLATIONS };
        sites.extend(axes.iter().map(|&axis| Site::Frame(chain.tool_frame(), axis)));
    }
    if new.targets {
        let each = targets.iter().flatten();
        sites.extend(each.flat_map(|&target| Axis::TRANSLATIONS.map(|axis| Site::Target(target, axis))));
    }
    sites
}
