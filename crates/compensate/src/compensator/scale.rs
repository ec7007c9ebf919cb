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
        let limits = chain.joint(chain.movable()[k]).limits.filter(|_| !self.options.hold.contains(&k));
        limits.map_or(value, |(lower, upper)| value.clamp(lower, upper))
    }

    /// Gives joints that follow others their place in units of the search.
    pub(super) fn follow(&self, x: &mut [f64; MOST]) {
        for follower in self.fitted.chain().followers() {
            let driver = x[follower.driver] * self.scale[follower.driver];
            x[follower.joint] = (follower.ratio * driver + follower.offset) / self.scale[follower.joint];
        }
    }

    /// How many joints the controller may move.
    pub(super) fn commanded(&self) -> usize {
        self.nominal.joints() - self.fitted.chain().followers().len() - self.options.hold.len()
    }

    /// A seed in units of the search, whole turns off where that brings it within the limits.
    pub(super) fn seed(&self, joints: &[f64]) -> [f64; MOST] {
        let mut x = [0.0; MOST];
        for (k, &q) in joints.iter().enumerate() {
            x[k] = q / self.scale[k];
        }
        let mut inside = self.within(&self.wrapped(&x));
        self.follow(&mut inside);
        inside
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
