//! A robust fit of constant errors: what the arm leaves when it is calibrated roughly, with rows that are wrong having no say.
//!
//! ```text
//! min Σ_k ρ(|e_k| / s),   e = r − A β,   ‖β / (κ S)‖ held;      ρ first |·|, then Tukey's biweight with s from the median, the arm exact anew
//! d_k = (1 − w_k P_k)⁻¹ e_k,     P_k = A_k G⁻¹ A_kᵀ,     G = Σ w AᵀA + s² (κS)⁻²
//! t_k² = d_kᵀ (1 + P_k (1 − w_k P_k)⁻¹)⁻¹ d_k / s²
//! ```
//!
//! | symbol | here | shape | unit |
//! | --- | --- | --- | --- |
//! | A_k, r_k | linearised constant errors and residual of a row's position | 3 × p, 3 | m |
//! | w_k | weight of a row, 0…1 | 1 | 1 |
//! | d_k | residual of a row by a fit that leaves it out | 3 | m |
//! | t_k | the same in its standard deviations | 1 | 1 |
//! | κ, S | 10 expected sizes | p | |
//!
//! A fit by least squares spreads one wrong row over the others and several hide each other (masking). The first fit minimises distances, not
//! squares, so that no row counts for more than its direction; the second gives rows far outside no weight at all.
//! Source: Huber and Ronchetti (2009), ch. 7; docs/references.md.

use crate::linearise::Lineariser;
use crate::{NoiseModel, place};
use nalgebra::{Cholesky, DMatrix, DVector, Dyn, Matrix3, Vector3};
use truepose_errormodel::effects::Geometric;
use truepose_errormodel::{Dataset, ErrorModel};
use truepose_kinematics::{Chain, TargetId};
use truepose_solvers::kernels::gram;
use truepose_solvers::order::high_median;

/// Rows that the fit is made of, and rows that are judged at most.
const FITTED: usize = 400;
const JUDGED: usize = 20_000;
/// Times that the arm is linearised, and iterations of weights each time.
const OUTER: usize = 3;
const INNER: usize = 8;
/// Median of the length of a normal vector in space, in standard deviations of one axis.
const MEDIAN: f64 = 1.538;
/// Deviations of one axis from which on a row has no weight: of good rows, one in 10 000 is farther.
const BIWEIGHT: f64 = 6.0;
/// Expected sizes within which constants lie.
const WIDE: f64 = 10.0;
/// Measured numbers for each unknown, at the least.
const NUMBERS: usize = 2;

/// A rough calibration.
pub(super) struct Constants<'a> {
    model: ErrorModel,
    data: &'a Dataset,
    coefficients: Vec<f64>,
    scale: f64,
    factor: Cholesky<f64, Dyn>,
    /// Weight of each row of the data; none: it took no part.
    weights: Vec<Option<f64>>,
}

/// What the others say of a row.
#[derive(Debug, Clone, Copy)]
pub(super) struct Judged {
    /// In the data, from 0.
    pub row: usize,
    /// |d|, m.
    pub distance: f64,
    /// t².
    pub square: f64,
}

/// One row: its design [3 × p] and its residual.
struct Line {
    row: usize,
    a: DMatrix<f64>,
    r: Vector3<f64>,
}

impl<'a> Constants<'a> {
    /// Fits constants to the positions of these rows; none where they are too few for that.
    pub fn fit(chain: &Chain, data: &'a Dataset, rows: &[usize]) -> Option<Self> {
        let stride = rows.len().div_ceil(FITTED).max(1);
        let fitted: Vec<usize> = rows.iter().step_by(stride).copied().collect();
        let placed = place(chain, &data.select(&fitted)).ok()?.chain;
        let model = ErrorModel::new(placed, vec![Box::new(Geometric::default())]).ok()?;
        let p = model.columns().len();
        if 3 * fitted.len() < NUMBERS * p {
            return None;
        }
        let held: Vec<f64> = model.columns().iter().map(|c| (WIDE * c.scale).powi(-2)).collect();
        let mut coefficients = vec![0.0; p];
        let mut found = None;
        let mut weights: Vec<f64> = vec![1.0; fitted.len()];
        let mut scale = f64::NAN;
        for outer in 0..OUTER {
            let lines = lines(&model, data, &coefficients, &fitted)?;
            let at = DVector::from_column_slice(&coefficients);
            let wanted: Vec<Vector3<f64>> = lines.iter().map(|line| line.r + to3(&(&line.a * &at))).collect();
            for inner in 0..INNER {
                let (normal, right) = normal(&lines, &wanted, &weights, &held, scale);
                let factor = Cholesky::new(normal)?;
                let beta = factor.solve(&right);
                let length: Vec<f64> =
                    lines.iter().zip(&wanted).map(|(line, y)| (y - to3(&(&line.a * &beta))).norm()).collect();
                if length.iter().any(|v| !v.is_finite()) {
                    return None;
                }
                let median = high_median(length.iter().copied()).unwrap_or(0.0);
                // What the unknowns have taken makes residuals small.
                let free = 1.0 - (p as f64 / (3.0 * lines.len() as f64)).min(0.6);
                scale = (median / MEDIAN / free.sqrt()).max(1e-12);
                let biweight = outer > 0 || inner + 1 == INNER;
                for (w, e) in weights.iter_mut().zip(&length) {
                    *w = if biweight {
                        (1.0 - (e / (BIWEIGHT * scale)).powi(2)).max(0.0).powi(2)
                    } else {
                        median / e.max(0.2 * median).max(f64::MIN_POSITIVE)
                    };
                }
                coefficients.copy_from_slice(beta.as_slice());
                found = Some(factor);
            }
        }
        let mut of_row = vec![None; data.len()];
        fitted.iter().zip(&weights).for_each(|(&row, &w)| of_row[row] = Some(w));
        Some(Constants { model, data, coefficients, scale, factor: found?, weights: of_row })
    }

