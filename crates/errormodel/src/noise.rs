//! Standard deviations of a measurement.
//!
//! | symbol | here | unit |
//! | --- | --- | --- |
//! | τ | `position_sd`, of each row by itself | m |
//! | ρ | `visit_sd`, which the rows of one visit share | m |
//! | ω | `orientation_sd`, of each row by itself | rad |

use serde::{Deserialize, Serialize};

/// Standard deviations of one component of one row.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct NoiseModel {
    /// τ, m.
    pub position_sd: f64,
    /// ρ, m.
    pub visit_sd: f64,
    /// ω, rad.
    pub orientation_sd: f64,
}

impl Default for NoiseModel {
    /// A tenth of a millimetre, and what that is in angle at a third of a metre: a start, replaced by estimates.
    fn default() -> Self {
        NoiseModel { position_sd: 1e-4, visit_sd: 0.0, orientation_sd: 3e-4 }
    }
}

/// No deviation is taken to be smaller than this (m or rad): nothing is measured to a picometre.
pub const SMALLEST_SD: f64 = 1e-12;

impl NoiseModel {
    /// No noise at all.
    pub fn none() -> Self {
        NoiseModel { position_sd: 0.0, visit_sd: 0.0, orientation_sd: 0.0 }
    }

    /// σ of a position's component, given what the instrument states (NaN: nothing).
    pub fn position(&self, stated: f64) -> f64 {
        combine(self.position_sd, stated)
    }

    /// σ of an orientation's component, given what the instrument states (NaN: nothing).
    pub fn orientation(&self, stated: f64) -> f64 {
        combine(self.orientation_sd, stated)
    }

    /// Expected 3-D RMS of one new row around a perfect model, m, for an instrument that states `stated`.
    pub fn floor(&self, stated: f64) -> f64 {
        (3.0 * (self.position(stated).powi(2) + self.visit_sd.powi(2))).sqrt()
    }
}

fn combine(own: f64, stated: f64) -> f64 {
    let stated = if stated.is_nan() { 0.0 } else { stated };
    own.hypot(stated).max(SMALLEST_SD)
}
