//! How surprising a candidate is.

use crate::statistics::chi_square::surprisal;

/// How surprising a candidate is, twice: each sees causes that the other does not.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Surprisal {
    /// As if all numbers were independent: what dominates the residual, be it in a few visits, stands out.
    pub among_observations: f64,
    /// By the law of its own share under random signs of the visits: what a simple cause does stands out from what rich ones do by chance.
    pub among_poses: f64,
}

impl Surprisal {
    /// Nothing was looked at.
    pub const NONE: Surprisal =
        Surprisal { among_observations: f64::NEG_INFINITY, among_poses: f64::NEG_INFINITY };

    /// From the gain as χ² with so many degrees of freedom, and among visits.
    pub fn of(gain: f64, freedom: usize, among_poses: f64) -> Self {
        Surprisal { among_observations: surprisal(gain, freedom), among_poses }
    }

    /// The larger of each.
    pub fn max(self, other: Self) -> Self {
        Surprisal {
            among_observations: self.among_observations.max(other.among_observations),
            among_poses: self.among_poses.max(other.among_poses),
        }
    }
}
