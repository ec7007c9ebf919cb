//! Stated standard deviations that exceed the scatter.
//!
//! What an instrument states is a lower bound of the noise: the robot's repeatability and more are estimated on top of it. When it is too
//! small, the estimate makes up for it. When it is too large, nothing can: every interval is too wide and every likelihood too flat. Then the
//! stated values are scaled down, all by the same factor, and the result says so.
//!
//! ```text
//! c = Σ (r/s)² / ν  within pose measurements, over all of them, of orientations, and (f/s)² of repeats;   scaled by √c where c ν < χ²_{ν, 0.001}
//! ```

use crate::conclude::floor::stated_rms;
use statrs::distribution::{ChiSquared, ContinuousCDF};
use truepose_errormodel::{Dataset, Visits};
use truepose_identify::{Fit, Freedom, PureError, exact_repeats};

/// Factors on the stated standard deviations; one where they are left as they are.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StatedScale {
    /// Of positions.
    pub position: f64,
    /// Of orientations.
    pub orientation: f64,
}

impl Default for StatedScale {
    fn default() -> Self {
        StatedScale { position: 1.0, orientation: 1.0 }
    }
}

/// Level of the test: of a thousand data sets whose instrument states the truth, one is scaled. Convention.
const LEVEL: f64 = 1e-3;

/// A factor nearer to one changes nothing that matters: intervals by a tenth.
const MATTERS: f64 = 0.9;

impl StatedScale {
    /// Whether the stated standard deviations are used as they are.
    pub fn is_one(&self) -> bool {
        self.position >= 1.0 && self.orientation >= 1.0
    }

    /// Both in turn.
    pub(crate) fn times(self, other: Self) -> Self {
        StatedScale {
            position: self.position * other.position,
            orientation: self.orientation * other.orientation,
        }
    }

    /// Data with the scaled standard deviations.
    pub(crate) fn applied(self, data: &Dataset) -> Dataset {
        let mut data = data.clone();
        data.position_sd.iter_mut().flatten().for_each(|sd| *sd *= self.position);
        data.orientation_sd.iter_mut().flatten().for_each(|sd| *sd *= self.orientation);
        data
    }

    /// By how much the scatter of a fit's residuals is below what is stated; `None` where it is not, or nothing is stated.
    pub(crate) fn of(fit: &Fit, data: &Dataset) -> Option<Self> {
        let left = Freedom::of(fit, data).ok()?;
        let (mut within, mut all) = (0.0, 0.0);
        let (mut positions, mut seen) = (0usize, 0usize);
        for rows in &Visits::of(data).rows {
            for axis in 0..3 {
                let (mut along, mut squares, mut weight, mut n) = (0.0, 0.0, 0.0, 0);
                for &row in rows {
                    let (r, s) = (fit.residuals.position[row][axis], data.position_sd[row][axis]);
                    seen += usize::from(r.is_finite());
                    if r.is_finite() && s > 0.0 {
                        (along, squares, weight) =
                            (along + r / (s * s), squares + r * r / (s * s), weight + 1.0 / (s * s));
                        n += 1;
                    }
                }
                if n > 0 {
                    all += squares;
                    within += (squares - along * along / weight).max(0.0);
                    positions += n;
                }
            }
        }
        let (mut turns, mut turned) = (0.0, 0usize);
        for (row, turn) in fit.residuals.orientation.iter().enumerate() {
            let Some(turn) = turn else { continue };
            for axis in 0..3 {
                let s = data.orientation_sd[row][axis];
                if s > 0.0 {
                    turns += (turn[axis] / s).powi(2);
                    turned += 1;
                }
            }
        }
        let whole = |stated: usize, measured: usize| stated > 0 && stated == measured;
        let mut scale = StatedScale::default();
        if whole(positions, seen) {
            let pure = stated_rms(data).zip(PureError::of(&fit.residuals, data, &exact_repeats(data)));
            let of_repeats = pure.and_then(|(s, pure)| excess((pure.rms / s).powi(2), pure.freedom));
            let each =
                [excess(within / left.within, left.within), excess(all / left.positions(), left.positions())];
            let least = each.into_iter().flatten().chain(of_repeats).reduce(f64::min);
            scale.position = least.unwrap_or(1.0);
        }
        let measured = 3 * fit.residuals.orientation.iter().flatten().count();
        if whole(turned, measured) {
            scale.orientation = excess(turns / left.turns, left.turns).unwrap_or(1.0);
        }
        (!scale.is_one()).then_some(scale)
    }
}

/// √c where c is significantly below one, by enough to matter.
fn excess(c: f64, freedom: f64) -> Option<f64> {
    if !(freedom >= 6.0 && c > 0.0) {
        return None;
    }
    let upper = c * freedom / ChiSquared::new(freedom).ok()?.inverse_cdf(LEVEL);
    (upper < 1.0 && c.sqrt() < MATTERS).then(|| c.sqrt())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_what_is_significantly_too_large_is_scaled() {
        // χ²_100 at 0.001: 61.9.
        assert_eq!(excess(0.63, 100.0), None);
        assert_eq!(excess(0.61, 100.0), Some(0.61f64.sqrt()));
        assert_eq!(excess(0.95, 1e5), None, "2.5 % of a standard deviation do not matter");
        assert_eq!(excess(0.1, 3.0), None);
    }
}
