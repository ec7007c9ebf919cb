//! Whitening of any columns under a noise model: rows of one visit and component go together.
//!
//! With σ_i² = s_i² + τ² and d = 1/σ: `z = u − (1 − 1/√(1 + ρ²|d|²)) d (d·u)/|d|²`, u = r/σ, as in
//! [`truepose_identify::NoiseModel`]. The log determinant of the covariance is `Σ ln σ_i² + ln(1 + ρ²|d|²)`. Numbers along directions share a
//! displacement in space: the same along each of the v_k of [`truepose_identify::directions`].
//!
//! Where the joints scatter, all observations of a pose go together. With B = W₀ G_v Σ_q^{1/2} = U Λ^{1/2} Vᵀ, W₀ the whitening above and G_v
//! the levers of the joints ([`crate::problem::noise`]),
//!
//! ```text
//! W = (1 + B Bᵀ)^{-1/2} W₀ = (1 − U (1 − (1 + Λ)^{-1/2}) Uᵀ) W₀,     ln det V = ln det V₀ + Σ ln(1 + λ)
//! ```

use crate::problem::noise::{JointNoise, Levers};
use crate::problem::observation::Observation;
use nalgebra::{DMatrix, SymmetricEigen, Vector3};
use std::ops::Range;
use truepose_errormodel::Dataset;
use truepose_identify::{NoiseModel, beside_others, directions, rays_of, shrinkage};

/// The numbers of one visit and component.
#[derive(Debug, Clone)]
struct Group {
    members: Vec<usize>,
    /// d = 1/σ.
    weights: Vec<f64>,
    /// What they share, direction by direction.
    shared: Vec<Along>,
    /// w of numbers along directions of their own; else empty.
    rays: Vec<Vector3<f64>>,
    /// ρ².
    variance: f64,
    log_determinant: f64,
}

/// A direction in which the whitened numbers of a group share what displaces the robot.
#[derive(Debug, Clone)]
struct Along {
    /// v: d of numbers along an axis ([`truepose_identify::directions`]).
    v: Vec<f64>,
    /// |v|².
    squares: f64,
    /// (1 − 1/√(1 + ρ²|v|²)) / |v|².
    shrink: f64,
}

/// What the numbers of a visit and component have in common along a direction: the estimate Σ v_i d_i r_i / Σ v_i², of variance ρ² + 1/Σ v_i².
pub(crate) struct Mean<'a> {
    pub members: &'a [usize],
    /// d of each.
    pub weights: &'a [f64],
    /// v of each: d along an axis.
    pub along: &'a [f64],
    /// m² (rad²).
    pub variance: f64,
    /// Whether the numbers are along an axis of the measurement frame, so that they are one mean.
    pub on_axis: bool,
}

/// What the joints' scatter adds to one pose.
#[derive(Debug, Clone)]
struct Posture {
    members: Range<usize>,
    /// U, observations × directions.
    directions: DMatrix<f64>,
    /// λ of each.
    stretch: Vec<f64>,
}

