//! Mean and scatter of attained positions, and the uncertainty of a repeatability.
//!
//! ```text
//! x̄ = Σ x_j / n        S = Σ (x_j − x̄)(x_j − x̄)ᵀ / (n − 1)        l_j = ‖x_j − x̄‖
//! ```
//!
//! The repeatability RP of ISO 9283 is l̄ + 3 S_l, a mean and a standard deviation of lengths. Its distribution has no closed form. For normal
//! positions with covariance S the ratio of RP to the expected RP depends on the shape of S alone: it is drawn (parametric bootstrap), and its
//! quantiles give an interval whose level does not depend on the size of the scatter.

use crate::figure::{Figure, Method};
use nalgebra::{Matrix3, Vector3};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

/// Draws of a bootstrap: the 2.5 % quantile is then known to a tenth of its distance from the median.
const DRAWS: usize = 2000;
/// All bootstraps draw from here: equal data gives equal figures.
const SEED: u64 = 9283;

/// Mean, covariance and distances from the mean.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Scatter {
    pub mean: Vector3<f64>,
    pub covariance: Matrix3<f64>,
    pub mean_length: f64,
    pub sd_length: f64,
    pub count: usize,
}

impl Scatter {
    /// Of two values at least.
    pub fn of(values: &[Vector3<f64>]) -> Self {
        let count = values.len();
        let n = count as f64;
        let mean = values.iter().sum::<Vector3<f64>>() / n;
        let outer: Matrix3<f64> = values.iter().map(|v| (v - mean) * (v - mean).transpose()).sum();
        let lengths: Vec<f64> = values.iter().map(|v| (v - mean).norm()).collect();
        let mean_length = lengths.iter().sum::<f64>() / n;
        let square: f64 = lengths.iter().map(|l| (l - mean_length).powi(2)).sum();
        let freedom = (n - 1.0).max(1.0);
        Scatter {
            mean,
            covariance: outer / freedom,
            mean_length,
            sd_length: (square / freedom).sqrt(),
            count,
        }
    }

    pub fn freedom(&self) -> f64 {
        (self.count as f64 - 1.0).max(1.0)
    }

    /// Variance of the mean in a direction of length one.
    pub fn variance_of_mean(&self, direction: &Vector3<f64>) -> f64 {
        (direction.transpose() * self.covariance * direction)[0] / self.count as f64
    }

    /// RP_l = l̄ + 3 S_l, with its uncertainty.
    pub fn repeatability(&self) -> Figure {
        let value = self.mean_length + 3.0 * self.sd_length;
        let mut eigen: Vec<f64> =
            self.covariance.symmetric_eigenvalues().iter().map(|v| v.max(0.0)).collect();
        eigen.sort_by(f64::total_cmp);
        let sds: Vec<f64> = eigen.iter().map(|v| v.sqrt()).collect();
        if value <= 0.0 || sds.iter().sum::<f64>() <= 0.0 {
            return Figure::with_u(value, 0.0, self.freedom(), Method::Bootstrap);
        }
        let mut rng = ChaCha8Rng::seed_from_u64(SEED);
        let mut draw = |sd: f64| -> f64 {
            let z: f64 = StandardNormal.sample(&mut rng);
            sd * z
        };
        let (mut lengths, mut squares, mut total) = (0.0, 0.0, 0.0);
        let mut drawn = Vec::with_capacity(DRAWS);
        let mut sample = vec![Vector3::zeros(); self.count];
        for _ in 0..DRAWS {
            for v in &mut sample {
                *v = Vector3::new(draw(sds[0]), draw(sds[1]), draw(sds[2]));
                let length = v.norm();
                lengths += length;
                squares += length * length;
                total += 1.0;
            }
            let one = Scatter::of(&sample);
            drawn.push(one.mean_length + 3.0 * one.sd_length);
        }
        let mean = lengths / total;
        let expected = mean + 3.0 * (squares / total - mean * mean).max(0.0).sqrt();
        let mut ratios: Vec<f64> = drawn.into_iter().filter(|v| *v > 0.0).map(|v| expected / v).collect();
        ratios.sort_by(f64::total_cmp);
        let at = |p: f64| {
            let place = p * (ratios.len() as f64 - 1.0);
            let (k, part) = (place as usize, place.fract());
            let next = ratios[(k + 1).min(ratios.len() - 1)];
            value * (ratios[k] + part * (next - ratios[k]))
        };
        let centre = ratios.iter().sum::<f64>() / ratios.len() as f64;
        let variance = ratios.iter().map(|r| (r - centre).powi(2)).sum::<f64>() / ratios.len() as f64;
        Figure {
            value,
            u: value * variance.sqrt(),
            freedom: self.freedom(),
            ci95: [at(0.025), at(0.975)],
            bounds95: [at(0.05), at(0.95)],
            method: Method::Bootstrap,
        }
    }
}
