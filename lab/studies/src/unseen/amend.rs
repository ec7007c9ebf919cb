//! What a cause does to a true robot, by a law that is no formula of the model.
//!
//! | cause | plant |
//! | --- | --- |
//! | creep | stretched exponential of the load of a joint |
//! | heating | motor and gear, heated by friction and load |
//! | pauses | two bodies that warm up at work and cool in pauses; the base |
//! | gradient | two sides of a column, with a time constant each; the base |
//! | whole_arm | each link with its own coefficient of expansion, 15 % apart |
//! | lubricant | compliance of a drive that grows exponentially with the temperature |
//! | two_constants | housings and castings; the base |
//! | undone, settles | a bump that is put right; of which a part goes back hyperbolically |
//! | tilting_bearing | a preloaded bearing, Hertzian beyond its preload |
//! | refraction, sight | air in layers; a prism, by incidence |
//! | bridge, ram | a beam on compliant posts; a tapered ram in its bush |
//! | wear | backlash in a part of the travel with soft edges |
//! | four_bar | a closed linkage, exactly |
//! | label | the load of a stretch of the poses was another one |
//! | counterbalance | a gas spring over a crank |
//!
//! A six-axis arm with all the usual causes at once.
//!
//! | part | plant | right names |
//! | --- | --- | --- |
//! | gears, every joint | an eccentric disc, its second harmonic, teeth that are no sine and swell once a turn | transmission, its joint |
//! | friction, every joint | Dahl or Maxwell slip: the path decides | backlash, its joint |
//! | hardening, loaded joints | τ = k θ (1 + (θ/θ_h)²) where the declared model has a constant compliance | joint_compliance or load_nonlinearity, its joint |
//! | masses | every link off by 10 % (σ) | joint_compliance, load_nonlinearity or payload |
//! | drift | the base, over the campaign, with housings and castings | drift, thermal or shift |
//!
//! The noise is that of the joints. All parts but masses and hardening have one scale, so that together they have the wanted size.

use super::cause::{Cause, PARTS, PAUSE, SIDES};
use super::hidden::{Hidden, Piece, Share};
use crate::prelude::*;
use std::f64::consts::TAU;
use truepose_simulate::physics::bridge::{Bridge, Ram};
use truepose_simulate::physics::creep::Creep;
use truepose_simulate::physics::heating::Heating;
use truepose_simulate::physics::linkage::FourBar;
use truepose_simulate::physics::mounting::{LiftingFlange, TiltingBearing};
use truepose_simulate::physics::presliding::Presliding;
use truepose_simulate::physics::spring::GasSpring;
use truepose_simulate::physics::warming::WarmUp;
use truepose_simulate::physics::wave::{LoadedWaves, Wave};
use truepose_simulate::{Beam, StationMotion};

