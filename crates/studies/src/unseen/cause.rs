//! What may be missing in a declared model, each by its own physics, with the names that are right for it.
//!
//! *Inside* means that the vocabulary has a family for it; the physics is never that of the family's formula. *Outside* has
//! no word of its own (yet): the names listed for it are those that would send a mechanic to the right place.

use super::pieces::{Piece, pieces};
use super::robots::Robot;
use super::stream::Draw;
use std::error::Error;
use truepose_kinematics::nalgebra::Vector3;
use truepose_kinematics::{JointId, JointKind};
use truepose_simulate::physics::changes::{Amount, Change, Mover};
use truepose_simulate::physics::mounting::{LiftingFlange, TiltingBearing};
use truepose_simulate::physics::presliding::Presliding;
use truepose_simulate::physics::warming::WarmUp;
use truepose_simulate::physics::wave::{LoadedWaves, Wave};
use truepose_simulate::{Disturbances, StationMotion, Truth};

/// A cause.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Cause {
    JointCompliance,
    LinkBending,
    BaseTilt,
    Backlash,
    Eccentric,
    Mesh,
    Coupling,
    Shift,
    Dahl,
    MaxwellSlip,
    Bearing,
    Waves,
    BasePlate,
    Flange,
    WarmUp,
    Station,
    Masses,
    Creep,
    Heating,
    Pauses,
    Gradient,
    WholeArm,
    Lubricant,
    TwoConstants,
    Undone,
    Settles,
    TiltingBearing,
    Refraction,
    Sight,
    Bridge,
    Ram,
    Wear,
    FourBar,
    Label,
    Spring,
    /// All the usual ones at once.
    Everything,
}

/// Causes that the vocabulary has a family for.
pub const INSIDE: [Cause; 8] = [
    Cause::JointCompliance,
    Cause::LinkBending,
    Cause::BaseTilt,
    Cause::Backlash,
    Cause::Eccentric,
    Cause::Mesh,
    Cause::Coupling,
    Cause::Shift,
];

/// Causes for which the vocabulary has a word that is no formula of the plant, in its order.
pub const WORDS: [Cause; 18] = [
    Cause::Creep,
    Cause::Heating,
    Cause::Pauses,
    Cause::Gradient,
    Cause::WholeArm,
    Cause::Lubricant,
    Cause::TwoConstants,
    Cause::Undone,
    Cause::Settles,
    Cause::TiltingBearing,
    Cause::Refraction,
    Cause::Sight,
    Cause::Bridge,
    Cause::Ram,
    Cause::Wear,
    Cause::FourBar,
    Cause::Label,
    Cause::Spring,
];

/// Causes without a word of their own.
pub const OUTSIDE: [Cause; 9] = [
    Cause::Dahl,
    Cause::MaxwellSlip,
    Cause::Bearing,
    Cause::Waves,
    Cause::BasePlate,
    Cause::Flange,
    Cause::WarmUp,
    Cause::Station,
    Cause::Masses,
];

