//! Which configurations of the fit to measure next in a new installation.
//!
//! ```text
//! min_j Σ_i tr P_i (D⁻¹ + P_jᵀP_j/σ²)⁻¹ P_iᵀ        i: configurations of the fit, j: the next measurement
//! ```
//!
//! Greedy, one after the other (I-optimal design: Fedorov 1972); D and P as in the crate's README. All targets that were measured in the new
//! installation are taken to be measured again.

use crate::UpkeepError;
use crate::installation::derivatives;
use nalgebra::DMatrix;
use truepose_errormodel::{Dataset, FittedModel};
use truepose_kinematics::{Conditions, Site, TargetId};

/// Configurations that are compared, evenly taken.
const CONFIGURATIONS: usize = 120;
/// Configurations that are advised.
const ADVISED: usize = 3;

/// A configuration to measure.
#[derive(Debug, Clone, PartialEq)]
pub struct Advised {
    /// One a movable joint, rad or m.
    pub joints: Vec<f64>,
    /// 3-D standard deviation that the installation leaves open then, RMS over the configurations of the fit, m.
    pub band: f64,
}

/// The configurations that narrow the band most, best first; none where the fit file holds no configurations.
pub(crate) fn advised(
    fitted: &FittedModel,
    sites: &[Site],
    spread: &DMatrix<f64>,
    data: &Dataset,
) -> Result<Vec<Advised>, UpkeepError> {
    let sample = fitted.domain.sample.rows();
    let Some(inverse) = spread.clone().cholesky().map(|factor| factor.inverse()) else {
        return Ok(Vec::new());
    };
    let mut information = inverse;
    let mut predictor = fitted.bind(&sample.schema)?;
    let mut conditions = Conditions::default();
    let mut targets: Vec<Option<TargetId>> = data.target.clone();
    targets.sort_unstable_by_key(|t| t.map_or(0, |t| t.0 + 1));
    targets.dedup();
    let mut each: Vec<(Vec<f64>, DMatrix<f64>)> = Vec::new();
    for row in (0..sample.len()).step_by(sample.len().div_ceil(CONFIGURATIONS).max(1)) {
        sample.conditions_into(row, &mut conditions);
        let tool = predictor.predict(&conditions, None);
        let mut rows = DMatrix::zeros(3 * targets.len(), sites.len());
        for (k, &target) in targets.iter().enumerate() {
            let point = predictor.predict(&conditions, target).translation;
            let part = derivatives(fitted.chain(), sites, (&tool, &point), target);
            rows.rows_mut(3 * k, 3).copy_from(&part.rows(0, 3));
        }
        each.push((conditions.joints.clone(), rows));
    }
    let weight = fitted.noise.position_sd.max(1e-12).powi(-2);
    let points = (targets.len() * each.len()).max(1) as f64;
    let band = |information: &DMatrix<f64>| {
        let covariance = information.clone().cholesky()?.inverse();
        let all = each.iter().map(|(_, rows)| (rows * &covariance).dot(rows)).sum::<f64>();
        Some((all / points).sqrt())
    };
    let mut list: Vec<Advised> = Vec::new();
    for _ in 0..ADVISED {
        let then = |rows: &DMatrix<f64>| &information + rows.tr_mul(rows) * weight;
        let bands = each.iter().filter_map(|(joints, rows)| Some((joints, rows, band(&then(rows))?)));
        let Some((joints, rows, best)) = bands.min_by(|a, b| a.2.total_cmp(&b.2)) else { break };
        let next = then(rows);
        list.push(Advised { joints: joints.clone(), band: best });
        information = next;
    }
    Ok(list)
}
