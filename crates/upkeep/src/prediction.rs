//! New measurements against a fitted model: residuals, derivatives and covariance, whitened.
//!
//! ```text
//! V = diag(σ² + (1 − w)² b²/3) + ρ² 1 1ᵀ  for each axis of a pose,   S = 1 + K Kᵀ,  K = V^{-1/2} H L,  L Lᵀ = C
//! aᵀ S⁻¹ b = aᵀ b − (Kᵀa)ᵀ (1 + KᵀK)⁻¹ (Kᵀb)
//! ```
//!
//! Source of the second line: Woodbury; its dimension is the rank of C, however many rows there are. Where a prediction falls back to the
//! declared model (share w of the findings below one, [`Fallback`](truepose_errormodel::Fallback)), what the findings would have moved it
//! by, b, is part of its scatter: such a row places an installation with the weight that it deserves.

use crate::UpkeepError;
use crate::installation::derivatives;
use nalgebra::{Cholesky, DMatrix, DVector, Dyn, SymmetricEigen};
use truepose_errormodel::{Dataset, FittedModel};
use truepose_identify::shrinkage;
use truepose_kinematics::{Conditions, Site, TargetId, rotation_log};

/// One measured number.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Number {
    pub row: usize,
    visit: usize,
    /// 0 to 2: position, 3 to 5: orientation.
    component: usize,
    /// (1 − w)² b²/3: variance of a prediction that falls back, m².
    beyond: f64,
}

/// Residuals and derivatives of all measured numbers, whitened by V.
pub(crate) struct Prediction {
    pub numbers: Vec<Number>,
    /// y − y(ĉ), m.
    pub residual: DVector<f64>,
    /// H, m × p, one unit of a coefficient.
    pub arm: DMatrix<f64>,
    /// P, m × k.
    pub installation: DMatrix<f64>,
    /// 3-D distance of each row whose position was measured, m (not whitened).
    pub distances: Vec<f64>,
}

/// The targets of which a data set has rows, ascending.
pub(crate) fn seen(data: &Dataset) -> Vec<TargetId> {
    let mut targets: Vec<TargetId> = data.target.iter().flatten().copied().collect();
    targets.sort_unstable_by_key(|t| t.0);
    targets.dedup();
    targets
}

/// Whether orientations are weighed: they were measured, and the fit, which may be of positions alone, knows their scatter.
pub(crate) fn oriented(fitted: &FittedModel, data: &Dataset) -> bool {
    fitted.noise.orientation_sd > 0.0 && (0..data.len()).any(|row| data.measured_rotation(row).is_some())
}

impl Prediction {
    /// Of these data with the fit's own noise; without orientations of which it knows no scatter.
    pub fn of(fitted: &FittedModel, sites: &[Site], data: &Dataset) -> Result<Self, UpkeepError> {
        data.validate(fitted.chain())?;
        let data = &*data.derived_for(fitted.model())?;
        let mut predictor = fitted.bind(&data.schema)?;
        let mut conditions = Conditions::default();
        let (mut numbers, mut residual) = (Vec::new(), Vec::new());
        let (mut arm, mut installation): (Vec<f64>, Vec<f64>) = (Vec::new(), Vec::new());
        let mut distances = Vec::new();
        let oriented = oriented(fitted, data);
        for row in 0..data.len() {
            data.conditions_into(row, &mut conditions);
            let target = data.target[row];
            let tool = predictor.predict(&conditions, None);
            let pose = predictor.predict(&conditions, target);
            let h = predictor.sensitivity(&conditions, target);
            let p = derivatives(fitted.chain(), sites, (&tool, &pose.translation), target);
            let away = data.measured_position(row) - pose.translation;
            let turned = data.measured_rotation(row).filter(|_| oriented);
            let turned = turned.map(|r| rotation_log(&(r * pose.rotation.transpose())));
            let size = fitted.fallback.as_ref().map_or(0.0, |fallback| fallback.size);
            let beyond = match size > 0.0 {
                true => (1.0 - predictor.share_of_findings(&conditions, target)).powi(2) * size / 3.0,
                false => 0.0,
            };
            if away.norm().is_finite() {
                distances.push(away.norm());
            }
            for component in 0..6 {
                let left = match (component < 3, turned) {
                    (true, _) => away[component],
                    (false, Some(turn)) => turn[component - 3],
                    (false, None) => continue,
                };
                if left.is_finite() {
                    let beyond = if component < 3 { beyond } else { 0.0 };
                    numbers.push(Number { row, visit: data.visit[row], component, beyond });
                    residual.push(left);
                    arm.extend(h.row(component).iter());
                    installation.extend(p.row(component).iter());
                }
            }
        }
        let m = numbers.len();
        let mut all = Prediction {
            residual: DVector::from_vec(residual),
            arm: DMatrix::from_row_slice(m, fitted.coefficients().len(), &arm),
            installation: DMatrix::from_row_slice(m, sites.len(), &installation),
            numbers,
            distances,
        };
        all.whiten(fitted)?;
        Ok(all)
    }