impl Cause {
    pub fn word(self) -> &'static str {
        match self {
            Cause::JointCompliance => "joint_compliance",
            Cause::LinkBending => "link_bending",
            Cause::BaseTilt => "base_tilt",
            Cause::Backlash => "backlash",
            Cause::Eccentric => "eccentric",
            Cause::Mesh => "mesh",
            Cause::Coupling => "coupling",
            Cause::Shift => "shift",
            Cause::Dahl => "dahl",
            Cause::MaxwellSlip => "maxwell_slip",
            Cause::Bearing => "bearing",
            Cause::Waves => "waves",
            Cause::BasePlate => "base_plate",
            Cause::Flange => "flange",
            Cause::WarmUp => "warm_up",
            Cause::Station => "station",
            Cause::Masses => "masses",
            Cause::Everything => "everything",
            other => other.word_of_row(),
        }
    }

    /// Whether the vocabulary has a family for it; not of several causes at once.
    pub fn inside(self) -> Option<bool> {
        (self != Cause::Everything).then(|| INSIDE.contains(&self) || WORDS.contains(&self))
    }

    /// Families that are right, and whether the joint has to be that of the cause.
    fn families(self) -> &'static [(&'static str, bool)] {
        match self {
            Cause::JointCompliance => &[("joint_compliance", true)],
            Cause::LinkBending => &[("link_compliance", true)],
            Cause::BaseTilt => &[("base_compliance", false)],
            Cause::Backlash | Cause::Dahl | Cause::MaxwellSlip => &[("backlash", true)],
            Cause::Eccentric | Cause::Mesh | Cause::Waves => &[("transmission", true)],
            Cause::Coupling => &[("coupling", true)],
            Cause::Shift => &[("shift", false)],
            Cause::Bearing | Cause::Flange => {
                &[("joint_compliance", true), ("link_compliance", true), ("load_nonlinearity", true)]
            }
            Cause::BasePlate => &[("base_compliance", false), ("load_nonlinearity", false)],
            Cause::WarmUp => &[("thermal", false), ("drift", false)],
            Cause::Station => &[("drift", false), ("shift", false), ("instrument", false)],
            Cause::Masses => &[("joint_compliance", false), ("load_nonlinearity", false)],
            other => other.families_of_words(),
        }
    }

    /// Whether loads have to differ between poses for it to be visible at its place.
    pub fn needs_loads(self) -> bool {
        matches!(
            self,
            Cause::JointCompliance
                | Cause::LinkBending
                | Cause::BaseTilt
                | Cause::Bearing
                | Cause::Waves
                | Cause::BasePlate
                | Cause::Flange
                | Cause::Masses
                | Cause::Everything
        )
    }

    /// Whether the declared model has joint compliances (masses matter through them alone).
    pub fn needs_compliance(self) -> bool {
        matches!(self, Cause::Masses | Cause::Everything)
    }

    /// Declared compliance of the robot over that of other robots: masses matter where drives deflect, as those of light arms.
    pub fn softness(self) -> f64 {
        match self {
            Cause::Masses => 20.0,
            Cause::Lubricant | Cause::Label | Cause::Spring => 8.0,
            Cause::Everything => 3.0,
            _ => 1.0,
        }
    }

    /// Whether its size is given by what it is (10 % of each mass), not by the noise.
    pub fn has_a_size_of_its_own(self) -> bool {
        self == Cause::Masses
    }

    /// Whether the robot's own errors are unchanged by it: the instrument moves.
    pub fn is_instrument(self) -> bool {
        self == Cause::Station
    }
}

/// A cause at its place, with all numbers but its size.
#[derive(Debug, Clone)]
pub struct Hidden {
    pub cause: Cause,
    pub(super) joint: JointId,
    pub(super) name: String,
    pub(super) driver: String,
    /// Uniform numbers in [0, 1).
    pub(super) u: [f64; 6],
    /// Largest load of the joint about or along its axis, N·m or N, and the largest of all joints.
    pub(super) load: (f64, f64),
    pub(super) duration: f64,
    pub(super) reach: f64,
    pub(super) slide: bool,
    pub(super) range: f64,
    pub(super) limits: (f64, f64),
    /// Heaviest payload, kg.
    pub(super) payload: f64,
    /// Of several causes at once: what they are, and the one of them that is there alone.
    pub(super) pieces: Vec<Piece>,
    pub(super) only: Option<usize>,
    /// Largest load and travel of each movable joint, by its place.
    pub(super) loads: Vec<(usize, f64)>,
    pub(super) travels: Vec<(usize, [f64; 2])>,
}

