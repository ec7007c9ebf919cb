//! Mountings that do not deflect in proportion: a preloaded bearing, and a bolted flange that lifts off.
//!
//! ```text
//! bearing    φ = φ_0 u / (1 + u²)^(1/6)          u = |m|/M_0,  across the axis, (1, s) along two directions
//! flange     φ = m/k                              |m| ≤ M_s
//!            φ = (m/|m|) (M_s/k + (|m| − M_s)/(r k))    beyond: part of the joint has lifted
//! ```
//!
//! | symbol | here | unit | frame |
//! | --- | --- | --- | --- |
//! | m | moment across the axis (bearing), whole moment (flange) | N·m | that of the mounting |
//! | φ_0, M_0 | `angle`, `preload` | rad, N·m | |
//! | s | `ratio`: compliance along `soft` over that square to it | 1 | |
//! | k, M_s, r | `stiffness`, `separation`, `remaining` | N·m/rad, N·m, 1 | |
//!
//! A bearing under preload is linear for small moments; where the preload is gone balls follow Hertz, and the angle grows
//! as m^(2/3). Sources: Harris and Kotzalas, *Rolling Bearing Analysis*, chapter 9 (moment load, point contact); VDI 2230
//! sheet 2 (bolted joints: stiffness falls when the interface opens).

use nalgebra::{Unit, Vector3};

/// A preloaded bearing that tilts under moments across its axis, more in one direction than in the other.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TiltingBearing {
    /// Scale of the angle, rad.
    pub angle: f64,
    /// Moment at which the preload is gone, N·m.
    pub preload: f64,
    /// A direction in which the tilt is `ratio` times as large; its part along the axis is taken out.
    pub soft: Vector3<f64>,
    /// 1: as compliant in all directions.
    pub ratio: f64,
}

impl TiltingBearing {
    /// Rotation vector of the tilt under this moment (N·m), rad, both in the joint's frame.
    pub fn tilt(&self, axis: &Unit<Vector3<f64>>, moment: &Vector3<f64>) -> Vector3<f64> {
        let across = moment - axis.into_inner() * axis.dot(moment);
        let size = across.norm();
        if size == 0.0 {
            return Vector3::zeros();
        }
        let u = size / self.preload;
        let turned = across * (self.angle * u / (1.0 + u * u).powf(1.0 / 6.0) / size);
        let soft = self.soft - axis.into_inner() * axis.dot(&self.soft);
        match Unit::try_new(soft, 1e-9) {
            Some(soft) => turned + soft.into_inner() * soft.dot(&turned) * (self.ratio - 1.0),
            None => turned,
        }
    }
}

/// A bolted flange, or a base plate on anchors.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LiftingFlange {
    /// Before it lifts, N·m/rad; infinite is rigid.
    pub stiffness: f64,
    /// Moment at which it begins to lift, N·m.
    pub separation: f64,
    /// Fraction of the stiffness that remains beyond.
    pub remaining: f64,
}

impl LiftingFlange {
    /// Rotation vector under this moment (N·m), rad.
    pub fn tilt(&self, moment: &Vector3<f64>) -> Vector3<f64> {
        let size = moment.norm();
        if size <= self.separation {
            return moment / self.stiffness;
        }
        let angle = (self.separation + (size - self.separation) / self.remaining) / self.stiffness;
        moment * (angle / size)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_bearing_is_linear_at_first_and_then_follows_hertz() {
        let bearing = TiltingBearing { angle: 1e-4, preload: 100.0, soft: Vector3::x(), ratio: 1.0 };
        let axis = Vector3::z_axis();
        let at = |m: f64| bearing.tilt(&axis, &Vector3::new(0.0, m, 55.0)).y;
        assert!((at(2.0) / at(1.0) - 2.0).abs() < 1e-3);
        assert!((at(2e6) / at(1e6) - 2f64.powf(2.0 / 3.0)).abs() < 1e-3);
        assert_eq!(bearing.tilt(&axis, &Vector3::new(0.0, 0.0, 40.0)), Vector3::zeros());
    }

    #[test]
    fn a_bearing_tilts_more_in_its_soft_direction() {
        let bearing =
            TiltingBearing { angle: 1e-4, preload: 100.0, soft: Vector3::new(1.0, 0.0, 9.0), ratio: 3.0 };
        let axis = Vector3::z_axis();
        let x = bearing.tilt(&axis, &Vector3::new(80.0, 0.0, 0.0));
        let y = bearing.tilt(&axis, &Vector3::new(0.0, 80.0, 0.0));
        assert!((x.x / y.y - 3.0).abs() < 1e-12 && x.z == 0.0 && y.x == 0.0);
    }

    #[test]
    fn a_flange_that_lifts_is_continuous_and_softer() {
        let flange = LiftingFlange { stiffness: 1e6, separation: 500.0, remaining: 0.25 };
        let at = |m: f64| flange.tilt(&Vector3::new(m, 0.0, 0.0)).x;
        assert!((at(400.0) - 4e-4).abs() < 1e-18);
        assert!((at(500.0 + 1e-9) - at(500.0)).abs() < 1e-12);
        let slope = at(701.0) - at(700.0);
        assert!((slope / 1e-6 - 4.0).abs() < 1e-9, "{slope}");
        assert!((at(-700.0) + at(700.0)).abs() < 1e-18);
    }
}
