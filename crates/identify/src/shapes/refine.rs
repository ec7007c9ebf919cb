//! Descending into a valley of the shape parameters: Levenberg and Marquardt on the profiled residual, or on all unknowns.

use super::grid::gaps;
use super::picture::Picture;
use crate::IdentifyError;
use nalgebra::{DMatrix, DVector};
use truepose_errormodel::{NonlinearParameter, Search};
use truepose_solvers::nonlinear::{NonlinearLeastSquares, Separable, profile};
use truepose_solvers::{LeastSquares, LevenbergMarquardt, PivotedQr, Solver};

/// The smooth parameters of a picture as a separable problem; instants stay where they are.
pub(super) struct Valley<'a> {
    picture: &'a Picture<'a>,
    shapes: &'a [NonlinearParameter],
    theta: Vec<f64>,
    /// Which parameters are moved.
    pub smooth: Vec<usize>,
    columns: usize,
}

impl<'a> Valley<'a> {
    pub fn new(
        picture: &'a Picture<'a>,
        shapes: &'a [NonlinearParameter],
        theta: &[f64],
        moving: &[usize],
    ) -> Result<Self, IdentifyError> {
        let smooth = moving.iter().copied().filter(|&k| shapes[k].search != Search::Instant).collect();
        let columns = picture.all(theta)?.ncols();
        Ok(Valley { picture, shapes, theta: theta.to_vec(), smooth, columns })
    }

    /// All parameters, from those that are moved.
    fn whole(&self, moved: &[f64]) -> Vec<f64> {
        let mut theta = self.theta.clone();
        self.smooth.iter().zip(moved).for_each(|(&k, v)| theta[k] = *v);
        theta
    }

    /// Derivative of the columns of a moved parameter's effect, times their coefficients.
    pub fn slope(&self, moved: &[f64], k: usize, b: &DVector<f64>) -> Result<DVector<f64>, IdentifyError> {
        let at = self.smooth[k];
        let (lower, upper) = (self.shapes[at].lower, self.shapes[at].upper);
        let step = f64::EPSILON.cbrt() * moved[k].abs().max(1e-3 * (upper - lower));
        let owner = self.picture.trial.owner[at];
        let own = b.rows_range(self.picture.columns_of(owner)).into_owned();
        let told = |value: f64| -> Result<DVector<f64>, IdentifyError> {
            let mut moved = moved.to_vec();
            moved[k] = value;
            Ok(self.picture.columns(owner, &self.whole(&moved))? * &own)
        };
        // One-sided at an end: beyond it the effect may make no sense, as a period below zero.
        let here = moved[k].clamp(lower, upper);
        let (above, below) = ((here + step).min(upper), (here - step).max(lower));
        Ok((told(above)? - told(below)?) / (above - below))
    }
}

impl Separable for Valley<'_> {
    fn size(&self) -> (usize, usize, usize) {
        (self.picture.target.len(), self.columns, self.smooth.len())
    }

    fn basis(&self, moved: &[f64], out: &mut DMatrix<f64>) {
        let inside = self.smooth.iter().zip(moved).all(|(&k, v)| {
            let shape = &self.shapes[k];
            (shape.lower..=shape.upper).contains(v)
        });
        match self.picture.all(&self.whole(moved)) {
            Ok(columns) if inside => out.copy_from(&self.picture.beyond(columns)),
            // Out of its range: the search takes a shorter step.
            _ => out.fill(f64::NAN),
        }
    }

    fn observed(&self) -> &DVector<f64> {
        &self.picture.target
    }

    fn derivative(&self, moved: &[f64], k: usize, b: &DVector<f64>, out: &mut DVector<f64>) {
        match self.slope(moved, k, b) {
            Ok(slope) => {
                let columns = DMatrix::from_column_slice(slope.len(), 1, slope.as_slice());
                out.copy_from(&self.picture.beyond(columns).column(0));
            }
            Err(_) => out.fill(f64::NAN),
        }
    }
}

/// Coefficients and smooth parameters as unknowns side by side.
struct Joint<'a>(&'a Valley<'a>);

