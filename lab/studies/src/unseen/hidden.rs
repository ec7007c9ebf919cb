//! A cause at its place: its names, and the errors that have a form in everyday units.
//!
//! The effect that is right for a cause of the vocabulary, as someone declares it who knows its place: nonlinear parameters are left free
//! within wide ranges.

use super::cause::Cause;
use super::robots::Robot;
use crate::prelude::*;
use std::f64::consts::FRAC_PI_2;
use truepose_errormodel::History;
use truepose_errormodel::effects::{
    Backlash, Coupling, Drift, Grows, Guideway, Instrument, InstrumentMode, LinkCompliance, Shift, Side,
    Spot, Thermal,
};

/// Of the largest moment, below which a drive carries nothing.
const CARRIES: f64 = 0.03;

/// A movable joint.
#[derive(Debug, Clone)]
pub(super) struct Movable {
    pub place: usize,
    pub name: String,
    /// Largest load about or along its axis, N·m or N.
    pub load: f64,
    pub travel: [f64; 2],
    pub turns: bool,
}

/// What there is one of for each joint, or for the robot.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Share {
    Gears,
    Friction,
    Hardening,
    Masses,
    Drift,
}

/// One of the causes.
#[derive(Debug, Clone, PartialEq)]
pub struct Piece {
    pub share: Share,
    /// Place and name of the joint; none of the robot's.
    pub joint: Option<(usize, String)>,
}

impl Piece {
    /// Whether this is a right name for it.
    pub fn is_named(&self, family: &str, joint: Option<&str>) -> bool {
        let families: &[&str] = match self.share {
            Share::Gears => &["transmission"],
            Share::Friction => &["backlash"],
            Share::Hardening => &["joint_compliance", "load_nonlinearity"],
            Share::Masses => &["joint_compliance", "load_nonlinearity", "payload"],
            Share::Drift => &["drift", "thermal", "shift"],
        };
        let here = self.joint.as_ref().is_none_or(|(_, name)| joint == Some(name.as_str()));
        families.contains(&family) && here
    }
}

/// All parts, of the robot's joints with their largest loads.
pub fn pieces(chain: &Chain, loads: &[f64]) -> Vec<Piece> {
    let largest = loads.iter().copied().fold(0.0, f64::max);
    let mut pieces = Vec::new();
    for (k, &joint) in chain.movable().iter().enumerate() {
        let loaded = loads[k] > 0.1 * largest;
        let shares = [Share::Gears, Share::Friction, Share::Hardening];
        let of_joint = |share| Piece { share, joint: Some((joint.index(), name_of(chain, joint))) };
        pieces.extend(shares[..if loaded { 3 } else { 2 }].iter().copied().map(of_joint));
    }
    pieces.extend([Share::Masses, Share::Drift].map(|share| Piece { share, joint: None }));
    pieces
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
    pub(super) limits: (f64, f64),
    /// Heaviest payload, kg.
    pub(super) payload: f64,
    /// Of several causes at once: what they are, and the one of them that is there alone.
    pub(super) pieces: Vec<Piece>,
    pub(super) only: Option<usize>,
    pub(super) joints: Vec<Movable>,
}

impl Hidden {
    /// A cause at a joint that can have it; none where no joint can. `loads` are those of the movable joints.
    pub fn draw(cause: Cause, robot: &Robot, loads: &[f64], duration: f64, draw: &mut Draw) -> Option<Self> {
        let chain = &robot.chain;
        let largest = loads.iter().copied().fold(0.0, f64::max);
        let can = |place: &(usize, JointId)| cause.fits(chain, *place, loads[place.0] > 0.1 * largest);
        let places: Vec<(usize, JointId)> = chain.movable().iter().copied().enumerate().filter(can).collect();
        if places.is_empty() {
            return None;
        }
        let (k, joint) = draw.one(&places);
        let turns = |j: &JointId| *j != joint && !slides(chain, *j);
        let others: Vec<JointId> = chain.movable().iter().copied().filter(turns).collect();
        let driver = if others.is_empty() { None } else { Some(draw.one(&others)) };
        if cause == Cause::Coupling && driver.is_none() {
            return None;
        }
        let limits = |joint: JointId| chain.joint(joint).limits.unwrap_or((-3.0, 3.0));
        let movable = |(&joint, &load): (&JointId, &f64)| Movable {
            place: joint.index(),
            name: name_of(chain, joint),
            load,
            travel: limits(joint).into(),
            turns: !slides(chain, joint),
        };
        Some(Hidden {
            cause,
            joint,
            name: name_of(chain, joint),
            driver: driver.map_or(String::new(), |driver| name_of(chain, driver)),
            u: [0.0; 6].map(|_: f64| draw.between(0.0, 1.0)),
            load: (loads[k].max(0.02 * largest).max(1e-3), largest.max(1e-3)),
            duration,
            reach: robot.reach,
            slide: slides(chain, joint),
            limits: limits(joint),
            payload: robot.payload,
            pieces: if cause == Cause::Everything { pieces(chain, loads) } else { Vec::new() },
            only: None,
            joints: chain.movable().iter().zip(loads).map(movable).collect(),
        })
    }

