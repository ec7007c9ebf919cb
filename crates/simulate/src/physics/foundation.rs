//! The elastic foundation of the robot: it sinks and tilts under load.
//!
//! ```text
//! u = F / k_u       φ = M / k_φ        for each of x, y, z of the base
//! ```
//!
//! | symbol | here | unit | frame |
//! | --- | --- | --- | --- |
//! | k_u | `sink` | N/m | base (frame 0) |
//! | k_φ | `tilt` | N·m/rad | base (frame 0) |
//!
//! The wrench is that of everything above the base at the *deflected* posture, about the base's origin.
//! Source: a rigid plate on elastic supports, e.g. Richart, Hall and Woods, *Vibrations of Soils and Foundations*, table 10-13.

use truepose_kinematics::Wrench;

/// Stiffness of the foundation.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Foundation {
    /// Translation, N/m.
    pub sink: [f64; 3],
    /// Rotation, N·m/rad.
    pub tilt: [f64; 3],
}

impl Default for Foundation {
    /// Rock.
    fn default() -> Self {
        Foundation { sink: [f64::INFINITY; 3], tilt: [f64::INFINITY; 3] }
    }
}

impl Foundation {
    /// Displacement `[tx ty tz rx ry rz]` under a wrench about the base's origin, both in the base's axes.
    pub fn settling(&self, wrench: &Wrench) -> [f64; 6] {
        std::array::from_fn(|k| wrench.component(k) / if k < 3 { self.sink[k] } else { self.tilt[k - 3] })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Vector3;

    #[test]
    fn it_sinks_and_tilts_by_its_stiffness() {
        let floor = Foundation { sink: [1e8, 1e8, 2e8], tilt: [1e6, 2e6, f64::INFINITY] };
        let wrench = Wrench { force: Vector3::new(0.0, 0.0, -2e4), moment: Vector3::new(1e3, -1e3, 1e3) };
        let by = floor.settling(&wrench);
        let expected = [0.0, 0.0, -1e-4, 1e-3, -5e-4, 0.0];
        assert!(by.iter().zip(&expected).all(|(a, b)| (a - b).abs() < 1e-18), "{by:?}");
    }
}
