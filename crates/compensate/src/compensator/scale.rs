//! Joint values in the units of the search, whole turns off where that brings them within their limits.
//!
//! ```text
//! x_k = q_k / s_k,   s = 1 for a turn, the characteristic length for a slide
//! ```

use super::Compensator;
use crate::command::MOST;
use std::f64::consts::TAU;

impl Compensator<'_> {
    /// A joint's value; exactly its limit where x lies there.
    pub(super) fn joint(&self, k: usize, x: f64) -> f64 {
        let chain = self.fitted.chain();
        let value = x * self.scale[k];
        chain.joint(chain.movable()[k]).limits.map_or(value, |(lower, upper)| value.clamp(lower, upper))
    }

    /// A seed in units of the search, whole turns off where that brings it within the limits.
    pub(super) fn seed(&self, joints: &[f64]) -> [f64; MOST] {
        let mut x = [0.0; MOST];
        for (k, &q) in joints.iter().enumerate() {
            x[k] = q / self.scale[k];
        }
        self.within(&self.wrapped(&x))
    }

    pub(super) fn within(&self, x: &[f64; MOST]) -> [f64; MOST] {
        let mut inside = *x;
        for (k, x) in inside.iter_mut().enumerate().take(self.nominal.joints()) {
            *x = x.clamp(self.limits.lower[k], self.limits.upper[k]);
        }
        inside
    }

    pub(super) fn wrapped(&self, x: &[f64; MOST]) -> [f64; MOST] {
        let mut inside = *x;
        for (k, x) in inside.iter_mut().enumerate().take(self.nominal.joints()) {
            let (lower, upper) = (self.limits.lower[k], self.limits.upper[k]);
            if self.nominal.slides(k) || (*x >= lower && *x <= upper) {
                continue;
            }
            let goal = if *x < lower { lower } else { upper };
            let off = ((*x - goal) / TAU).abs().ceil() * TAU;
            *x = if *x < lower { *x + off } else { *x - off };
        }
        inside
    }
}
