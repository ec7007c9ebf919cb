//! Errors of joint motion: guideways, lead screws, transmission errors, backlash and coupling.

use super::{Draft, Install};
use crate::SimulateError;
use crate::physics::backlash::{DeadBand, Side};
use crate::physics::coupling::Coupling;
use crate::physics::guideway::GuidewayProfile;
use crate::physics::transmission::TransmissionError;
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use serde::{Deserialize, Serialize};
use std::f64::consts::TAU;
use truepose_kinematics::JointKind;

/// Errors of a linear guideway: root mean squares over its travel.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Guideway {
    /// The slide.
    pub joint: String,
    /// Of x, y, z in the axis' frame, µm (along the axis it is a positioning error).
    pub xyz_um: [f64; 3],
    /// Of rx, ry, rz, µrad.
    pub turn_urad: [f64; 3],
    /// Correlation length, mm; zero: a third of the travel.
    pub correlation_mm: f64,
}

/// A slide with a screw whose thread is not even.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct LeadScrew {
    /// The slide.
    pub joint: String,
    /// Travel a turn of the screw, mm.
    pub lead_mm: f64,
    /// µm.
    pub amplitude_um: f64,
}

/// Which part of a transmission errs.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Wheel {
    /// A wheel or an encoder disc beside its axis: once a turn, with all that geometry adds.
    #[default]
    Eccentric,
    /// Teeth or waves: many times a turn, not quite a sine.
    Mesh,
}

/// A periodic error of a turn.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Transmission {
    /// The joint, a turn.
    pub joint: String,
    /// What errs.
    pub wheel: Wheel,
    /// Amplitude, mrad.
    pub amplitude_mrad: f64,
    /// Periods a turn of the joint; of a mesh only.
    pub cycles: Option<f64>,
    /// Where it begins, degrees; left out: drawn.
    pub phase_deg: Option<f64>,
}

/// What determines the flank of a joint with backlash.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum BacklashSide {
    /// The direction of the last move.
    #[default]
    Approach,
    /// The load about or along the axis.
    Load,
    /// The load where it is heavy enough, else the last move.
    LoadThenApproach,
}

/// Backlash of a joint.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Backlash {
    /// The joint.
    pub joint: String,
    /// The whole dead band of a turn, mrad.
    pub width_mrad: Option<f64>,
    /// The whole dead band of a slide, mm.
    pub width_mm: Option<f64>,
    /// What decides the side.
    pub side: BacklashSide,
    /// Load that presses the joint against its flank, N·m or N; not needed where the approach decides.
    pub flank_load: Option<f64>,
}

/// A joint that another one drags along.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Dragging {
    /// The joint that is dragged.
    pub joint: String,
    /// The joint that drags.
    pub driver: String,
    /// Thousandths of a unit (rad or m) of this joint for each unit of the driving one.
    pub ratio_milli: f64,
    /// Eccentricity of the wheel that drags, mrad; of a driving turn only.
    pub eccentricity_mrad: f64,
}

impl Install for Guideway {
    fn install(&self, draft: &mut Draft<'_>, rng: &mut ChaCha8Rng) -> Result<(), SimulateError> {
        let joint = draft.joint_of(&self.joint, JointKind::Prismatic, "a guideway")?;
        let (lower, upper) = draft.range(joint)?;
        let correlation =
            if self.correlation_mm > 0.0 { 1e-3 * self.correlation_mm } else { (upper - lower) / 3.0 };
        let rms = std::array::from_fn(|k| 1e-6 * if k < 3 { self.xyz_um[k] } else { self.turn_urad[k - 3] });
        draft.truth.joints[joint.index()].guideway =
            Some(GuidewayProfile::draw((lower, upper), correlation, rms, rng)?);
        Ok(())
    }
}

impl Install for LeadScrew {
    fn install(&self, draft: &mut Draft<'_>, rng: &mut ChaCha8Rng) -> Result<(), SimulateError> {
        let joint = draft.joint_of(&self.joint, JointKind::Prismatic, "a lead screw")?;
        if self.lead_mm.is_nan() || self.lead_mm <= 0.0 {
            return Err(SimulateError::Size { what: "a lead", value: self.lead_mm, need: "positive" });
        }
        let gear =
            TransmissionError::mesh(1e-6 * self.amplitude_um, 1e3 / self.lead_mm, TAU * rng.random::<f64>());
        draft.truth.joints[joint.index()].transmission.push(gear);
        Ok(())
    }
}