impl Hidden {
    /// Adds the errors that have no everyday form, at some size, to a plant.
    pub fn amend(&self, plant: &mut Plant, size: f64) -> Outcome {
        let (u, angle, place) = (self.u, 1e-4 * size, self.joint.index());
        let own = angle * if self.slide { self.reach } else { 1.0 };
        let ((lower, upper), range) = (self.limits, self.range());
        let base = |scale: f64| {
            let part = |k: usize| (u[k] - 0.5) * 4.0 * scale * if k < 3 { self.reach } else { 0.5 };
            Mover::Base([0, 1, 2, 3, 4, 5].map(part))
        };
        let instant = self.duration * (0.2 + 0.3 * u[0]);
        let (mut truth, shop) = (plant.truth().clone(), plant.shop.clone());
        let joint = &mut truth.joints[place];
        let mut change = |mover: Mover, amount: Amount| truth.changes.push(Change { mover, amount });
        match self.cause {
            Cause::Everything => self.amend_everything(&mut truth, size)?,
            Cause::Drives => {
                // Each by this angle times 0.3 to 3 under its largest moment: a gear is chosen for its moment.
                for drive in self.drives() {
                    let mut draw = Draw::of(u[0].to_bits() ^ drive.place as u64, 0);
                    truth.joints[drive.place].stiffness.drive =
                        drive.load / (angle * draw.logarithmic(0.3, 3.0));
                }
            }
            Cause::Dahl => {
                let width = range * (0.005 + 0.04 * u[0]);
                joint.presliding = Some(Presliding::Dahl { amplitude: own, width });
            }
            Cause::MaxwellSlip => {
                let widths = [0.003, 0.015, 0.06].map(|part| part * range * (0.5 + u[0])).to_vec();
                let parts = vec![0.5 + u[1], 0.5 + u[2], 0.3];
                joint.presliding = Some(Presliding::MaxwellSlip { amplitude: own, widths, parts });
            }
            Cause::Bearing => joint.bearing = Some(self.bearing(angle, 0.2)),
            Cause::TiltingBearing => joint.bearing = Some(self.bearing(angle, 0.3)),
            Cause::Waves => {
                let cycles = [101.0 / 11.0, 37.0 / 3.0, 160.0 / 7.0][(3.0 * u[0]) as usize % 3];
                let scale = if self.slide { 1.0 / (4.0 * range) } else { 1.0 };
                let wave = |amplitude: f64, factor: f64, phase: f64| Wave {
                    amplitude,
                    cycles: cycles * factor * scale,
                    phase,
                };
                let waves = vec![wave(own, 1.0, 6.0 * u[1]), wave(0.4 * own, 1.618, 6.0 * u[2])];
                joint.waves = Some(LoadedWaves { waves, edge: 0.9, by_load: 1.0, load: 0.5 * self.load.0 });
            }
            Cause::Flange => joint.flange = Some(self.flange(angle)),
            Cause::BasePlate => truth.base_plate = Some(self.flange(angle)),
            Cause::WarmUp => {
                let warm = WarmUp {
                    power: 10.0,
                    housing_s: self.duration * (0.05 + 0.05 * u[0]),
                    casting_s: self.duration * (0.3 + 0.5 * u[1]),
                    near: 0.3 + 0.4 * u[2],
                    cycle_s: self.duration * 2.0,
                    working: 0.3 + 0.2 * u[3],
                };
                let amount = Amount::Curve(warm.rise(1.05 * self.duration)?);
                change(Mover::Length(place, 1e-5 * size), amount.clone());
                change(Mover::Joint(place, 0.1 * own), amount);
            }
            Cause::Shift => change(base(angle), Amount::Since(self.duration * (0.3 + 0.4 * u[0]))),
            Cause::Station => {
                let (step, turn) = (angle * self.reach, 0.3 * angle);
                let (steps, drift) = ((3.0 * u[0]) as usize, step * (0.5 + u[1]));
                plant.disturbances.station =
                    Some(StationMotion { drift, turn, steps, step, step_turn: turn });
            }
            Cause::Creep => {
                let compliance = 2.0 * own / self.load.0;
                let time = self.duration * (0.01 + 0.04 * u[1]);
                joint.creep = Some(Creep { compliance, time, stretch: 0.5 + 0.3 * u[2] });
            }
            Cause::Heating => {
                let friction = 0.5 * self.load.0 * (0.5 + u[3]);
                let (motor_s, gear_s) =
                    (self.duration * (0.02 + 0.05 * u[1]), self.duration * (0.05 + 0.1 * u[2]));
                // A radian a minute against friction and load.
                let rate = 4.0 * own / (2.0 * friction * range / 3.0 / 60.0);
                let near = 0.2 + 0.4 * u[4];
                joint.heating = Some(Heating { friction, motor_s, gear_s, near, rate, by_load: u[5] > 0.5 });
            }
            Cause::Pauses | Cause::TwoConstants => {
                let pauses = if self.cause == Cause::Pauses { (PARTS - 1) as f64 * PAUSE } else { 0.0 };
                let work = (self.duration - pauses) / PARTS as f64;
                let warm = WarmUp {
                    power: 1.0,
                    housing_s: work * if pauses > 0.0 { 0.2 + 0.2 * u[1] } else { 0.1 + 0.1 * u[1] },
                    casting_s: work * if pauses > 0.0 { 0.5 + 0.5 * u[2] } else { 2.0 + 2.0 * u[2] },
                    near: 0.4 + 0.2 * u[3],
                    cycle_s: if pauses > 0.0 { work + PAUSE } else { f64::INFINITY },
                    working: if pauses > 0.0 { work / (work + PAUSE) } else { 1.0 },
                };
                change(base(angle), Amount::Curve(warm.rise(1.05 * self.duration)?));
            }
            Cause::Gradient => {
                for (part, sign) in SIDES.into_iter().zip([1.0, -1.0]) {
                    let body = shop.body(part * self.duration * (0.8 + 0.4 * u[0]))?;
                    change(base(sign * angle), Amount::Curve(body));
                }
            }
            Cause::WholeArm => {
                let air = shop.body(0.0)?;
                for (k, described) in plant.chain().joints().iter().enumerate() {
                    let strain = 1e-5 * size * (1.0 + 0.3 * (u[k % 6] - 0.5));
                    change(Mover::Length(k, strain), Amount::Curve(air.clone()));
                    if described.kind == JointKind::Prismatic {
                        change(Mover::Scale(k, strain), Amount::Curve(air.clone()));
                    }
                }
            }
            Cause::Lubricant => change(Mover::Softer(place, 0.01 * size), Amount::Curve(shop.body(0.0)?)),
            Cause::Undone => {
                let until = instant + self.duration * (0.15 + 0.25 * u[1]);
                change(base(angle), Amount::During([instant, until]));
            }
            Cause::Settles => {
                let time = self.duration * (0.02 + 0.06 * u[2]);
                change(base(angle), Amount::Settling { at: instant, part: 0.6 + 0.3 * u[1], time });
            }
            Cause::Refraction => {
                let beam = Beam { curvature: 2e-5 * size, fall: 1.0 + 4.0 * u[1], offset: 0.0 };
                plant.disturbances.beam = Some(beam);
            }
            Cause::Sight => {
                plant.disturbances.beam = Some(Beam { curvature: 0.0, fall: 1.0, offset: 1e-4 * size });
            }
            Cause::Bridge => {
                let over = 0.1 + 0.2 * u[0];
                let ends = [lower - over * range, upper + (0.1 + 0.2 * u[1]) * range];
                // A tenth of a millimetre under all that hangs there.
                let weight = 9.81 * 60.0 * self.reach * self.reach;
                let stiffness = weight * range.powi(3) / (48.0 * angle * self.reach);
                let posts = [u[2], u[3]].map(|u| weight / (angle * self.reach) * (3.0 + 5.0 * u));
                joint.bridge = Some(Bridge { ends, stiffness, posts });
            }
            Cause::Ram => {
                let length = -lower + (0.1 + 0.5 * u[0]) * range;
                let full = length + upper;
                let weight = 9.81 * 40.0 * self.reach * self.reach;
                let stiffness = weight * full.powi(3) / (3.0 * angle * self.reach);
                let (taper, bush) = (0.3 * u[1], 6.0 * stiffness / full);
                joint.ram = Some(Ram { length, stiffness, taper, full: full + 0.1 * self.reach, bush });
            }
            Cause::Wear => joint.worn = Some(self.worn()),
            Cause::FourBar => {
                let (driver, (crossed, offset)) = (place - 1, self.crank(plant.chain()));
                let sign = if crossed { -1.0 } else { 1.0 };
                let longer = [4.0 * own * (0.5 + u[2]), 2.0 * own * (u[3] - 0.5)];
                joint.linkage = Some(FourBar { driver, sign, offset, arm: 2.0 + 2.0 * u[4], longer });
            }
            Cause::Spring => {
                let levers = [0.3 * self.reach, (0.08 + 0.1 * u[0]) * self.reach];
                let force = 0.2 * size * self.load.0 / levers[1];
                let (offset, column) = (self.longest(), 2.0 * (levers[0] + levers[1]) + u[3]);
                joint.spring = Some(GasSpring { force, levers, offset, column, exponent: 1.1 + 0.2 * u[4] });
            }
            Cause::Label => {
                let until = instant + self.duration * (0.2 + 0.25 * u[1]);
                plant.blunders.wrong_stretch = Some(([instant, until], self.payload, 1.0 + 0.1 * size));
            }
            _ => {}
        }
        *plant = plant.clone().with_truth(truth)?;
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

    /// Preloaded by this fraction of the largest moment or up to 0.3 more.
    fn bearing(&self, angle: f64, preload: f64) -> TiltingBearing {
        let u = self.u;
        let soft = Vector3::new(u[0] - 0.5, u[1] - 0.5, u[2] - 0.5);
        TiltingBearing { angle, preload: self.load.1 * (preload + 0.3 * u[3]), soft, ratio: 1.0 + 2.0 * u[4] }
    }
}

/// Numbers of poses.
pub const POSES: [usize; 3] = [150, 300, 1000];
/// What all of it leaves of the declared model, over the noise of a row.
pub const SIZES: [f64; 2] = [4.0, 12.0];

impl Hidden {
    /// Errors of all parts, or of the one that is there alone.
    pub fn amend_everything(&self, truth: &mut Truth, size: f64) -> Outcome {
        for (number, piece) in self.pieces.iter().enumerate() {
            // Every part has its own numbers, whichever others there are.
            let mut draw = Draw::of(self.u[0].to_bits() ^ number as u64, 0);
            if self.only.is_none_or(|only| only == number) {
                self.amend_piece(piece, truth, 1e-4 * size, &mut draw)?;
            }
        }
        Ok(())
    }