/// The whitening of one scene under one noise model.
#[derive(Debug, Clone)]
pub(crate) struct Whitener {
    groups: Vec<Group>,
    /// Of poses that the joints' scatter reaches; empty where it is none.
    postures: Vec<Posture>,
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
            let rays = rays_of(
                data,
                observations[members[0]].component,
                members.iter().map(|&at| observations[at].row),
            );
            let along = directions(&weights, &rays).into_iter().map(|v| {
                let squares = v.iter().map(|v| v * v).sum();
                Along { squares, shrink: shrinkage(shared, squares), v }
            });
            let along: Vec<Along> = along.collect();
            let stretch = along.iter().map(|along| (1.0 + shared * shared * along.squares).ln()).sum::<f64>();
            groups.push(Group {
                members: members.to_vec(),
                shared: along,
                rays,
                variance: shared * shared,
                log_determinant: stretch - 2.0 * weights.iter().map(|d| d.ln()).sum::<f64>(),
                weights,
            });
        }
        Whitener { groups, postures: Vec::new() }
    }

    /// The same with joints that scatter by these standard deviations.
    pub fn beside(mut self, observations: &[Observation], levers: &Levers, joints: JointNoise) -> Self {
        if !joints.is_some() {
            return self;
        }
        let mut scaled = levers.scaled(joints);
        self.apply(&mut scaled);
        let mut first = 0;
        for pose in observations.chunk_by(|a, b| a.visit == b.visit) {
            let members = first..first + pose.len();
            first = members.end;
            let own = scaled.rows(members.start, members.len());
            self.postures.extend(Posture::new(members, own.into_owned()));
        }
        self
    }

    /// The weighted mean of each pose and component of position or orientation; of numbers along directions, one a direction that they share.
    pub fn means(&self) -> impl Iterator<Item = Mean<'_>> {
        self.groups.iter().flat_map(|group| {
            group.shared.iter().map(|along| {
                // 1 + ρ²|v|² = 1/(1 − shrink |v|²)².
                let kept = 1.0 - along.shrink * along.squares;
                Mean {
                    members: &group.members,
                    weights: &group.weights,
                    along: &along.v,
                    variance: 1.0 / (along.squares * kept * kept),
                    on_axis: group.rays.len() < 2,
                }
            })
        })
    }

    /// Whitens every column in place.
    pub fn apply(&self, columns: &mut DMatrix<f64>) {
        let rows = columns.nrows();
        for column in columns.as_mut_slice().chunks_exact_mut(rows.max(1)) {
            for group in &self.groups {
                for (&at, &d) in group.members.iter().zip(&group.weights) {
                    column[at] *= d;
                }
                group.take_out(column);
            }
        }
        self.apply_postures(columns);
    }

    /// Applies Wᵀ to every column in place: V⁻¹ = Wᵀ W.
    pub fn apply_transposed(&self, columns: &mut DMatrix<f64>) {
        self.apply_postures(columns);
        self.transposed_groups(columns);
    }

    fn transposed_groups(&self, columns: &mut DMatrix<f64>) {
        let rows = columns.nrows();
        for column in columns.as_mut_slice().chunks_exact_mut(rows.max(1)) {
            for group in &self.groups {
                group.take_out(column);
                for (&at, &d) in group.members.iter().zip(&group.weights) {
                    column[at] *= d;
                }
            }
        }
    }

    fn apply_postures(&self, columns: &mut DMatrix<f64>) {
        for posture in &self.postures {
            let own = columns.rows(posture.members.start, posture.members.len());
            let mut along = posture.directions.tr_mul(&own);
            for (mut row, stretch) in along.row_iter_mut().zip(&posture.stretch) {
                row *= 1.0 - 1.0 / (1.0 + stretch).sqrt();
            }
            let mut own = columns.rows_mut(posture.members.start, posture.members.len());
            own.gemm(-1.0, &posture.directions, &along, 1.0);
        }
    }

    /// The diagonal of V⁻¹, of so many observations.
    pub fn precisions(&self, observations: usize) -> Vec<f64> {
        let mut diagonal = vec![0.0; observations];
        for group in &self.groups {
            for (k, (&at, &d)) in group.members.iter().zip(&group.weights).enumerate() {
                let taken = group.shared.iter().map(|along| {
                    let keep = (1.0 - along.shrink * along.squares).powi(2);
                    (1.0 - keep) / along.squares * along.v[k] * along.v[k]
                });
                diagonal[at] = d * d * (1.0 - taken.sum::<f64>());
            }
        }
        if self.postures.is_empty() {
            return diagonal;
        }
        // W₀ᵀU of all poses below each other: V⁻¹ = W₀ᵀ (1 − U Λ/(1 + Λ) Uᵀ) W₀.
        let widest = self.postures.iter().map(|posture| posture.stretch.len()).max().unwrap_or(0);
        let mut all = DMatrix::zeros(observations, widest);
        for Posture { members, directions, stretch } in &self.postures {
            all.view_mut((members.start, 0), (members.len(), stretch.len())).copy_from(directions);
        }
        self.transposed_groups(&mut all);
        for Posture { members, stretch, .. } in &self.postures {
            for at in members.clone() {
                let less = stretch.iter().enumerate().map(|(k, l)| all[(at, k)].powi(2) * l / (1.0 + l));
                diagonal[at] -= less.sum::<f64>();
            }
        }
        diagonal
    }

    /// A whitened copy.
    pub fn of(&self, columns: &DMatrix<f64>) -> DMatrix<f64> {
        let mut copy = columns.clone();
        self.apply(&mut copy);
        copy
    }

    /// Sum of the logarithms of the covariances' determinants.
    pub fn log_determinant(&self) -> f64 {
        let plain: f64 = self.groups.iter().map(|group| group.log_determinant).sum();
        let further = self.postures.iter().flat_map(|posture| &posture.stretch);
        if self.postures.is_empty() { plain } else { plain + further.map(|l| l.ln_1p()).sum::<f64>() }
    }

    /// Each number standardised by what the others of its visit and component say, those that are out left aside: N(0, 1) under the model.
    ///
    /// ```text
    /// e_i = (r_i − v Σ d_j² r_j) / √(1/d_i² + v),   v = ρ²/(1 + ρ² Σ d_j²),   j ≠ i, not out
    /// ```
    pub fn deleted(&self, residual: &[f64], out: &dyn Fn(usize) -> bool) -> Vec<f64> {
        let mut standardised = vec![0.0; residual.len()];
        for group in &self.groups {
            if group.rays.len() > 1 {
                let each = group.members.iter().zip(&group.weights).zip(&group.rays);
                let numbers: Vec<_> = each.map(|((&at, d), w)| (residual[at], d * d, *w, !out(at))).collect();
                let beside = beside_others(&numbers, group.variance.sqrt());
                group.members.iter().zip(beside).for_each(|(&at, beside)| standardised[at] = beside);
                continue;
            }
            let shared = group.variance * group.rays.first().map_or(1.0, Vector3::norm_squared);
            let each = || group.members.iter().zip(&group.weights).map(|(&at, &d)| (at, d * d));
            let said = each().filter(|(at, _)| !out(*at));
            let (weight, along) =
                said.fold((0.0, 0.0), |(w, a), (at, own)| (w + own, a + own * residual[at]));
            for (at, own) in each() {
                let mine = if out(at) { 0.0 } else { own };
                let variance = shared / (1.0 + shared * (weight - mine).max(0.0));
                let expected = variance * (along - mine * residual[at]);
                standardised[at] = (residual[at] - expected) / (1.0 / own + variance).sqrt();
            }
        }
        standardised
    }
}