    /// Whitens everything by V.
    fn whiten(&mut self, fitted: &FittedModel) -> Result<(), UpkeepError> {
        let noise = fitted.noise;
        let shared = fitted.repeatability_sd;
        // Rows repeat by a little at least, however much of their scatter a pose shares.
        let own = (noise.position_sd.powi(2) - shared.powi(2)).max(1e-4 * noise.position_sd.powi(2)).sqrt();
        if own <= 0.0 {
            return Err(UpkeepError::NoUncertainty { what: "the scatter of a new measurement" });
        }
        let mut order: Vec<usize> = (0..self.numbers.len()).collect();
        let key = |&at: &usize| (self.numbers[at].visit, self.numbers[at].component);
        order.sort_by_key(key);
        let groups: Vec<Vec<usize>> =
            order.chunk_by(|a, b| key(a) == key(b)).map(<[usize]>::to_vec).collect();
        for group in groups {
            let position = self.numbers[group[0]].component < 3;
            let (sd, shared) = if position { (own, shared) } else { (noise.orientation_sd, 0.0) };
            let each: Vec<f64> = group.iter().map(|&at| sd.hypot(self.numbers[at].beyond.sqrt())).collect();
            let shrink = shrinkage(shared, each.iter().map(|sd| sd.powi(-2)).sum());
            let columns = std::iter::once(self.residual.as_mut_slice())
                .chain(self.arm.as_mut_slice().chunks_exact_mut(self.numbers.len().max(1)))
                .chain(self.installation.as_mut_slice().chunks_exact_mut(self.numbers.len().max(1)));
            for column in columns {
                group.iter().zip(&each).for_each(|(&at, sd)| column[at] /= sd);
                let along: f64 = group.iter().zip(&each).map(|(&at, sd)| column[at] / sd).sum();
                group.iter().zip(&each).for_each(|(&at, sd)| column[at] -= shrink * along / sd);
            }
        }
        Ok(())
    }

    /// 3-D RMS of these rows around the fit, m: noise, and what this covariance of the coefficients leaves open, less what an installation that
    /// was found from them takes.
    pub fn expected(&self, fitted: &FittedModel, covariance: &DMatrix<f64>) -> f64 {
        let spread = &self.arm * root(covariance);
        let positions: Vec<usize> = (0..self.len()).filter(|&at| self.numbers[at].component < 3).collect();
        let open = positions.iter().map(|&at| spread.row(at).norm_squared()).sum::<f64>();
        let taken = (self.installation.ncols() as f64 / self.len().max(1) as f64).min(1.0);
        let count = positions.len().max(1) as f64;
        let beyond = positions.iter().map(|&at| self.numbers[at].beyond).sum::<f64>() / count;
        let per_number = fitted.noise.position_sd.powi(2) * (1.0 + open / count) + beyond;
        (3.0 * per_number * (1.0 - taken)).sqrt()
    }

    /// Measured numbers.
    pub fn len(&self) -> usize {
        self.numbers.len()
    }
}

/// S⁻¹ as an inner product.
pub(crate) struct Weighing {
    /// K, m × r.
    spread: DMatrix<f64>,
    inner: Cholesky<f64, Dyn>,
}

impl Weighing {
    /// Of the rows under this covariance of the coefficients.
    pub fn of(rows: &Prediction, covariance: &DMatrix<f64>) -> Result<Self, UpkeepError> {
        let spread = &rows.arm * root(covariance);
        let inner = spread.tr_mul(&spread) + DMatrix::identity(spread.ncols(), spread.ncols());
        let inner = Cholesky::new(inner)
            .ok_or(UpkeepError::NoUncertainty { what: "a covariance of its coefficients" })?;
        Ok(Weighing { spread, inner })
    }

    /// aᵀ S⁻¹ b.
    pub fn product(&self, a: &DMatrix<f64>, b: &DMatrix<f64>) -> DMatrix<f64> {
        let (along_a, along_b) = (self.spread.tr_mul(a), self.spread.tr_mul(b));
        a.tr_mul(b) - along_a.tr_mul(&self.inner.solve(&along_b))
    }
}

/// L with L Lᵀ = C, of columns as many as C has rank. Coefficients are scaled by their standard deviations first.
pub(crate) fn root(covariance: &DMatrix<f64>) -> DMatrix<f64> {
    let deviation: Vec<f64> = covariance.diagonal().iter().map(|v| v.max(0.0).sqrt()).collect();
    let open: Vec<usize> = (0..deviation.len()).filter(|&k| deviation[k] > 0.0).collect();
    // Of a model that nothing moves: no coefficient has a standard deviation, and an empty matrix has no eigenvectors.
    if open.is_empty() {
        return DMatrix::zeros(deviation.len(), 0);
    }
    let scaled = DMatrix::from_fn(open.len(), open.len(), |i, j| {
        covariance[(open[i], open[j])] / (deviation[open[i]] * deviation[open[j]])
    });
    let eigen = SymmetricEigen::new(scaled);
    let kept: Vec<usize> = (0..open.len()).filter(|&k| eigen.eigenvalues[k] > 1e-12).collect();
    let mut root = DMatrix::zeros(deviation.len(), kept.len());
    for (column, &k) in kept.iter().enumerate() {
        for (i, &at) in open.iter().enumerate() {
            root[(at, column)] = eigen.eigenvectors[(i, k)] * eigen.eigenvalues[k].sqrt() * deviation[at];
        }
    }
    root
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_root_is_a_root() {
        let a =
            DMatrix::from_fn(5, 3, |i, j| ((3 * i + 5 * j + i * j) as f64).sin() * 10f64.powi(i as i32 - 3));
        let mut covariance = &a * a.transpose();
        covariance.fill_row(2, 0.0);
        covariance.fill_column(2, 0.0);
        let root = root(&covariance);
        assert_eq!(root.ncols(), 3);
        assert!((&root * root.transpose() - &covariance).amax() < 1e-12 * covariance.amax());
    }

    #[test]
    fn coefficients_without_a_scatter_have_an_empty_root() {
        assert_eq!(root(&DMatrix::zeros(3, 3)).shape(), (3, 0));
        assert_eq!(root(&DMatrix::zeros(0, 0)).shape(), (0, 0));
    }
}