impl Hidden {
    /// A cause at a joint that can have it; none where no joint can. `loads` are those of the movable joints.
    pub fn draw(cause: Cause, robot: &Robot, loads: &[f64], duration: f64, draw: &mut Draw) -> Option<Self> {
        let chain = &robot.chain;
        let largest = loads.iter().copied().fold(0.0, f64::max);
        let turns = |joint: JointId| chain.joint(joint).kind == JointKind::Revolute;
        let can = |(k, joint): (usize, JointId)| match cause {
            Cause::JointCompliance => turns(joint) && loads[k] > 0.1 * largest,
            Cause::Eccentric | Cause::Mesh | Cause::Coupling => turns(joint),
            Cause::LinkBending | Cause::Bearing | Cause::Flange => k < 3,
            other => other.fits(chain, (k, joint), loads[k] > 0.1 * largest),
        };
        let places: Vec<(usize, JointId)> =
            chain.movable().iter().copied().enumerate().filter(|&place| can(place)).collect();
        if places.is_empty() {
            return None;
        }
        let (k, joint) = draw.of(&places);
        let others: Vec<JointId> =
            chain.movable().iter().copied().filter(|&j| j != joint && turns(j)).collect();
        let driver = if others.is_empty() { None } else { Some(draw.of(&others)) };
        if cause == Cause::Coupling && driver.is_none() {
            return None;
        }
        let name = |joint: JointId| chain.joint(joint).name.clone();
        let limits = |joint: JointId| chain.joint(joint).limits.unwrap_or((-3.0, 3.0));
        let (lower, upper) = limits(joint);
        let travel = |joint: &JointId| (joint.index(), <[f64; 2]>::from(limits(*joint)));
        let several = cause == Cause::Everything;
        Some(Hidden {
            cause,
            joint,
            name: name(joint),
            driver: driver.map_or(String::new(), name),
            u: [0.0; 6].map(|_: f64| draw.between(0.0, 1.0)),
            load: (loads[k].max(0.02 * largest).max(1e-3), largest.max(1e-3)),
            duration,
            reach: robot.reach,
            slide: !turns(joint),
            range: upper - lower,
            limits: (lower, upper),
            payload: robot.payload,
            pieces: if several { pieces(chain, loads) } else { Vec::new() },
            only: None,
            loads: chain.movable().iter().zip(loads).map(|(joint, load)| (joint.index(), *load)).collect(),
            travels: chain.movable().iter().map(travel).collect(),
        })
    }

    /// The joint, where the name depends on it.
    pub fn place(&self) -> String {
        match self.cause {
            Cause::BaseTilt | Cause::BasePlate => "base".into(),
            Cause::Shift | Cause::WarmUp | Cause::Station | Cause::Masses | Cause::Everything => {
                String::new()
            }
            other if other.families().iter().all(|(_, at_joint)| !at_joint) => String::new(),
            _ => self.name.clone(),
        }
    }

    /// Joint whose compliance the declared model lacks.
    pub fn undeclared(&self) -> Option<JointId> {
        (self.cause == Cause::JointCompliance).then_some(self.joint)
    }

    /// Whether this is a right name for it.
    pub fn is_named(&self, family: &str, joint: Option<&str>) -> bool {
        if self.cause == Cause::Everything {
            return self.pieces.iter().any(|piece| piece.is_named(family, joint));
        }
        let right = self.cause.families().iter().find(|(word, _)| *word == family);
        right.is_some_and(|(_, at_joint)| !at_joint || joint == Some(self.name.as_str()))
    }

    /// A deflection of this size (0.1 mrad or 0.1 mm at size one) under the largest load.
    pub(super) fn stiffness(&self, size: f64) -> f64 {
        self.load.0 / (1e-4 * size * if self.slide { self.reach } else { 1.0 })
    }

