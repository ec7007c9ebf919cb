//! Noise between poses with a memory: a first-order autoregression.
//!
//! ```text
//! u_0 = s ε_0          u_k = φ u_(k−1) + s √(1 − φ²) ε_k          var u_k = s²,   corr(u_k, u_(k+j)) = φ^j
//! ```
//!
//! | symbol | here | unit |
//! | --- | --- | --- |
//! | φ | `memory`, of each axis | 1 |
//! | s | `sd`, of each axis | m |
//!
//! Source: Box, Jenkins and Reinsel, *Time Series Analysis*, section 3.2.3; it starts in its stationary distribution.

use crate::SimulateError;
use nalgebra::Vector3;
use rand::Rng;
use rand_distr::{Distribution, StandardNormal};

/// Noise of a pose that remembers that of the pose before, axis by axis of the measurement frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Wander {
    /// Correlation of two poses in succession, −1 to 1 exclusive.
    pub memory: [f64; 3],
    /// Standard deviation, m.
    pub sd: [f64; 3],
}

impl Wander {
    /// The same in all axes.
    pub fn even(memory: f64, sd: f64) -> Self {
        Wander { memory: [memory; 3], sd: [sd; 3] }
    }

    pub(super) fn checked(&self) -> Result<(), SimulateError> {
        match self.memory.iter().find(|memory| memory.is_nan() || memory.abs() >= 1.0) {
            Some(&value) => {
                Err(SimulateError::Size { what: "an autocorrelation", value, need: "between -1 and 1" })
            }
            None => Ok(()),
        }
    }

    /// Deviation of each of these poses in succession, m.
    pub fn path(&self, poses: usize, rng: &mut impl Rng) -> Vec<Vector3<f64>> {
        let mut before: Option<Vector3<f64>> = None;
        let step = |_| {
            let fresh = Vector3::from_fn(|k, _| self.sd[k] * normal(rng));
            let now = match before {
                None => fresh,
                Some(before) => Vector3::from_fn(|k, _| {
                    let memory = self.memory[k];
                    memory * before[k] + (1.0 - memory * memory).sqrt() * fresh[k]
                }),
            };
            before = Some(now);
            now
        };
        (0..poses).map(step).collect()
    }
}

/// A standard normal number.
pub(super) fn normal(rng: &mut impl Rng) -> f64 {
    StandardNormal.sample(rng)
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;

    #[test]
    fn its_autocorrelation_is_the_power_of_its_memory() {
        let memory = [0.2, 0.4, 0.6];
        let wander = Wander { memory, sd: [1e-5, 2e-5, 3e-5] };
        let path = wander.path(40_000, &mut ChaCha8Rng::seed_from_u64(2));
        for axis in 0..3 {
            let mean = |lag: usize| {
                let products = path.iter().zip(&path[lag..]).map(|(a, b)| a[axis] * b[axis]);
                products.sum::<f64>() / (path.len() - lag) as f64
            };
            let variance = mean(0);
            // 40 000 poses: a correlation is known to 0.005, a variance to 1.5 % at φ = 0.6.
            assert!((variance.sqrt() / wander.sd[axis] - 1.0).abs() < 0.02, "{axis}");
            for lag in 1..4 {
                let expected = memory[axis].powi(lag as i32);
                assert!((mean(lag) / variance - expected).abs() < 0.02, "axis {axis}, lag {lag}");
            }
        }
    }

    #[test]
    fn without_memory_it_is_white_and_a_memory_of_one_is_refused() {
        let path = Wander::even(0.0, 1e-5).path(20_000, &mut ChaCha8Rng::seed_from_u64(3));
        let products: f64 = path.windows(2).map(|pair| pair[0].dot(&pair[1])).sum();
        let squares: f64 = path.iter().map(|u| u.norm_squared()).sum();
        assert!((products / squares).abs() < 0.02);
        assert!(Wander::even(1.0, 1e-5).checked().is_err() && Wander::even(0.6, 1e-5).checked().is_ok());
    }
}