    /// Standard deviation of one axis, m.
    pub fn scale(&self) -> f64 {
        self.scale
    }

    /// Judges rows, evenly taken where they are very many.
    pub fn judge(&self, rows: &[usize]) -> Option<Vec<Judged>> {
        let stride = rows.len().div_ceil(JUDGED).max(1);
        let rows: Vec<usize> = rows.iter().step_by(stride).copied().collect();
        self.judged(self.data, &rows)
    }

    /// Judges rows as if another target had been measured in them.
    pub fn judge_as(&self, rows: &[usize], target: Option<TargetId>) -> Option<Vec<Judged>> {
        let mut renamed = self.data.clone();
        rows.iter().for_each(|&row| renamed.target[row] = target);
        self.judged(&renamed, rows)
    }

    fn judged(&self, data: &Dataset, rows: &[usize]) -> Option<Vec<Judged>> {
        let mut all = Vec::with_capacity(rows.len());
        for chunk in rows.chunks(1024) {
            for line in lines(&self.model, data, &self.coefficients, chunk)? {
                let mut half = line.a.transpose();
                if !self.factor.l_dirty().solve_lower_triangular_mut(&mut half) {
                    return None;
                }
                let product = half.tr_mul(&half);
                let p = Matrix3::from_fn(|i, j| product[(i, j)]);
                let w = self.weights[line.row].unwrap_or(0.0);
                let out = (Matrix3::identity() - p * w).try_inverse()?;
                let d = out * line.r;
                let covariance = Matrix3::identity() + p * out;
                let square = d.dot(&(covariance.try_inverse()? * d)) / (self.scale * self.scale);
                all.push(Judged { row: line.row, distance: d.norm(), square: square.max(0.0) });
            }
        }
        Some(all)
    }
}

/// The lines of these rows at these coefficients.
fn lines(model: &ErrorModel, data: &Dataset, at: &[f64], rows: &[usize]) -> Option<Vec<Line>> {
    let noise = NoiseModel { position_sd: 1.0, visit_sd: 0.0, orientation_sd: 1.0 };
    let mut lineariser = Lineariser::new(model, data, noise, at).ok()?;
    let p = at.len();
    let one = |&row: &usize| {
        let block = lineariser.unweighted(&[row]);
        let a = DMatrix::from_fn(3, p, |i, j| block.rows[i * (p + 1) + j]);
        let r = Vector3::from_fn(|i, _| block.rows[i * (p + 1) + p]);
        Line { row, a, r }
    };
    Some(rows.iter().map(one).collect())
}

/// The lower triangle of AᵀWA + s² (κS)⁻², and AᵀWy.
fn normal(
    lines: &[Line],
    wanted: &[Vector3<f64>],
    weights: &[f64],
    held: &[f64],
    scale: f64,
) -> (DMatrix<f64>, DVector<f64>) {
    let p = held.len();
    let mut tall = DMatrix::zeros(3 * lines.len(), p);
    let mut y = DVector::zeros(3 * lines.len());
    for (k, ((line, wanted), w)) in lines.iter().zip(wanted).zip(weights).enumerate() {
        tall.rows_mut(3 * k, 3).copy_from(&(&line.a * w.sqrt()));
        y.rows_mut(3 * k, 3).copy_from(&(wanted * w.sqrt()));
    }
    let mut normal = DMatrix::zeros(p, p);
    gram(&mut normal, &tall);
    // Before the first scale is known: a tenth of a millimetre.
    let variance = if scale.is_finite() { (scale * scale).max(1e-12) } else { 1e-8 };
    held.iter().enumerate().for_each(|(k, h)| normal[(k, k)] += variance * h);
    (normal, tall.tr_mul(&y))
}

fn to3(v: &DVector<f64>) -> Vector3<f64> {
    Vector3::new(v[0], v[1], v[2])
}
