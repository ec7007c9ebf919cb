//! Compliance: joints, links and the foundation.

use super::{Draft, Install};
use crate::SimulateError;
use crate::physics::beam::Beam;
use crate::physics::foundation::Foundation;
use crate::physics::joint_stiffness::JointStiffness;
use crate::truth::span;
use nalgebra::Vector3;
use rand_chacha::ChaCha8Rng;
use serde::{Deserialize, Serialize};

/// A compliant joint. What is left out is rigid.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct JointCompliance {
    /// The joint.
    pub joint: String,
    /// Of the drive: N·m/rad for a turn, N/m for a slide.
    pub stiffness: Option<f64>,
    /// Deflection at which the load of the drive is twice the linear one: mrad for a revolute joint.
    pub hardens_at_mrad: Option<f64>,
    /// The same for a slide, mm.
    pub hardens_at_mm: Option<f64>,
    /// Of the bearing against tilting, N·m/rad.
    pub tilt_stiffness: Option<f64>,
    /// Of the bearing sideways, N/m.
    pub radial_stiffness: Option<f64>,
}

/// A link as a beam. Root and tip are the joint's axis and the next one's where they are left out.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct LinkCompliance {
    /// The joint in front of the link.
    pub joint: String,
    /// Bending stiffness EI about the section's y and z, N·m².
    pub bending_nm2: [f64; 2],
    /// Torsional stiffness GJ, N·m².
    pub torsion_nm2: f64,
    /// Axial stiffness EA, N; left out: it does not stretch.
    pub axial_n: Option<f64>,
    /// Shear stiffness κGA, N; left out: Euler–Bernoulli.
    pub shear_n: Option<f64>,
    /// A direction that the section's y leans towards, in the link's axes; left out: any (for a round section).
    pub section_y: Option<[f64; 3]>,
    /// Where it is clamped, in the frame after the joint, mm.
    pub root_mm: Option<[f64; 3]>,
    /// Where it ends, in the frame after the joint, mm.
    pub tip_mm: Option<[f64; 3]>,
}

/// A compliant foundation. What is left out is rigid.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct BaseCompliance {
    /// Against tilting about x, y, z of the base, N·m/rad.
    pub tilt_stiffness: Option<[f64; 3]>,
    /// Against sinking along x, y, z of the base, N/m.
    pub sink_stiffness: Option<[f64; 3]>,
}

impl Install for JointCompliance {
    fn install(&self, draft: &mut Draft<'_>, rng: &mut ChaCha8Rng) -> Result<(), SimulateError> {
        let joint = draft.moving(&self.joint, "a joint's compliance")?;
        let mut spring = |given: Option<f64>| match given {
            Some(value) => draft.stiffness(value, rng),
            None => Ok(f64::INFINITY),
        };
        let drive = spring(self.stiffness)?;
        let tilt = spring(self.tilt_stiffness)?;
        let radial = spring(self.radial_stiffness)?;
        let hardens_at = match (self.hardens_at_mrad, self.hardens_at_mm) {
            (None, None) => f64::INFINITY,
            given => draft.in_joint_units(&self.joint, given, "a hardening")?.1,
        };
        if hardens_at.is_nan() || hardens_at <= 0.0 {
            return Err(SimulateError::Size { what: "hardens_at", value: hardens_at, need: "positive" });
        }
        draft.truth.joints[joint.index()].stiffness = JointStiffness { drive, hardens_at, tilt, radial };
        Ok(())
    }
}

impl Install for LinkCompliance {
    fn install(&self, draft: &mut Draft<'_>, rng: &mut ChaCha8Rng) -> Result<(), SimulateError> {
        let joint = draft.joint(&self.joint)?;
        let (root, tip) = span(draft.chain, joint);
        let point = |given: Option<[f64; 3]>, usual| given.map_or(usual, |mm| Vector3::from(mm) * 1e-3);
        let factor = draft.stiffness(1.0, rng)?;
        let round = Beam::slender(point(self.root_mm, root), point(self.tip_mm, tip), 1.0, 1.0)?;
        let beam = Beam {
            bending: self.bending_nm2.map(|v| v * factor),
            torsion: self.torsion_nm2 * factor,
            axial: self.axial_n.map_or(f64::INFINITY, |v| v * factor),
            shear: self.shear_n.map_or(f64::INFINITY, |v| v * factor),
            section_y: self.section_y.map_or(round.section_y, Vector3::from),
            ..round
        };
        draft.truth.joints[joint.index()].beam = Some(beam.checked()?);
        Ok(())
    }
}

impl Install for BaseCompliance {
    fn install(&self, draft: &mut Draft<'_>, rng: &mut ChaCha8Rng) -> Result<(), SimulateError> {
        let mut springs = |given: Option<[f64; 3]>| -> Result<[f64; 3], SimulateError> {
            let mut springs = [f64::INFINITY; 3];
            for (spring, value) in springs.iter_mut().zip(given.iter().flatten()) {
                *spring = draft.stiffness(*value, rng)?;
            }
            Ok(springs)
        };
        let tilt = springs(self.tilt_stiffness)?;
        let sink = springs(self.sink_stiffness)?;
        draft.truth.foundation = Foundation { sink, tilt };
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::super::Flaws;
    use super::*;
    use crate::physics::temperature::Shop;
    use truepose_kinematics::samples;

    #[test]
    fn stiffnesses_arrive_with_their_scatter() {
        let chain = samples::heavy();
        let flaws = |scatter| Flaws {
            stiffness_scatter: scatter,
            joint_compliance: vec![JointCompliance {
                joint: "a2".into(),
                stiffness: Some(3e6),
                hardens_at_mrad: Some(2.0),
                ..JointCompliance::default()
            }],
            link_compliance: vec![LinkCompliance {
                joint: "a2".into(),
                bending_nm2: [5e6; 2],
                torsion_nm2: 4e6,
                ..LinkCompliance::default()
            }],
            base_compliance: Some(BaseCompliance {
                tilt_stiffness: Some([1e7; 3]),
                ..BaseCompliance::default()
            }),
            ..Flaws::default()
        };
        let shop = Shop::steady(20.0).expect("a shop");
        let (exact, _) = flaws(0.0).on(&chain, &shop, 1).expect("a truth");
        assert_eq!(
            exact.joints[1].stiffness,
            JointStiffness { drive: 3e6, hardens_at: 2e-3, ..JointStiffness::default() }
        );
        let beam = exact.joints[1].beam.as_ref().expect("a beam");
        assert!((beam.length() - 1.1).abs() < 1e-15);
        assert_eq!(exact.foundation.tilt.to_vec(), [1e7; 3]);
        let (scattered, _) = flaws(0.2).on(&chain, &shop, 1).expect("a truth");
        let ratio = scattered.joints[1].stiffness.drive / 3e6;
        assert!((ratio - 1.0).abs() > 1e-6 && (0.4..2.5).contains(&ratio), "{ratio}");
    }
}
