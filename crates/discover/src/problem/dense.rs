//! A dense reference for every accelerated path: whiten, project and solve with whole matrices, straight from the definitions.
//!
//! ```text
//! C = diag(s_i² + τ²) + ρ² within a pose and component of position + G_v Σ_q G_vᵀ within a pose,   C = L Lᵀ,   P = 1 − Ã (ÃᵀÃ)⁻¹ Ãᵀ,   Ã = [L⁻¹A; W]
//! ```
//!
//! Slow, and used by tests alone. Nothing here is shared with what it is compared with but the linearised data itself.

use crate::problem::linearisation::Linearisation;
use crate::problem::noise::Noise;
use nalgebra::{DMatrix, DVector, SymmetricEigen};
use statrs::distribution::{Beta, ContinuousCDF};
use truepose_kinematics::JointKind;

/// The linearised data under one noise model.
pub(crate) struct Dense {
    /// L⁻¹ A over L⁻¹-whitened rows, with the prior's rows below.
    design: DMatrix<f64>,
    /// L⁻¹ y, with zeros below.
    target: DVector<f64>,
    /// The same with its directions along the prior's axes: those that the data estimates have no prior.
    nuisance: DMatrix<f64>,
    lower: DMatrix<f64>,
    observations: usize,
    /// Raw A and y.
    raw: (DMatrix<f64>, DVector<f64>),
}

/// What the score test says of a candidate.
pub(crate) struct DenseScore {
    pub freedom: usize,
    /// SS.
    pub squares: f64,
    /// −m ln(1 − SS/RSS).
    pub statistic: f64,
    /// ‖X̃‖²/‖X‖².
    pub left: f64,
    /// −ln P(Beta(k/2, (ν − k)/2) ≥ SS/RSS).
    pub surprisal: f64,
}

impl Dense {
    pub fn new(linearisation: &Linearisation<'_>, noise: impl Into<Noise>) -> Self {
        let Noise { rows: noise, joints } = noise.into();
        let (data, observations) = (linearisation.data, &linearisation.observations);
        let m = observations.len();
        // What one standard deviation of each joint does to every observation.
        let chain = linearisation.chain();
        let moved: Vec<Vec<f64>> = (chain.movable().iter())
            .map(|&joint| {
                let slides = chain.joint(joint).kind == JointKind::Prismatic;
                let sd = if slides { joints.sliding } else { joints.turning };
                let motion = linearisation.motion(joint).expect("a movable joint");
                let along = |at: usize| -> f64 {
                    motion.iter().map(|(site, part)| part * linearisation.sites(at)[*site]).sum()
                };
                (0..m).map(|at| sd * along(at)).collect()
            })
            .collect();
        let covariance = DMatrix::from_fn(m, m, |i, j| {
            let (a, b) = (observations[i], observations[j]);
            let shared = (a.visit, a.component) == (b.visit, b.component) && a.component < 3;
            let own = match a.component {
                0..3 => noise.position(data.position_sd[a.row][a.component]),
                _ => noise.orientation(data.orientation_sd[a.row][a.component - 3]),
            };
            let of_joints: f64 = match a.visit == b.visit {
                true => moved.iter().map(|moved| moved[i] * moved[j]).sum(),
                false => 0.0,
            };
            (if i == j { own * own } else { 0.0 })
                + if shared { noise.visit_sd.powi(2) } else { 0.0 }
                + of_joints
        });
        let lower = covariance.cholesky().expect("a covariance").unpack();
        let r = linearisation.base.ncols();
        let prior = linearisation.prior.clone().unwrap_or_else(|| DMatrix::zeros(0, r));
        let raw = (linearisation.base.clone(), linearisation.y.clone());
        let nothing = DMatrix::zeros(0, 0);
        let mut dense = Dense {
            design: prior,
            target: DVector::zeros(0),
            nuisance: nothing,
            lower,
            observations: m,
            raw,
        };
        dense.nuisance = dense.nuisance(&dense.design);
        dense.design = dense.over(&dense.raw.0, &dense.design);
        let below = DMatrix::zeros(dense.design.nrows() - m, 1);
        let target = DMatrix::from_column_slice(m, 1, dense.raw.1.as_slice());
        dense.target = dense.over(&target, &below).column(0).into_owned();
        dense
    }

    /// The singular directions of L⁻¹ A W⁻¹: those of at least three standard deviations of the prior without its rows.
    fn nuisance(&self, prior: &DMatrix<f64>) -> DMatrix<f64> {
        let r = prior.ncols();
        let Some(inverse) = prior.clone().try_inverse() else {
            return self.over(&self.raw.0, &DMatrix::zeros(prior.nrows(), r));
        };
        let scaled = self.over(&(&self.raw.0 * inverse), &DMatrix::zeros(r, r));
        let svd = scaled.clone().svd(false, true);
        let turned = &scaled * svd.v_t.expect("asked for").transpose();
        let held = DMatrix::from_diagonal(&svd.singular_values.map(|s| if s >= 3.0 { 0.0 } else { 1.0 }));
        let mut all = turned;
        all.rows_mut(self.observations, r).copy_from(&held);
        all
    }

    /// Whitened rows over others.
    fn over(&self, raw: &DMatrix<f64>, below: &DMatrix<f64>) -> DMatrix<f64> {
        let white = self.lower.solve_lower_triangular(raw).expect("a triangle");
        let mut all = white.resize_vertically(self.observations + below.nrows(), 0.0);
        all.rows_mut(self.observations, below.nrows()).copy_from(below);
        all
    }

