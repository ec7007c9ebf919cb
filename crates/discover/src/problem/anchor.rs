//! The present model under one noise: what every candidate beside it shares.
//!
//! ```text
//! C = AᵀV⁻¹A + K = L Lᵀ,     P = V⁻¹ − V⁻¹A C⁻¹ AᵀV⁻¹,     yᵀP y,     tr P V_i
//! ```
//!
//! | symbol | here | shape |
//! | --- | --- | --- |
//! | V, V_i, K | as in [`crate::problem::restricted`] | m × m, m × m, r × r |
//! | A, y | columns of the model, what it has to explain | m × r, m |
//!
//! These cost products with r² m terms; a candidate of k columns then costs r k m. Candidates meet at the same noises because their noise is sought
//! on a grid ([`Grid`]).

use crate::problem::linearisation::Linearisation;
use crate::problem::noise::Noise;
use crate::problem::variance::{Component, Part, Parts};
use crate::problem::whitening::Whitener;
use crate::statistics::product::{cholesky, cross, gram_matrix};
use crate::statistics::triangular::solve_lower;
use nalgebra::DMatrix;
use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, OnceLock, PoisonError};

/// The present model under one noise.
#[derive(Debug)]
pub(crate) struct Anchor {
    pub noise: Noise,
    pub whitener: Whitener,
    /// ln det V, and ln det C.
    pub determinants: [f64; 2],
    /// yᵀP y.
    pub squares: f64,
    /// Whitened y − A β̂, m × 1.
    pub left: DMatrix<f64>,
    /// L of D C D, and D: the scale of each column.
    lower: DMatrix<f64>,
    scale: Vec<f64>,
    traces: OnceLock<Vec<f64>>,
}

impl Anchor {
    /// None where C is not positive definite, or nothing is finite.
    pub fn new(problem: &Linearisation<'_>, noise: Noise) -> Option<Self> {
        let r = problem.base.ncols();
        let whitener = problem.whitener(noise);
        let mut white = problem.base.clone().resize_horizontally(r + 1, 0.0);
        white.column_mut(r).copy_from(&problem.y);
        whitener.apply(&mut white);
        let gram = gram_matrix(&white);
        let prior = problem.prior_precision();
        let mut normal = gram.view((0, 0), (r, r)) + prior;
        let scale = scales(normal.diagonal().iter());
        unit(&mut normal, &scale);
        let lower = cholesky(normal)?.unpack_dirty();
        let mut along = DMatrix::from_fn(r, 1, |i, _| gram[(i, r)] * scale[i]);
        solve_lower(&lower, &mut along);
        let solution = back(&lower, &scale, along);
        let left = white.columns(r, 1) - white.columns(0, r) * &solution;
        let squares = left.norm_squared() + (prior * &solution).dot(&solution);
        let of_model: f64 = (0..r).map(|k| 2.0 * (lower[(k, k)] / scale[k]).ln()).sum();
        let determinants = [whitener.log_determinant(), of_model];
        let finite = squares.is_finite() && determinants.iter().all(|v| v.is_finite());
        finite.then(|| Anchor {
            noise,
            whitener,
            determinants,
            squares,
            left,
            lower,
            scale,
            traces: OnceLock::new(),
        })
    }

    /// L⁻¹ D Aᵀ B of columns B (m × k): r × k.
    pub fn turned(&self, base: &DMatrix<f64>, columns: &DMatrix<f64>) -> DMatrix<f64> {
        let mut turned = cross(base, columns);
        for (mut row, scale) in turned.row_iter_mut().zip(&self.scale) {
            row *= *scale;
        }
        solve_lower(&self.lower, &mut turned);
        turned
    }

    /// C⁻¹ Aᵀ B from [`Anchor::turned`].
    pub fn solved(&self, turned: DMatrix<f64>) -> DMatrix<f64> {
        back(&self.lower, &self.scale, turned)
    }

    /// tr P V_i of all components.
    pub fn traces(&self, base: &DMatrix<f64>, parts: &Parts) -> &[f64] {
        self.traces.get_or_init(|| {
            let m = base.nrows();
            let mut white = self.whitener.of(base).transpose();
            for (mut row, scale) in white.row_iter_mut().zip(&self.scale) {
                row *= *scale;
            }
            solve_lower(&self.lower, &mut white);
            // V⁻¹A turned: what P takes from V⁻¹.
            let mut taken = white.transpose();
            self.whitener.apply_transposed(&mut taken);
            let precisions = self.whitener.precisions(m);
            let whole = |part: &Part| match part {
                Part::Own(own) => (0..m).filter(|&at| own[at]).map(|at| precisions[at]).sum(),
                Part::Shared(factor) => self.whitener.of(factor).norm_squared(),
            };
            parts.each.iter().map(|(_, part)| whole(part) - parts.trace(part, &taken)).collect()
        })
    }
}

/// Brings a normal matrix to columns of these scales, with what keeps those that are alike apart.
pub(crate) fn unit(normal: &mut DMatrix<f64>, scale: &[f64]) {
    /// Of a column, what counts as independent of the others.
    const APART: f64 = 1e-12;
    for j in 0..scale.len() {
        (0..scale.len()).for_each(|i| normal[(i, j)] *= scale[i] * scale[j]);
        normal[(j, j)] += APART;
    }
}

