//! A smooth random curve: a draw from a Gaussian process, with a cubic spline between its points.
//!
//! ```text
//! cov(f(x), f(x')) = σ² (1 + r + r²/3) e^{-r},   r = √5 |x − x'| / ℓ        (Matérn, ν = 5/2)
//! ```
//!
//! | symbol | here | unit |
//! | --- | --- | --- |
//! | σ | `rms` | of the curve |
//! | ℓ | `correlation` | of x |
//!
//! It represents errors without a closed form: straightness of a guideway, ambient temperature, settling of a
//! tripod. It is neither a polynomial nor a Fourier series nor a spline on the model's knots.
//! Source: Rasmussen and Williams, *Gaussian Processes for Machine Learning*, Eq. (4.17); the spline is the
//! natural cubic one through the drawn points.

use crate::SimulateError;
use nalgebra::{Cholesky, DMatrix, DVector};
use rand::Rng;
use rand_distr::{Distribution, StandardNormal};

/// A function given by equidistant points and a natural cubic spline; constant outside its range.
#[derive(Debug, Clone, PartialEq)]
pub struct SmoothCurve {
    start: f64,
    step: f64,
    values: Vec<f64>,
    bends: Vec<f64>,
}

/// What is taken out of a draw before it is scaled to its root mean square.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Centred {
    /// Its mean.
    Mean,
    /// Its mean and its slope: the residual of a guideway after its position and direction.
    MeanAndSlope,
    /// Its first value: something that begins at zero and wanders away.
    Start,
}

impl SmoothCurve {
    /// The curve through `values` at `start`, `start + step`, …; at least two values, a positive step.
    ///
    /// # Errors
    /// [`SimulateError::Size`] or [`SimulateError::Shape`] when that is not so.
    pub fn through(start: f64, step: f64, values: Vec<f64>) -> Result<Self, SimulateError> {
        if step.is_nan() || step <= 0.0 {
            return Err(SimulateError::Size { what: "the step of a curve", value: step, need: "positive" });
        }
        if values.len() < 2 {
            return Err(SimulateError::Shape { what: "points of a curve", have: values.len(), need: 2 });
        }
        let bends = second_derivatives(step, &values);
        Ok(SmoothCurve { start, step, values, bends })
    }

    /// A random curve over `range` with this correlation length and root mean square.
    ///
    /// # Errors
    /// [`SimulateError::Size`] for an empty range, a correlation length that is not positive or a negative size.
    pub fn draw(
        range: (f64, f64),
        correlation: f64,
        rms: f64,
        centred: Centred,
        rng: &mut impl Rng,
    ) -> Result<Self, SimulateError> {
        let length = range.1 - range.0;
        for (what, value) in [("the range of a curve", length), ("a correlation length", correlation)] {
            if !value.is_finite() || value <= 0.0 {
                return Err(SimulateError::Size { what, value, need: "positive" });
            }
        }
        if !rms.is_finite() || rms < 0.0 {
            return Err(SimulateError::Size {
                what: "the size of a curve",
                value: rms,
                need: "zero or more",
            });
        }
        // Six points a correlation length carry all of the process but 1e-3 of its size.
        let intervals = ((6.0 * length / correlation).ceil() as usize).clamp(12, 360);
        let step = length / intervals as f64;
        let mut values = matern_draw(intervals + 1, step / correlation, rng);
        centre(&mut values, centred);
        let size = (values.iter().map(|v| v * v).sum::<f64>() / values.len() as f64).sqrt();
        for value in &mut values {
            *value *= rms / size.max(f64::MIN_POSITIVE);
        }
        SmoothCurve::through(range.0, step, values)
    }

    /// The value at x.
    pub fn value(&self, x: f64) -> f64 {
        let last = self.values.len() - 1;
        let u = ((x - self.start) / self.step).clamp(0.0, last as f64);
        let k = (u.floor() as usize).min(last - 1);
        let (b, h) = (u - k as f64, self.step);
        let a = 1.0 - b;
        a * self.values[k]
            + b * self.values[k + 1]
            + ((a * a * a - a) * self.bends[k] + (b * b * b - b) * self.bends[k + 1]) * h * h / 6.0
    }

    /// Where the curve begins and ends.
    pub fn range(&self) -> (f64, f64) {
        (self.start, self.start + self.step * (self.values.len() - 1) as f64)
    }

    /// The same curve with `offset + slope · (x − start)` added at its points.
    pub fn tilted(&self, offset: f64, slope: f64) -> SmoothCurve {
        let values = self.values.iter().enumerate().map(|(k, v)| v + offset + slope * self.step * k as f64);
        // A straight line has no second derivative.
        SmoothCurve { values: values.collect(), ..self.clone() }
    }
}

fn matern_draw(count: usize, step_over_correlation: f64, rng: &mut impl Rng) -> Vec<f64> {
    let covariance = DMatrix::from_fn(count, count, |i, j| {
        let r = 5f64.sqrt() * i.abs_diff(j) as f64 * step_over_correlation;
        (1.0 + r + r * r / 3.0) * (-r).exp() + if i == j { 1e-9 } else { 0.0 }
    });
    let white = DVector::from_fn(count, |_, _| StandardNormal.sample(rng));
    match Cholesky::new(covariance) {
        Some(factor) => (factor.l() * white).as_slice().to_vec(),
        // The diagonal term keeps the matrix positive definite; without correlation the draw is still a draw.
        None => white.as_slice().to_vec(),
    }
}