    fn amend_piece(&self, piece: &Piece, truth: &mut Truth, angle: f64, draw: &mut Draw) -> Outcome {
        let Some((place, _)) = piece.joint else {
            if piece.share == Share::Drift {
                let warm = WarmUp {
                    power: 1.0,
                    housing_s: self.duration * draw.between(0.05, 0.2),
                    casting_s: self.duration * draw.between(0.5, 2.0),
                    near: draw.between(0.2, 0.6),
                    cycle_s: f64::INFINITY,
                    working: 1.0,
                };
                let half = 0.5 * angle;
                let part = |k: usize| half * draw.normal() * if k < 3 { self.reach } else { 0.5 };
                let mover = Mover::Base([0, 1, 2, 3, 4, 5].map(part));
                truth.changes.push(Change { mover, amount: Amount::Curve(warm.rise(1.05 * self.duration)?) });
            }
            return Ok(());
        };
        let (joint, own) = (&mut truth.joints[place], self.joints.iter().find(|joint| joint.place == place));
        match piece.share {
            Share::Gears => {
                let own = angle * draw.logarithmic(0.2, 1.0);
                let second = TransmissionError::Mesh {
                    amplitude: own * draw.between(0.2, 0.7),
                    cycles: 2.0,
                    phase: draw.between(0.0, TAU),
                    sharpness: 0.3,
                    lean: 0.1,
                    runout: 0.0,
                    runout_phase: 0.0,
                };
                let teeth = draw.between(8.0, 120.0).round();
                joint.transmission.extend([
                    TransmissionError::Eccentric { ratio: own, phase: draw.between(0.0, TAU) },
                    second,
                    TransmissionError::mesh(own * draw.between(0.1, 0.4), teeth, draw.between(0.0, TAU)),
                ]);
            }
            Share::Friction => {
                let amplitude = angle * draw.logarithmic(0.1, 0.6);
                let [lower, upper] = own.map_or([-3.0, 3.0], |own| own.travel);
                let width = (upper - lower) * draw.logarithmic(0.003, 0.04);
                joint.presliding = Some(if draw.chance(0.5) {
                    Presliding::Dahl { amplitude, width }
                } else {
                    let widths = [0.3, 1.0, 4.0].map(|part| part * width).to_vec();
                    Presliding::MaxwellSlip { amplitude, widths, parts: vec![0.5, 0.3, 0.2] }
                });
            }
            Share::Hardening => {
                // Where its load would be twice the linear one: near its largest deflection.
                let deflection = own.map_or(0.0, |own| own.load) / joint.stiffness.drive;
                if deflection > 0.0 {
                    joint.stiffness.hardens_at = deflection * draw.between(0.4, 1.5);
                }
            }
            Share::Masses | Share::Drift => {}
        }
        Ok(())
    }
}