    /// The prior's rows hold every direction, also those that the data estimates.
    pub fn held(mut self) -> Self {
        self.nuisance.clone_from(&self.design);
        self
    }

    /// With further raw columns in the model, without a prior.
    pub fn with(mut self, more: &DMatrix<f64>) -> Self {
        let below = DMatrix::zeros(self.design.nrows() - self.observations, more.ncols());
        let (more, r) = (self.over(more, &below), self.design.ncols());
        for columns in [&mut self.design, &mut self.nuisance] {
            *columns = std::mem::take(columns).resize_horizontally(r + more.ncols(), 0.0);
            columns.columns_mut(r, more.ncols()).copy_from(&more);
        }
        self
    }

    /// C.
    pub fn covariance(&self) -> DMatrix<f64> {
        &self.lower * self.lower.transpose()
    }

    /// ln det C.
    pub fn log_determinant(&self) -> f64 {
        2.0 * self.lower.diagonal().iter().map(|d| d.ln()).sum::<f64>()
    }

    /// The score of raw columns, of which directions with less than `absorbed` left are dropped; none when nothing is left.
    pub fn score(&self, x: &DMatrix<f64>, absorbed: f64) -> Option<DenseScore> {
        let size = self.nuisance.nrows();
        let x = self.over(x, &DMatrix::zeros(size - self.observations, x.ncols()));
        let basis = self.nuisance.clone().qr().q();
        let project = |z: &DMatrix<f64>| z - &basis * (basis.transpose() * z);
        let target = DMatrix::from_column_slice(size, 1, self.target.as_slice());
        let (residual, left) = (project(&target), project(&x));
        // A column of rounding is none, as in the accelerated path.
        let scale: Vec<f64> =
            x.column_iter().map(|c| if c.norm() > 1e-6 { 1.0 / c.norm() } else { 0.0 }).collect();
        let scaled = &left * DMatrix::from_diagonal(&DVector::from_vec(scale));
        let eigen = SymmetricEigen::new(scaled.transpose() * &scaled);
        let kept: Vec<usize> = (0..x.ncols()).filter(|&k| eigen.eigenvalues[k] > absorbed).collect();
        if kept.is_empty() {
            return None;
        }
        let directions = DMatrix::from_columns(
            &kept
                .iter()
                .map(|&k| &scaled * eigen.eigenvectors.column(k) / eigen.eigenvalues[k].sqrt())
                .collect::<Vec<_>>(),
        );
        let squares = directions.tr_mul(&residual).norm_squared();
        let fraction = squares / residual.norm_squared();
        let rows = self.nuisance.row_iter().filter(|row| row.amax() > 0.0).count();
        let (k, freedom) = (kept.len() as f64, (rows - self.nuisance.ncols()) as f64);
        let beta = Beta::new(0.5 * k, 0.5 * (freedom - k)).expect("positive");
        Some(DenseScore {
            freedom: kept.len(),
            squares,
            statistic: -(self.observations as f64) * (1.0 - fraction).ln(),
            left: left.norm_squared() / x.norm_squared(),
            surprisal: -beta.sf(fraction).ln(),
        })
    }

    /// [β; γ] with its covariance and the smallest sum of squares, from some observations; γ has this prior standard deviation.
    pub fn solve(&self, x: &DMatrix<f64>, used: &[bool], width: f64) -> (DVector<f64>, DMatrix<f64>, f64) {
        let (r, k) = (self.design.ncols(), x.ncols());
        let x = self.over(x, &DMatrix::zeros(self.design.nrows() - self.observations, k));
        let rows: Vec<usize> =
            (0..self.design.nrows()).filter(|&at| at >= self.observations || used[at]).collect();
        let mut all: DMatrix<f64> = self.design.select_rows(&rows).resize(rows.len() + k, r + k, 0.0);
        all.view_mut((0, r), (rows.len(), k)).copy_from(&x.select_rows(&rows));
        all.view_mut((rows.len(), r), (k, k)).fill_with_identity();
        all.view_mut((rows.len(), r), (k, k)).scale_mut(1.0 / width);
        let target = self.target.select_rows(&rows).resize_vertically(rows.len() + k, 0.0);
        let qr = all.clone().qr();
        let upper = qr.r();
        let solution =
            upper.solve_upper_triangular(&(qr.q().transpose() * &target)).expect("independent columns");
        let inverse =
            upper.solve_upper_triangular(&DMatrix::identity(r + k, r + k)).expect("independent columns");
        let squares = (target - all * &solution).norm_squared();
        (solution, &inverse * inverse.transpose(), squares)
    }

    /// −2 ln L with these columns.
    pub fn deviance(&self, x: &DMatrix<f64>, width: f64) -> f64 {
        self.log_determinant() + self.solve(x, &vec![true; self.observations], width).2
    }

    /// Raw residuals y − A β − X γ of every observation.
    pub fn residuals(&self, x: &DMatrix<f64>, solution: &DVector<f64>) -> DVector<f64> {
        let r = self.raw.0.ncols();
        &self.raw.1 - &self.raw.0 * solution.rows(0, r) - x * solution.rows(r, x.ncols())
    }
}