impl NonlinearLeastSquares for Joint<'_> {
    fn size(&self) -> (usize, usize) {
        let (m, p, q) = self.0.size();
        (m, p + q)
    }

    fn residual(&self, x: &[f64], out: &mut DVector<f64>) {
        let (m, p, _) = self.0.size();
        let mut basis = DMatrix::zeros(m, p);
        self.0.basis(&x[p..], &mut basis);
        out.copy_from(&(basis * DVector::from_column_slice(&x[..p]) - self.0.observed()));
    }

    fn jacobian(&self, x: &[f64], out: &mut DMatrix<f64>) {
        let (m, p, q) = self.0.size();
        let mut basis = DMatrix::zeros(m, p);
        self.0.basis(&x[p..], &mut basis);
        out.columns_mut(0, p).copy_from(&basis);
        let b = DVector::from_column_slice(&x[..p]);
        let mut slope = DVector::zeros(m);
        for k in 0..q {
            self.0.derivative(&x[p..], k, &b, &mut slope);
            out.set_column(p + k, &slope);
        }
    }
}

/// ‖(I − X̃ X̃⁺) ỹ‖².
pub(super) fn left(basis: &DMatrix<f64>, target: &DVector<f64>) -> Result<f64, IdentifyError> {
    Ok(solved(basis, target)?.1)
}

/// X̃⁺ ỹ, and the squares that it leaves.
pub(super) fn solved(
    basis: &DMatrix<f64>,
    target: &DVector<f64>,
) -> Result<(DVector<f64>, f64), IdentifyError> {
    let solution = PivotedQr::default().solve(&LeastSquares::new(basis, target))?;
    Ok((solution.x, solution.info.residual_norm.powi(2)))
}

/// The parameters at the bottom of the valley in which they lie; those that are not `moving` stay.
pub(super) fn descend(
    picture: &Picture<'_>,
    shapes: &[NonlinearParameter],
    theta: &[f64],
    moving: &[usize],
    joint: bool,
) -> Result<Vec<f64>, IdentifyError> {
    let mut theta = theta.to_vec();
    for &k in moving.iter().filter(|&&k| shapes[k].search == Search::Instant) {
        theta[k] = instant(picture, shapes, &theta, k)?;
    }
    let valley = Valley::new(picture, shapes, &theta, moving)?;
    if valley.smooth.is_empty() {
        return Ok(theta);
    }
    let start: Vec<f64> = valley.smooth.iter().map(|&k| theta[k]).collect();
    let mut search = LevenbergMarquardt::default();
    (search.max_iterations, search.step_tolerance) = (60, 1e-11);
    let moved: Vec<f64> = if joint {
        let (m, p, _) = valley.size();
        let mut basis = DMatrix::zeros(m, p);
        valley.basis(&start, &mut basis);
        let b = PivotedQr::default().solve(&LeastSquares::new(&basis, valley.observed()))?.x;
        let x: Vec<f64> = b.iter().copied().chain(start.iter().copied()).collect();
        search.minimise(&Joint(&valley), &x)?.x.iter().skip(p).copied().collect()
    } else {
        profile(&valley, &start, &search)?.shape.x.iter().copied().collect()
    };
    // A search that broke down stays where it began.
    let fine = moved.iter().all(|v| v.is_finite());
    Ok(if fine { valley.whole(&moved) } else { theta })
}

/// The best gap between two visits near an instant: everywhere among gaps that are few, else about the present one.
fn instant(
    picture: &Picture<'_>,
    shapes: &[NonlinearParameter],
    theta: &[f64],
    k: usize,
) -> Result<f64, IdentifyError> {
    const NEAR: usize = 150;
    let middles: Vec<f64> = gaps(&shapes[k], picture.data).iter().map(|g| 0.5 * (g[0] + g[1])).collect();
    let here = middles.partition_point(|m| *m < theta[k]);
    let around = here.saturating_sub(NEAR)..(here + NEAR).min(middles.len());
    let mut best = (f64::INFINITY, theta[k]);
    for &value in &middles[around] {
        let mut trial = theta.to_vec();
        trial[k] = value;
        let left = left(&picture.beyond(picture.all(&trial)?), &picture.target)?;
        if left < best.0 {
            best = (left, value);
        }
    }
    Ok(best.1)
}
