//! How surprising a candidate is.

use crate::statistics::chi_square::surprise;

/// How surprising a candidate is, twice: each sees causes that the other does not.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Surprise {
    /// As if all numbers were independent: what dominates the residual, be it in a few visits, stands out.
    pub among_numbers: f64,
    /// By the law of its own share under random signs of the visits: what a simple cause does stands out from what rich ones do by chance.
    pub among_visits: f64,
}

impl Surprise {
    /// Nothing was looked at.
    pub const NONE: Surprise = Surprise { among_numbers: f64::NEG_INFINITY, among_visits: f64::NEG_INFINITY };

    /// From the gain as χ² with so many degrees of freedom, and among visits.
    pub fn of(gain: f64, freedom: usize, among_visits: f64) -> Self {
        Surprise { among_numbers: surprise(gain, freedom), among_visits }
    }

    /// The larger of each.
    pub fn max(self, other: Self) -> Self {
        Surprise {
            among_numbers: self.among_numbers.max(other.among_numbers),
            among_visits: self.among_visits.max(other.among_visits),
        }
    }
}
