//! The stiffness of a joint's drive and bearing: torsional, tilting and radial deflection.
//!
//! ```text
//! τ = k θ (1 + (θ/θ_h)²)          about or along the axis: the drive
//! φ_⊥ = M_⊥ / k_t                 across it: the bearing tilts     (a slide also rolls about its axis)
//! u_⊥ = F_⊥ / k_r                 across it: the bearing gives     (a turn also gives along its axis)
//! ```
//!
//! | symbol | here | unit | frame |
//! | --- | --- | --- | --- |
//! | k | `drive` | N·m/rad or N/m | about or along the axis |
//! | θ_h | `hardens_at` | rad or m | at this deflection the load is twice k θ |
//! | k_t, k_r | `tilt`, `radial` | N·m/rad, N/m | across the axis |
//!
//! Gear teeth, harmonic drives and ball bearings stiffen as more of their surface touches; the cubic is the first
//! term that is odd in the load. An infinite stiffness is a rigid joint.
//! Source: Spong, *Modeling and control of elastic joint robots* (1987); Tuttle, *Understanding and modeling
//! the behavior of a harmonic drive* (1992), chapter 4 for the cubic.

use nalgebra::{Unit, Vector3};
use truepose_kinematics::{JointKind, Wrench};

/// Stiffness of one joint.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct JointStiffness {
    /// About or along the axis, N·m/rad or N/m.
    pub drive: f64,
    /// Deflection of the drive at which its load is twice the linear one, rad or m.
    pub hardens_at: f64,
    /// Rotation across the axis, N·m/rad.
    pub tilt: f64,
    /// Translation across the axis, N/m.
    pub radial: f64,
}

impl Default for JointStiffness {
    /// A rigid joint.
    fn default() -> Self {
        JointStiffness {
            drive: f64::INFINITY,
            hardens_at: f64::INFINITY,
            tilt: f64::INFINITY,
            radial: f64::INFINITY,
        }
    }
}

impl JointStiffness {
    /// A linear drive in an otherwise rigid joint.
    pub fn drive(stiffness: f64) -> Self {
        JointStiffness { drive: stiffness, ..JointStiffness::default() }
    }

    /// Deflection of the drive under this load about or along its axis, rad or m.
    pub fn wind_up(&self, load: f64) -> f64 {
        let linear = load / self.drive;
        let ratio = (linear / self.hardens_at).abs();
        // θ (1 + (θ/θ_h)²) = linear; in x = θ/θ_h it is x³ + x = ratio, which has one real root (Cardano, in
        // the hyperbolic form that does not cancel).
        if ratio == 0.0 {
            return linear;
        }
        let x = 2.0 / 3f64.sqrt() * ((1.5 * 3f64.sqrt() * ratio).asinh() / 3.0).sinh();
        linear * (x / ratio)
    }

    /// Displacement `[tx ty tz rx ry rz]` under a wrench about the axis' point, both in the axis' frame.
    pub fn deflection(&self, kind: JointKind, axis: &Unit<Vector3<f64>>, wrench: &Wrench) -> [f64; 6] {
        let axis = axis.into_inner();
        let along = |v: &Vector3<f64>| axis * axis.dot(v);
        let (force, moment) = (&wrench.force, &wrench.moment);
        let (moved, turned) = match kind {
            JointKind::Fixed => return [0.0; 6],
            JointKind::Revolute => (
                force / self.radial,
                (moment - along(moment)) / self.tilt + axis * self.wind_up(axis.dot(moment)),
            ),
            JointKind::Prismatic => (
                (force - along(force)) / self.radial + axis * self.wind_up(axis.dot(force)),
                moment / self.tilt,
            ),
        };
        [moved.x, moved.y, moved.z, turned.x, turned.y, turned.z]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_wind_up_carries_the_load() {
        let joint = JointStiffness { hardens_at: 1e-3, ..JointStiffness::drive(2e6) };
        for load in [-9000.0, -1.0, 0.0, 1e-9, 300.0, 4000.0] {
            let theta = joint.wind_up(load);
            let carried = 2e6 * theta * (1.0 + (theta / 1e-3).powi(2));
            assert!((carried - load).abs() < 1e-12 * load.abs().max(1e-12), "{carried} against {load}");
        }
        // At θ_h the load is twice the linear one: k θ_h (1 + 1) = 4000 N·m.
        assert!((joint.wind_up(4000.0) - 1e-3).abs() < 1e-15);
        assert!((JointStiffness::drive(2e6).wind_up(4000.0) - 2e-3).abs() < 1e-18);
    }

    #[test]
    fn each_direction_has_its_stiffness() {
        let joint = JointStiffness { drive: 1e6, tilt: 4e6, radial: 2e8, ..JointStiffness::default() };
        let axis = Unit::new_normalize(Vector3::new(0.0, 0.0, -1.0));
        let wrench = Wrench { force: Vector3::new(0.0, 20.0, 40.0), moment: Vector3::new(8.0, 0.0, 5.0) };
        let turn = joint.deflection(JointKind::Revolute, &axis, &wrench);
        let slide = joint.deflection(JointKind::Prismatic, &axis, &wrench);
        let close = |a: [f64; 6], b: [f64; 6]| a.iter().zip(&b).all(|(a, b)| (a - b).abs() < 1e-18);
        assert!(close(turn, [0.0, 1e-7, 2e-7, 2e-6, 0.0, 5e-6]), "{turn:?}");
        assert!(close(slide, [0.0, 1e-7, 4e-5, 2e-6, 0.0, 1.25e-6]), "{slide:?}");
        assert_eq!(
            JointStiffness::default().deflection(JointKind::Revolute, &axis, &wrench).to_vec(),
            [0.0; 6]
        );
    }
}