/// What makes each number of a diagonal one; one of none.
pub(crate) fn scales<'d>(diagonal: impl IntoIterator<Item = &'d f64>) -> Vec<f64> {
    diagonal.into_iter().map(|&d| if d > 0.0 { 1.0 / d.sqrt() } else { 1.0 }).collect()
}

/// D L⁻ᵀ B.
fn back(lower: &DMatrix<f64>, scale: &[f64], mut columns: DMatrix<f64>) -> DMatrix<f64> {
    lower.tr_solve_lower_triangular_mut(&mut columns);
    for (mut row, scale) in columns.row_iter_mut().zip(scale) {
        row *= *scale;
    }
    columns
}

/// Noises at which candidates of one problem are held against each other: a quarter of a standard error of each component apart, from the noise of
/// the present model on. From starts of up to 1.5 times the standard deviations that are there −2 ln L is within a quarter of its least value at one of
/// them, from three times the scatter of the joints within 0.35 (measured on one arm; a tie is 6).
///
/// ```text
/// u_i = ln(1 + θ_i/s_i),     steps of s_i / 4(s_i + θ_i⁰),     s_i = I_ii^{-1/2} at θ⁰
/// ```
#[derive(Debug, Clone)]
pub(crate) struct Grid {
    start: Noise,
    /// u⁰, step and s of each component.
    each: Vec<(Component, [f64; 3])>,
}

impl Grid {
    /// Around a start, with the information about each component there.
    pub fn around(start: Noise, information: &[(Component, f64)]) -> Self {
        /// Of a standard error.
        const STEP: f64 = 0.25;
        let of = |&(component, information): &(Component, f64)| {
            let (theta, error) = (component.of(start), 1.0 / information.sqrt());
            (component, [(theta / error).ln_1p(), STEP * error / (error + theta), error])
        };
        Grid { start, each: information.iter().map(of).collect() }
    }

    /// The nearest noise of the grid; a component about which nothing is known stays as at the start.
    pub fn nearest(&self, noise: Noise) -> Noise {
        let mut near = self.start;
        for &(component, [first, step, error]) in &self.each {
            let u = (component.of(noise) / error).ln_1p();
            let steps = ((u - first) / step).round();
            // None at all, too, is the start's to the last bit.
            if steps.is_finite() && steps.abs() > 0.0 {
                component.set(&mut near, error * (first + steps * step).max(0.0).exp_m1());
            }
        }
        near
    }
}

/// An anchor, once it is asked for; none where the model has no solution.
type Once = Arc<OnceLock<Option<Arc<Anchor>>>>;

/// What candidates share: the parts of the noise, and the present model at the noises that were asked for.
#[derive(Debug, Default)]
pub(crate) struct Anchors {
    parts: OnceLock<Arc<Parts>>,
    grid: OnceLock<Option<Grid>>,
    known: Mutex<BTreeMap<[u64; 5], Once>>,
}

impl Anchors {
    /// The parts of the noise.
    pub fn parts(&self, problem: &Linearisation<'_>) -> Arc<Parts> {
        Arc::clone(self.parts.get_or_init(|| Arc::new(Parts::of(problem))))
    }

    /// The grid that candidates share, made when it is first asked for.
    pub fn grid(&self, made: impl FnOnce() -> Option<Grid>) -> Option<&Grid> {
        self.grid.get_or_init(made).as_ref()
    }

    /// The present model at a noise.
    pub fn at(&self, problem: &Linearisation<'_>, noise: Noise) -> Option<Arc<Anchor>> {
        /// Kept at once; more are computed anew each time.
        const MOST: usize = 100;
        let key = Component::ALL.map(|component| component.of(noise).to_bits());
        let place = {
            let mut known = self.known.lock().unwrap_or_else(PoisonError::into_inner);
            match known.len() < MOST || known.contains_key(&key) {
                true => Arc::clone(known.entry(key).or_default()),
                false => Arc::default(),
            }
        };
        place.get_or_init(|| Anchor::new(problem, noise).map(Arc::new)).clone()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::problem::noise::JointNoise;
    use truepose_identify::NoiseModel;

    #[test]
    fn noises_near_each_other_are_one() {
        let rows = NoiseModel { position_sd: 2e-5, visit_sd: 0.0, orientation_sd: 4e-5 };
        let start = Noise { rows, joints: JointNoise { turning: 3e-5, sliding: 0.0 } };
        // Standard errors of a tenth of the variance.
        let known = [Component::Rows, Component::Turning].map(|c| (c, (0.1 * c.of(start)).powi(-2)));
        let grid = Grid::around(start, &known);
        let moved = |rows: f64, turning: f64| {
            let mut noise = start;
            Component::Rows.set(&mut noise, rows * Component::Rows.of(start));
            Component::Turning.set(&mut noise, turning * Component::Turning.of(start));
            noise
        };
        assert_eq!(grid.nearest(moved(1.01, 0.99)), start);
        let near = grid.nearest(moved(0.8, 1.003));
        assert_eq!(near, grid.nearest(moved(0.805, 0.998)));
        assert_eq!(near, grid.nearest(near));
        assert!((Component::Rows.of(near) / Component::Rows.of(start) - 0.8).abs() < 0.013, "{near:?}");
        assert_eq!(near.joints, start.joints);
        // A component that is nothing stays on the grid.
        let nothing = grid.nearest(moved(1.0, 0.0));
        assert!(nothing.joints.turning.abs() < 1e-7 && nothing == grid.nearest(nothing));
    }
}