    /// Errors that have no everyday form.
    pub fn amend(
        &self,
        truth: &mut Truth,
        disturbances: &mut Disturbances,
        size: f64,
    ) -> Result<(), Box<dyn Error>> {
        let angle = 1e-4 * size;
        let own = angle * if self.slide { self.reach } else { 1.0 };
        let joint = &mut truth.joints[self.joint.index()];
        match self.cause {
            Cause::Everything => self.amend_everything(truth, size)?,
            Cause::Dahl => {
                let width = self.range * (0.005 + 0.04 * self.u[0]);
                joint.presliding = Some(Presliding::Dahl { amplitude: own, width });
            }
            Cause::MaxwellSlip => {
                let widths = [0.003, 0.015, 0.06].map(|part| part * self.range * (0.5 + self.u[0])).to_vec();
                let parts = vec![0.5 + self.u[1], 0.5 + self.u[2], 0.3];
                joint.presliding = Some(Presliding::MaxwellSlip { amplitude: own, widths, parts });
            }
            Cause::Bearing => {
                let soft = Vector3::new(self.u[0] - 0.5, self.u[1] - 0.5, self.u[2] - 0.5);
                let preload = self.load.1 * (0.2 + 0.3 * self.u[3]);
                let ratio = 1.0 + 2.0 * self.u[4];
                joint.bearing = Some(TiltingBearing { angle, preload, soft, ratio });
            }
            Cause::Waves => {
                let cycles = [101.0 / 11.0, 37.0 / 3.0, 160.0 / 7.0][(3.0 * self.u[0]) as usize % 3];
                let scale = if self.slide { 1.0 / (4.0 * self.range) } else { 1.0 };
                let wave = |amplitude: f64, factor: f64, phase: f64| Wave {
                    amplitude,
                    cycles: cycles * factor * scale,
                    phase,
                };
                let waves = vec![wave(own, 1.0, 6.0 * self.u[1]), wave(0.4 * own, 1.618, 6.0 * self.u[2])];
                joint.waves = Some(LoadedWaves { waves, edge: 0.9, by_load: 1.0, load: 0.5 * self.load.0 });
            }
            Cause::Flange => joint.flange = Some(self.flange(angle)),
            Cause::BasePlate => truth.base_plate = Some(self.flange(angle)),
            Cause::WarmUp => {
                let warm = WarmUp {
                    power: 10.0,
                    housing_s: self.duration * (0.05 + 0.05 * self.u[0]),
                    casting_s: self.duration * (0.3 + 0.5 * self.u[1]),
                    near: 0.3 + 0.4 * self.u[2],
                    cycle_s: self.duration * 2.0,
                    working: 0.3 + 0.2 * self.u[3],
                };
                let amount = Amount::Curve(warm.rise(1.05 * self.duration)?);
                let place = self.joint.index();
                truth
                    .changes
                    .push(Change { mover: Mover::Length(place, 1e-5 * size), amount: amount.clone() });
                truth.changes.push(Change { mover: Mover::Joint(place, 0.1 * own), amount });
            }
            Cause::Shift => {
                let mut by = [0.0; 6];
                for (k, value) in by.iter_mut().enumerate() {
                    *value = (self.u[k] - 0.5) * 4.0 * angle * if k < 3 { self.reach } else { 0.5 };
                }
                let amount = Amount::Since(self.duration * (0.3 + 0.4 * self.u[0]));
                truth.changes.push(Change { mover: Mover::Base(by), amount });
            }
            Cause::Station => {
                let step = angle * self.reach;
                let steps = (3.0 * self.u[0]) as usize;
                let drift = step * (0.5 + self.u[1]);
                disturbances.station =
                    Some(StationMotion { drift, turn: 0.3 * angle, steps, step, step_turn: 0.3 * angle });
            }
            _ => {}
        }
        Ok(())
    }

    /// It lifts at a third to two thirds of the largest moment.
    fn flange(&self, angle: f64) -> LiftingFlange {
        LiftingFlange {
            stiffness: self.load.1 / angle,
            separation: self.load.1 * (0.33 + 0.33 * self.u[0]),
            remaining: 0.15 + 0.3 * self.u[1],
        }
    }
}
