//! Hidden effects of a robot: undeclared errors, by the plant's physics or of no named family.

use super::makes::Make;
use super::unnamed::Unnamed;
use crate::prelude::*;
use truepose_simulate::flaws::{Drift, JointCompliance, LeadScrew, Mislabelled, Shift, Thermal};

/// Kinds of what is hidden.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
#[value(rename_all = "snake_case")]
pub enum Hidden {
    Nothing,
    /// An eccentric wheel in two joints.
    Gear,
    /// Teeth.
    Mesh,
    /// Joint compliance.
    Compliance,
    /// Play.
    Backlash,
    /// Links or slides grow.
    Thermal,
    /// The instrument's stand or the tool creeps, or is bumped.
    Drift,
    /// Joint compliance, and a wrong payload.
    Payload,
    /// Transmission error, compliance, backlash and thermal error.
    Several,
    /// A smooth error over the joint space that is nothing.
    Nonsense,
    /// Friction with a memory.
    Hysteresis,
    /// The instrument wanders, and the joints come back badly.
    Wander,
}

/// In turn; a robot in six hides nothing.
pub const HIDDEN: [Hidden; 13] = {
    use Hidden::*;
    [
        Nothing, Gear, Compliance, Nonsense, Backlash, Nothing, Thermal, Hysteresis, Several, Drift, Wander,
        Payload, Mesh,
    ]
};

impl Hidden {
    /// Whether it takes different payloads to be seen.
    pub fn needs_loads(self) -> bool {
        self == Hidden::Payload
    }

    /// What of it the plant's physics has. `seconds` is the length of the campaign, `masses` are the payloads as declared.
    pub fn install(
        self,
        flaws: &mut Flaws,
        (chain, make): (&Chain, Make),
        (seconds, masses): (f64, &[f64]),
        draw: &mut Draw,
    ) {
        let all: Vec<String> = chain.movable().iter().map(|&joint| chain.joint(joint).name.clone()).collect();
        let turns: Vec<&String> = (chain.movable().iter().zip(&all))
            .filter(|(joint, _)| chain.joint(**joint).kind == JointKind::Revolute)
            .map(|(_, name)| name)
            .collect();
        match self {
            Hidden::Gear | Hidden::Mesh => {
                for k in draw.some(2, all.len()) {
                    periodic(flaws, &all[k], turns.contains(&&all[k]), self == Hidden::Mesh, draw);
                }
            }
            Hidden::Compliance => compliance(flaws, chain, make, draw),
            Hidden::Backlash => {
                for k in draw.some(2, turns.len()) {
                    flaws.backlash.push(backlash(turns[k].clone(), false, draw.logarithmic(0.15, 1.0)));
                }
            }
            Hidden::Thermal => thermal(flaws, &all, seconds, draw),
            Hidden::Drift => {
                let at = if draw.chance(0.5) { "base" } else { "tool" };
                let (size_mm, size_mrad) = (draw.logarithmic(0.05, 0.5), draw.logarithmic(0.02, 0.2));
                let when_s = seconds * draw.between(0.2, 0.8);
                if draw.chance(0.5) {
                    flaws.drift.push(Drift { at: at.into(), size_mm, size_mrad, correlation_s: 0.0 });
                } else {
                    flaws.shift.push(Shift { at: at.into(), when_s, size_mm, size_mrad });
                }
            }
            Hidden::Payload => {
                compliance(flaws, chain, make, draw);
                let declared_kg = masses.last().copied().unwrap_or(0.0);
                let true_kg = declared_kg * draw.between(0.4, 0.8);
                flaws.payload.push(Mislabelled { declared_kg, true_kg });
            }
            Hidden::Several => {
                for hidden in [Hidden::Gear, Hidden::Compliance, Hidden::Backlash, Hidden::Thermal] {
                    hidden.install(flaws, (chain, make), (seconds, masses), draw);
                }
            }
            Hidden::Nothing | Hidden::Nonsense | Hidden::Hysteresis | Hidden::Wander => {}
        }
    }

    /// What of it has no word.
    pub fn unnamed(self, chain: &Chain, noise: f64, draw: &mut Draw) -> Unnamed {
        let none = Unnamed::of(chain);
        match self {
            Hidden::Nonsense => {
                let size = draw.logarithmic(0.05, 0.5);
                none.with_nonsense(size, draw)
            }
            Hidden::Hysteresis => none.with_hysteresis(draw.logarithmic(0.1, 0.6)),
            Hidden::Wander => {
                let (size, rows) = (noise * draw.between(1.0, 3.0), draw.between(8.0, 60.0));
                none.with_wander(size, rows).with_scatter(draw.logarithmic(0.01, 0.1))
            }
            _ => none,
        }
    }
}

fn periodic(flaws: &mut Flaws, joint: &str, turn: bool, mesh: bool, draw: &mut Draw) {
    let mrad = if mesh { draw.logarithmic(0.05, 0.4) } else { draw.logarithmic(0.1, 0.8) };
    let cycles = draw.logarithmic(15.0, 120.0).round();
    if turn {
        flaws.transmission.push(gear(joint.into(), mrad, mesh.then_some(cycles)));
    } else {
        let lead_mm = if mesh { 10.0 } else { 150.0 };
        flaws.lead_screw.push(LeadScrew { joint: joint.into(), lead_mm, amplitude_um: 200.0 * mrad });
    }
}

/// Every joint deflects by up to some tenths of a milliradian (a prismatic joint: tenths of a millimetre) under the weight of such a robot.
fn compliance(flaws: &mut Flaws, chain: &Chain, make: Make, draw: &mut Draw) {
    let class = make.class();
    let force = 9.81 * (0.5 * class.weight + class.payload);
    for &joint in chain.movable() {
        let described = chain.joint(joint);
        let milli = draw.logarithmic(0.1, 1.5);
        let turn = described.kind == JointKind::Revolute;
        let stiffness =
            if turn { force * 0.4 * class.reach / (1e-3 * milli) } else { force / (2e-4 * milli) };
        flaws.joint_compliance.push(JointCompliance {
            joint: described.name.clone(),
            stiffness: Some(stiffness),
            tilt_stiffness: draw.chance(0.5).then_some(5.0 * force * 0.4 * class.reach / (1e-3 * milli)),
            hardens_at_mrad: (turn && draw.chance(0.3)).then_some(3.0 * milli),
            ..JointCompliance::default()
        });
    }
}

fn thermal(flaws: &mut Flaws, all: &[String], seconds: f64, draw: &mut Draw) {
    use truepose_simulate::flaws::Growing;
    for k in draw.some(2, all.len()) {
        let (grows, per_kelvin) =
            if draw.chance(0.6) { (Growing::Length, 20.0) } else { (Growing::Motion, 15.0) };
        let lag_s = if draw.chance(0.5) { seconds * draw.between(0.05, 0.3) } else { 0.0 };
        flaws.thermal.push(Thermal { at: all[k].clone(), grows, per_kelvin, lag_s });
    }
}