fn centre(values: &mut [f64], centred: Centred) {
    let n = values.len() as f64;
    let mean = values.iter().sum::<f64>() / n;
    let middle = (n - 1.0) / 2.0;
    let square: f64 = (0..values.len()).map(|k| (k as f64 - middle).powi(2)).sum();
    let slope = values.iter().enumerate().map(|(k, v)| (k as f64 - middle) * v).sum::<f64>() / square;
    let first = values[0];
    for (k, value) in values.iter_mut().enumerate() {
        *value -= match centred {
            Centred::Mean => mean,
            Centred::MeanAndSlope => mean + slope * (k as f64 - middle),
            Centred::Start => first,
        };
    }
}

/// Second derivatives of the natural cubic spline, by the tridiagonal sweep.
fn second_derivatives(h: f64, y: &[f64]) -> Vec<f64> {
    let n = y.len();
    let (mut diagonal, mut right) = (vec![0.0; n], vec![0.0; n]);
    for k in 1..n - 1 {
        let weight = if k > 1 { 1.0 / diagonal[k - 1] } else { 0.0 };
        diagonal[k] = 4.0 - weight;
        right[k] = 6.0 * (y[k + 1] - 2.0 * y[k] + y[k - 1]) / (h * h) - weight * right[k - 1];
    }
    let mut bends = vec![0.0; n];
    for k in (1..n - 1).rev() {
        bends[k] = (right[k] - bends[k + 1]) / diagonal[k];
    }
    bends
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;

    #[test]
    fn the_spline_goes_through_its_points_and_follows_a_sine() {
        let values: Vec<f64> = (0..=40).map(|k| (0.1 * f64::from(k)).sin()).collect();
        let curve = SmoothCurve::through(0.0, 0.1, values.clone()).expect("a curve");
        assert!((curve.value(0.7) - values[7]).abs() < 1e-14);
        // The error of a cubic spline is 5/384 h⁴ |f''''| ≈ 1.3e-6 inside; the natural ends are worse.
        assert!((curve.value(1.234) - 1.234f64.sin()).abs() < 2e-6, "{}", curve.value(1.234));
    }

    #[test]
    fn a_draw_has_its_size_and_its_correlation() {
        let mut rng = ChaCha8Rng::seed_from_u64(3);
        let (mut product, mut square) = (0.0, 0.0);
        for _ in 0..60 {
            let curve = SmoothCurve::draw((-1.0, 3.0), 0.1, 2e-5, Centred::Mean, &mut rng).expect("a curve");
            let values: Vec<f64> = (0..400).map(|k| curve.value(-1.0 + 0.01 * f64::from(k))).collect();
            let mean = values.iter().sum::<f64>() / 400.0;
            let rms = (values.iter().map(|v| v * v).sum::<f64>() / 400.0).sqrt();
            // Centred and scaled on 241 nodes, looked at on 400 points.
            assert!(mean.abs() < 1e-6 && (rms / 2e-5 - 1.0).abs() < 0.05, "{mean} {rms}");
            for k in 0..390 {
                product += values[k] * values[k + 10];
                square += values[k] * values[k];
            }
        }
        // One correlation length apart: (1 + √5 + 5/3) e^{−√5} = 0.524. The mean that was taken out carried
        // 2 · 1.19 ℓ of the forty: (0.524 − 0.06) / (1 − 0.06) = 0.494.
        let correlation = product / square;
        assert!((correlation - 0.494).abs() < 0.03, "{correlation}");
    }

    #[test]
    fn what_is_taken_out_is_gone() {
        let mut rng = ChaCha8Rng::seed_from_u64(4);
        let mut draw = |centred| SmoothCurve::draw((0.0, 2.0), 1.0, 1.0, centred, &mut rng).expect("a curve");
        let moment = |curve: &SmoothCurve, power: i32| {
            let (n, values) = (curve.values.len() as f64, curve.values.iter().enumerate());
            values.map(|(k, v)| v * (k as f64 - (n - 1.0) / 2.0).powi(power)).sum::<f64>()
        };
        assert!(moment(&draw(Centred::Mean), 0).abs() < 1e-12);
        let straightness = draw(Centred::MeanAndSlope);
        assert!(moment(&straightness, 0).abs() < 1e-12 && moment(&straightness, 1).abs() < 1e-11);
        assert_eq!(draw(Centred::Start).value(0.0).to_bits(), 0f64.to_bits());
    }

    #[test]
    fn the_seed_decides() {
        let draw = |seed| {
            let mut rng = ChaCha8Rng::seed_from_u64(seed);
            SmoothCurve::draw((0.0, 1.0), 0.2, 1.0, Centred::Mean, &mut rng).expect("a curve")
        };
        assert_eq!(draw(1), draw(1));
        assert_ne!(draw(1), draw(2));
    }
}
