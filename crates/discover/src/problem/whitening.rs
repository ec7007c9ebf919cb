//! Whitening of any columns under a noise model: rows of one visit and component go together.
//!
//! With σ_i² = s_i² + τ² and d = 1/σ: `z = u − (1 − 1/√(1 + ρ²|d|²)) d (d·u)/|d|²`, u = r/σ, as in
//! [`truepose_identify::NoiseModel`]. The log determinant of the covariance is `Σ ln σ_i² + ln(1 + ρ²|d|²)`.

use crate::problem::observation::Observation;
use nalgebra::DMatrix;
use truepose_errormodel::Dataset;
use truepose_identify::{NoiseModel, shrinkage};

/// The numbers of one visit and component.
#[derive(Debug, Clone)]
struct Group {
    members: Vec<usize>,
    /// d = 1/σ.
    weights: Vec<f64>,
    /// (1 − 1/√(1 + ρ²|d|²)) / |d|².
    shrink: f64,
    log_determinant: f64,
}

/// The whitening of one scene under one noise model.
#[derive(Debug, Clone)]
pub(crate) struct Whitener {
    groups: Vec<Group>,
}

impl Whitener {
    pub fn new(observations: &[Observation], data: &Dataset, noise: NoiseModel) -> Self {
        let mut order: Vec<usize> = (0..observations.len()).collect();
        let key = |&at: &usize| (observations[at].visit, observations[at].component);
        order.sort_by_key(key);
        let mut groups = Vec::new();
        for members in order.chunk_by(|a, b| key(a) == key(b)) {
            let weights: Vec<f64> = members
                .iter()
                .map(|&at| {
                    let o = observations[at];
                    1.0 / if o.component < 3 {
                        noise.position(data.position_sd[o.row][o.component])
                    } else {
                        noise.orientation(data.orientation_sd[o.row][o.component - 3])
                    }
                })
                .collect();
            let shared = if observations[members[0]].component < 3 { noise.visit_sd } else { 0.0 };
            let squares: f64 = weights.iter().map(|d| d * d).sum();
            let stretch = 1.0 + shared * shared * squares;
            groups.push(Group {
                members: members.to_vec(),
                shrink: shrinkage(shared, squares),
                log_determinant: stretch.ln() - 2.0 * weights.iter().map(|d| d.ln()).sum::<f64>(),
                weights,
            });
        }
        Whitener { groups }
    }

    /// The weighted mean of each pose and component of position or orientation: its observations, their weights d, and its variance
    /// ρ² + 1/|d|², m² (rad²).
    pub fn means(&self) -> impl Iterator<Item = (&[usize], &[f64], f64)> {
        self.groups.iter().map(|group| {
            let squares: f64 = group.weights.iter().map(|d| d * d).sum();
            // 1 + ρ²|d|² = 1/(1 − shrink |d|²)².
            let kept = 1.0 - group.shrink * squares;
            (group.members.as_slice(), group.weights.as_slice(), 1.0 / (squares * kept * kept))
        })
    }

    /// Whitens every column in place.
    pub fn apply(&self, columns: &mut DMatrix<f64>) {
        let rows = columns.nrows();
        for column in columns.as_mut_slice().chunks_exact_mut(rows.max(1)) {
            for group in &self.groups {
                let mut along = 0.0;
                for (&at, &d) in group.members.iter().zip(&group.weights) {
                    column[at] *= d;
                    along += d * column[at];
                }
                if group.shrink > 0.0 {
                    let along = along * group.shrink;
                    for (&at, &d) in group.members.iter().zip(&group.weights) {
                        column[at] -= d * along;
                    }
                }
            }
        }
    }

    /// A whitened copy.
    pub fn of(&self, columns: &DMatrix<f64>) -> DMatrix<f64> {
        let mut copy = columns.clone();
        self.apply(&mut copy);
        copy
    }

    /// Sum of the logarithms of the covariances' determinants.
    pub fn log_determinant(&self) -> f64 {
        self.groups.iter().map(|group| group.log_determinant).sum()
    }

    /// Each number standardised by what all others of its visit and component say: N(0, 1) under the model.
    pub fn deleted(&self, residual: &[f64]) -> Vec<f64> {
        let mut out = vec![0.0; residual.len()];
        for group in &self.groups {
            // C⁻¹ r and the diagonal of C⁻¹, C = diag(σ²) + ρ² 1 1ᵀ.
            let squares: f64 = group.weights.iter().map(|d| d * d).sum();
            let along: f64 =
                group.members.iter().zip(&group.weights).map(|(&at, d)| d * d * residual[at]).sum();
            // ρ²/(1 + ρ²|d|²) from the shrinkage: 1/(1+ρ²s) = (1 − shrink s)².
            let keep = (1.0 - group.shrink * squares).powi(2);
            let factor = (1.0 - keep) / squares;
            for (&at, &d) in group.members.iter().zip(&group.weights) {
                let solved = d * d * (residual[at] - factor * along);
                let diagonal = d * d * (1.0 - factor * d * d);
                out[at] = solved / diagonal.max(f64::MIN_POSITIVE).sqrt();
            }
        }
        out
    }
}