    /// The turning joints whose drives carry a weight.
    pub(super) fn drives(&self) -> impl Iterator<Item = &Movable> {
        let turning = || self.joints.iter().filter(|joint| joint.turns);
        let largest = turning().map(|joint| joint.load).fold(0.0, f64::max);
        turning().filter(move |joint| joint.load > CARRIES * largest)
    }

    /// The joint, where the name depends on it.
    pub fn place(&self) -> String {
        match self.cause {
            Cause::BaseTilt | Cause::BasePlate => "base".into(),
            Cause::Everything => String::new(),
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
        right.is_some_and(|(_, at_joint)| match self.cause {
            Cause::Drives => self.drives().any(|drive| joint == Some(drive.name.as_str())),
            _ => !at_joint || joint == Some(self.name.as_str()),
        })
    }

    /// Travel of the joint, rad or m.
    pub(super) fn range(&self) -> f64 {
        self.limits.1 - self.limits.0
    }

    /// Middle and half width of a worn part, rad or m.
    pub(super) fn worn(&self) -> [f64; 2] {
        let long = self.range();
        [self.limits.0 + long * (0.3 + 0.4 * self.u[0]), long * (0.12 + 0.08 * self.u[1])]
    }

    /// Whether the angle of a linkage is the difference of its joints, and what it is where both are zero, rad.
    pub(super) fn crank(&self, chain: &Chain) -> (bool, f64) {
        let crossed = self.u[0] <= 0.5;
        let (a, b) = self.limits;
        let (c, d) = chain.joints()[self.joint.index() - 1].limits.unwrap_or((-1.0, 1.0));
        let sum = if crossed { -(c + d) } else { c + d };
        (crossed, FRAC_PI_2 - 0.5 * (a + b) - 0.5 * sum + 0.1 * (self.u[1] - 0.5))
    }

    /// Where a spring is longest, rad: near an end of the travel, as a balancer is.
    pub(super) fn longest(&self) -> f64 {
        let (lower, upper) = self.limits;
        (if self.u[1] > 0.5 { upper } else { lower }) + 0.6 * (self.u[2] - 0.5)
    }

    /// Whether link masses are off, of several causes at once.
    fn masses_are_off(&self) -> bool {
        let is = |number: &usize| self.pieces[*number].share == Share::Masses;
        self.only.as_ref().map_or(!self.pieces.is_empty(), is)
    }

    /// Errors in everyday units.
    pub fn options(&self, options: &mut PlantOptions, size: f64) {
        let joint = self.name.clone();
        let (mrad, mm) = (0.1 * size, 0.1 * size * self.reach);
        let errors = &mut options.errors;
        match self.cause {
            Cause::JointCompliance => {
                // A deflection of 0.1 mrad or 0.1 mm at size one under the largest load.
                let stiffness = self.load.0 / (1e-4 * size * if self.slide { self.reach } else { 1.0 });
                let stiffness = Some(stiffness);
                errors.joint_compliance.push(flaws::JointCompliance {
                    joint,
                    stiffness,
                    ..Default::default()
                });
            }
            Cause::LinkBending => {
                // Deflection F L³/3EI of about 0.1 mm × size, with F L the largest moment.
                let bending = self.load.1 * self.reach * self.reach / (3.0 * 1e-4 * size * self.reach);
                errors.link_compliance.push(flaws::LinkCompliance {
                    joint,
                    bending_nm2: [bending * (0.6 + self.u[0]), bending],
                    torsion_nm2: bending * (0.5 + self.u[1]),
                    ..Default::default()
                });
            }
            Cause::BaseTilt => {
                let tilt = self.load.1 / (1e-4 * size);
                let tilt = [tilt * (0.5 + self.u[0]), tilt * (0.5 + self.u[1]), 4.0 * tilt];
                errors.base_compliance =
                    Some(flaws::BaseCompliance { tilt_stiffness: Some(tilt), sink_stiffness: None });
            }
            Cause::Backlash | Cause::Wear => {
                errors.backlash.push(backlash(joint, self.slide, if self.slide { mm } else { mrad }));
            }
            Cause::Eccentric => errors.transmission.push(gear(joint, mrad, None)),
            Cause::Mesh => {
                errors.transmission.push(gear(joint, mrad, Some((3.0 + 20.0 * self.u[0]).round())));
            }
            Cause::Coupling => errors.coupling.push(flaws::Dragging {
                joint,
                driver: self.driver.clone(),
                ratio_milli: mrad,
                eccentricity_mrad: 0.3 * mrad,
            }),
            Cause::Masses => errors.mass_scatter = 0.1 * size,
            Cause::Everything if self.masses_are_off() => errors.mass_scatter = 0.1,
            _ => {}
        }
    }
}

impl Hidden {
    /// The right effects; none of a cause that is no row of the vocabulary, and of a payload, which is no effect.
    pub fn right(&self, chain: &Chain) -> Option<Box<dyn AnyEffect>> {
        let (joint, duration, base) = (self.joint, self.duration, Spot::Frame(FrameId::BASE));
        let (lag, lag_range) = (Some(0.05 * duration), Some([0.002 * duration, 0.6 * duration]));
        let (lower, upper) = self.limits;
        let whole = Some([0.0, duration]);
        Some(match self.cause {
            Cause::Creep => {
                JointCompliance { lag_range, ..JointCompliance::creep(joint, 0.05 * duration) }.boxed()
            }
            Cause::Heating => {
                let work = if self.u[5] > 0.5 { History::Work(joint) } else { History::Travel(joint) };
                let of = Thermal::by(Spot::Joint(joint), work, 0.05 * duration);
                Thermal { lag_range, grows: Some(Grows::Motion), ..of }.boxed()
            }
            Cause::Pauses => {
                Thermal { lag_range, ..Thermal::by(base, History::Working(300.0), 0.05 * duration) }.boxed()
            }
            Cause::Gradient => Thermal::gradient(base, "front", "back").boxed(),
            Cause::WholeArm => Thermal::arm("temperature").boxed(),
            Cause::Lubricant => JointCompliance::by_temperature(joint, "temperature", 20.0).boxed(),
            Cause::TwoConstants => Drift {
                time_constant_range: Some([0.01 * duration, 0.2 * duration]),
                second_time_constant: Some(0.5 * duration),
                second_time_constant_range: Some([0.2 * duration, 2.0 * duration]),
                ..Drift::settling(base, [0.0, duration], 0.05 * duration)
            }
            .boxed(),
            Cause::Undone => Shift {
                at_range: whole,
                until: Some(0.7 * duration),
                until_range: whole,
                ..Shift::of(base, 0.3 * duration)
            }
            .boxed(),
            Cause::Settles => Shift {
                at_range: whole,
                settling: lag,
                settling_range: lag_range,
                ..Shift::of(base, 0.3 * duration)
            }
            .boxed(),
            Cause::TiltingBearing => JointCompliance::bearing(joint).boxed(),
            Cause::Refraction => Instrument::of(InstrumentMode::Refraction).boxed(),
            Cause::Sight => Instrument::of(InstrumentMode::Sight).boxed(),
            Cause::Bridge => Guideway::sagging(joint, [lower, upper], 2).boxed(),
            Cause::Ram => {
                let length = -lower + 0.3 * (upper - lower);
                let ram_range = Some([-lower, -lower + 2.0 * (upper - lower)]);
                LinkCompliance { ram_range, ..LinkCompliance::ram(joint, length, false) }.boxed()
            }
            Cause::Wear => {
                let [middle, half] = self.worn();
                let between = Some([middle - half, middle + half]);
                Backlash { between, ..Backlash::of(joint, Side::Approach) }.boxed()
            }
            Cause::FourBar => {
                let driver = JointId(joint.0 - 1);
                let (crossed, offset) = self.crank(chain);
                let offset_range = Some([offset - 0.5, offset + 0.5]);
                Coupling { offset_range, ..Coupling::linkage(joint, driver, offset, crossed) }.boxed()
            }
            Cause::Spring => {
                let (offset, ratio_range) = (self.longest(), Some([0.1, 0.98]));
                let offset_range = Some([offset - 0.8, offset + 0.8]);
                JointCompliance {
                    offset_range,
                    ratio_range,
                    ..JointCompliance::counterbalance(joint, offset, 0.7)
                }
                .boxed()
            }
            _ => return None,
        })
    }
}
