//! A cause at its place, and what it does to a true robot.

use super::cause::Cause;
use super::drives::{Drive, drives, soften};
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
    /// Joints whose drives carry a weight.
    pub(super) drives: Vec<Drive>,
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
        let (k, joint) = draw.one(&places);
        let others: Vec<JointId> =
            chain.movable().iter().copied().filter(|&j| j != joint && turns(j)).collect();
        let driver = if others.is_empty() { None } else { Some(draw.one(&others)) };
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
            drives: if cause == Cause::Drives { drives(chain, loads) } else { Vec::new() },
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
        if self.cause == Cause::Drives {
            return family == "joint_compliance"
                && self.drives.iter().any(|drive| joint == Some(drive.name.as_str()));
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
            Cause::Drives => soften(&self.drives, truth, angle, self.u[0]),
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