impl Group {
    /// Takes out of whitened numbers what they share.
    fn take_out(&self, column: &mut [f64]) {
        for Along { v, shrink, .. } in self.shared.iter().filter(|along| along.shrink > 0.0) {
            let along: f64 = self.members.iter().zip(v).map(|(&at, v)| v * column[at]).sum();
            let along = along * shrink;
            self.members.iter().zip(v).for_each(|(&at, v)| column[at] -= v * along);
        }
    }
}

impl Posture {
    /// Of B, observations × joints; none where the joints move nothing there.
    fn new(members: Range<usize>, moved: DMatrix<f64>) -> Option<Self> {
        /// λ of a direction, of the largest, below which it is rounding.
        const ROUNDING: f64 = 1e-12;
        if moved.ncols() == 0 {
            return None;
        }
        let eigen = SymmetricEigen::new(moved.tr_mul(&moved));
        let least = ROUNDING * eigen.eigenvalues.amax();
        let kept: Vec<usize> =
            (0..eigen.eigenvalues.len()).filter(|&k| eigen.eigenvalues[k] > least).collect();
        if kept.is_empty() {
            return None;
        }
        let mut directions = moved * eigen.eigenvectors.select_columns(&kept);
        let stretch: Vec<f64> = kept.iter().map(|&k| eigen.eigenvalues[k]).collect();
        for (mut column, stretch) in directions.column_iter_mut().zip(&stretch) {
            column /= stretch.sqrt();
        }
        Some(Posture { members, directions, stretch })
    }
}