impl Install for Transmission {
    fn install(&self, draft: &mut Draft<'_>, rng: &mut ChaCha8Rng) -> Result<(), SimulateError> {
        let joint = draft.joint_of(&self.joint, JointKind::Revolute, "a transmission error")?;
        let drawn = TAU * rng.random::<f64>();
        let phase = self.phase_deg.map_or(drawn, f64::to_radians);
        let amplitude = 1e-3 * self.amplitude_mrad;
        let gear = match self.wheel {
            Wheel::Eccentric => TransmissionError::Eccentric { ratio: amplitude.sin(), phase },
            Wheel::Mesh => {
                let cycles = self.cycles.unwrap_or(f64::NAN);
                if cycles.is_nan() || cycles <= 0.0 {
                    let what = "the periods a turn of a mesh";
                    return Err(SimulateError::Size { what, value: cycles, need: "positive" });
                }
                TransmissionError::mesh(amplitude, cycles, phase)
            }
        };
        draft.truth.joints[joint.index()].transmission.push(gear);
        Ok(())
    }
}

impl Install for Backlash {
    fn install(&self, draft: &mut Draft<'_>, _: &mut ChaCha8Rng) -> Result<(), SimulateError> {
        let (joint, width) =
            draft.in_joint_units(&self.joint, (self.width_mrad, self.width_mm), "a dead band")?;
        let flank_load = self.flank_load.unwrap_or(f64::NAN);
        if self.side != BacklashSide::Approach && (flank_load.is_nan() || flank_load <= 0.0) {
            return Err(SimulateError::Size { what: "flank_load", value: flank_load, need: "positive" });
        }
        let side = match self.side {
            BacklashSide::Approach => Side::Approach,
            BacklashSide::Load => Side::Load { flank_load },
            BacklashSide::LoadThenApproach => Side::LoadThenApproach { flank_load },
        };
        draft.truth.joints[joint.index()].backlash = Some(DeadBand { width, side });
        Ok(())
    }
}

impl Install for Dragging {
    fn install(&self, draft: &mut Draft<'_>, rng: &mut ChaCha8Rng) -> Result<(), SimulateError> {
        let joint = draft.moving(&self.joint, "a coupling")?;
        let driver = draft.moving(&self.driver, "a coupling")?;
        draft.truth.joints[joint.index()].couplings.push(Coupling {
            driver: driver.index(),
            ratio: 1e-3 * self.ratio_milli,
            eccentricity: (1e-3 * self.eccentricity_mrad).sin(),
            phase: TAU * rng.random::<f64>(),
        });
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
    fn sizes_arrive_in_metres_and_radians() {
        let chain = samples::scara();
        let flaws = Flaws {
            guideway: vec![Guideway {
                joint: "slide".into(),
                xyz_um: [10.0, 0.0, 0.0],
                ..Guideway::default()
            }],
            lead_screw: vec![LeadScrew { joint: "slide".into(), lead_mm: 10.0, amplitude_um: 4.0 }],
            transmission: vec![Transmission {
                joint: "r2".into(),
                amplitude_mrad: 0.3,
                phase_deg: Some(90.0),
                ..Transmission::default()
            }],
            coupling: vec![Dragging {
                joint: "r4".into(),
                driver: "r2".into(),
                ratio_milli: 0.5,
                ..Dragging::default()
            }],
            ..Flaws::default()
        };
        let (truth, _) = flaws.on(&chain, &Shop::steady(20.0).expect("a shop"), 3).expect("a truth");
        let peak = |joint: usize, kind| {
            (0..6000)
                .map(|k| truth.joints[joint].transmission[0].error(kind, 1e-3 * f64::from(k)))
                .fold(0.0, f64::max)
        };
        assert!((peak(1, JointKind::Revolute) - 3e-4).abs() < 1e-9);
        assert!((peak(2, JointKind::Prismatic) - 4e-6).abs() < 0.5e-6);
        assert!(truth.joints[2].guideway.as_ref().is_some_and(|rail| rail.displacement(0.1)[0].abs() < 5e-5));
        assert!((truth.joints[3].couplings[0].error(JointKind::Revolute, 1.0) - 5e-4).abs() < 1e-12);
    }

    #[test]
    fn a_guideway_of_a_revolute_joint_is_rejected() {
        let flaws = Flaws {
            guideway: vec![Guideway { joint: "r1".into(), ..Guideway::default() }],
            ..Flaws::default()
        };
        let refused = flaws.on(&samples::scara(), &Shop::steady(20.0).expect("a shop"), 3);
        assert!(matches!(refused, Err(SimulateError::JointKind { .. })));
    }
}
