//! A guideway that is not straight: the carriage is displaced and turned as it travels.
//!
//! ```text
//! carriage(q) = axis · q · exp( [x(q) y(q) z(q) rx(q) ry(q) rz(q)] )
//! ```
//!
//! | symbol | here | unit | frame |
//! | --- | --- | --- | --- |
//! | x y z | straightness; along the axis, positioning | m | that of the axis, on the carriage |
//! | rx ry rz | pitch, yaw and roll | rad | that of the axis, on the carriage |
//!
//! Each of the six is a [`SmoothCurve`] over the travel. The displacement of a point far from the guideway follows from the rotation
//! of the carriage (Abbe); there is no separate term. Source: Slocum, *Precision Machine Design*, section 2.3.

use super::curve::{Centred, SmoothCurve};
use crate::SimulateError;
use rand::Rng;

/// The error curves of one guideway; none stands for a perfect component.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct GuidewayProfile {
    /// x, y, z (m), rx, ry, rz (rad) over the travel (m).
    pub curves: [Option<SmoothCurve>; 6],
}

impl GuidewayProfile {
    /// A random guideway: root mean squares of the six components, m and rad, and one correlation length, m.
    ///
    /// Mean and slope of each curve are taken out: they are the position, the direction and the scale of the guideway.
    ///
    /// # Errors
    /// Those of [`SmoothCurve::draw`].
    pub fn draw(
        travel: (f64, f64),
        correlation: f64,
        rms: [f64; 6],
        rng: &mut impl Rng,
    ) -> Result<Self, SimulateError> {
        let mut rail = GuidewayProfile::default();
        for (curve, size) in rail.curves.iter_mut().zip(rms) {
            if size > 0.0 {
                *curve = Some(SmoothCurve::draw(travel, correlation, size, Centred::MeanAndSlope, rng)?);
            }
        }
        Ok(rail)
    }

    /// Displacement of the carriage at this travel, `[tx ty tz rx ry rz]`.
    pub fn displacement(&self, q: f64) -> [f64; 6] {
        std::array::from_fn(|k| self.curves[k].as_ref().map_or(0.0, |curve| curve.value(q)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;

    #[test]
    fn only_what_was_asked_for_moves() {
        let mut rng = ChaCha8Rng::seed_from_u64(5);
        let rail = GuidewayProfile::draw((0.0, 2.0), 0.4, [0.0, 2e-5, 0.0, 1e-5, 0.0, 0.0], &mut rng)
            .expect("a rail");
        let at = rail.displacement(0.9);
        assert!(at[1] != 0.0 && at[3] != 0.0);
        assert_eq!(vec![at[0], at[2], at[4], at[5]], [0.0; 4]);
        let square: f64 = (0..=200).map(|k| rail.displacement(0.01 * f64::from(k))[1].powi(2)).sum();
        assert!(((square / 201.0).sqrt() / 2e-5 - 1.0).abs() < 0.05);
    }
}
