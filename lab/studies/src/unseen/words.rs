//! Causes for which the vocabulary has a word that is no formula of the plant: one row of the vocabulary each.
//!
//! | cause | plant | right names |
//! | --- | --- | --- |
//! | creep | stretched exponential of the load of a joint | joint_compliance, its joint |
//! | heating | motor and gear, heated by friction and load | thermal, its joint |
//! | pauses | two bodies that warm up at work and cool in pauses; the base | thermal |
//! | gradient | two sides of a column, with a time constant each; the base | thermal |
//! | whole_arm | each link with its own coefficient of expansion, 15 % apart | thermal |
//! | lubricant | compliance of a drive that grows exponentially with the temperature | joint_compliance, its joint |
//! | two_constants | housings and castings; the base | drift |
//! | undone | a bump that is put right | shift |
//! | settles | a bump of which a part goes back hyperbolically | shift |
//! | tilting_bearing | a preloaded bearing, Hertzian beyond its preload | joint_compliance, link_compliance, load_nonlinearity, its joint |
//! | refraction | air in layers | instrument |
//! | sight | a prism, by incidence | instrument |
//! | bridge | a beam on compliant posts | guideway, its joint |
//! | ram | a tapered ram in its bush | link_compliance, its joint |
//! | wear | backlash in a part of the travel with soft edges | backlash, its joint |
//! | four_bar | a closed linkage, exactly | coupling, its joint |
//! | label | the load of a stretch of the poses was another one | payload |
//! | spring | a gas spring over a crank | joint_compliance, transmission, its joint |

use super::cause::Cause;
use super::hidden::Hidden;
use std::error::Error;
use std::f64::consts::FRAC_PI_2;
use truepose_kinematics::nalgebra::Vector3;
use truepose_kinematics::{Chain, JointId, JointKind};
use truepose_simulate::physics::bridge::{Bridge, Ram};
use truepose_simulate::physics::changes::{Amount, Change, Mover};
use truepose_simulate::physics::creep::Creep;
use truepose_simulate::physics::heating::Heating;
use truepose_simulate::physics::linkage::FourBar;
use truepose_simulate::physics::mounting::TiltingBearing;
use truepose_simulate::physics::spring::GasSpring;
use truepose_simulate::physics::temperature::Shop;
use truepose_simulate::physics::warming::WarmUp;
use truepose_simulate::{Beam, Blunders, Campaign, ChannelPlan, Disturbances, Truth};

/// Length of a pause, s, and how many parts of a campaign they part.
const PAUSE: f64 = 2400.0;
const PARTS: usize = 4;
/// Time constants of the two sides of a column, of the length of the campaign.
const SIDES: [f64; 2] = [0.02, 0.2];
/// A linkage is no nearer to its dead centre over the travel of its joints, rad.
const SWING: f64 = 2.95;

impl Cause {
    pub fn word_of_row(self) -> &'static str {
        match self {
            Cause::Creep => "creep",
            Cause::Heating => "heating",
            Cause::Pauses => "pauses",
            Cause::Gradient => "gradient",
            Cause::WholeArm => "whole_arm",
            Cause::Lubricant => "lubricant",
            Cause::TwoConstants => "two_constants",
            Cause::Undone => "undone",
            Cause::Settles => "settles",
            Cause::TiltingBearing => "tilting_bearing",
            Cause::Refraction => "refraction",
            Cause::Sight => "sight",
            Cause::Bridge => "bridge",
            Cause::Ram => "ram",
            Cause::Wear => "wear",
            Cause::FourBar => "four_bar",
            Cause::Label => "label",
            Cause::Spring => "counterbalance",
            _ => "unknown",
        }
    }

    pub fn families_of_words(self) -> &'static [(&'static str, bool)] {
        match self {
            Cause::Creep | Cause::Lubricant => &[("joint_compliance", true)],
            Cause::Heating => &[("thermal", true)],
            Cause::Pauses | Cause::Gradient | Cause::WholeArm => &[("thermal", false)],
            Cause::TwoConstants => &[("drift", false)],
            Cause::Undone | Cause::Settles => &[("shift", false)],
            Cause::Refraction | Cause::Sight => &[("instrument", false)],
            Cause::Bridge => &[("guideway", true)],
            Cause::Ram => &[("link_compliance", true)],
            Cause::Wear => &[("backlash", true)],
            Cause::FourBar => &[("coupling", true)],
            Cause::Label => &[("payload", false)],
            Cause::Spring => &[("joint_compliance", true), ("transmission", true)],
            _ => &[("joint_compliance", true), ("link_compliance", true), ("load_nonlinearity", true)],
        }
    }

    /// Whether it is in the beam of the instrument.
    pub fn is_beam(self) -> bool {
        matches!(self, Cause::Refraction | Cause::Sight)
    }

    /// Whether it is seen where temperatures change by kelvins.
    pub fn is_thermal(self) -> bool {
        matches!(self, Cause::Gradient | Cause::WholeArm | Cause::Lubricant)
    }

    /// Pauses and thermometers of a campaign of so many seconds between poses.
    pub fn equip(self, campaign: &mut Campaign, visit_s: f64) {
        let poses = campaign.visits.len();
        if self == Cause::Pauses {
            campaign.pauses = (1..PARTS).map(|part| (part * poses / PARTS, PAUSE)).collect();
        }
        if self == Cause::Gradient {
            let duration = visit_s * poses as f64;
            for (name, part) in ["front", "back"].into_iter().zip(SIDES) {
                campaign.channels.push(ChannelPlan::Body {
                    name: name.into(),
                    lag_s: part * duration,
                    sd: 0.02,
                });
            }
        }
    }

    /// Whether a joint can have it.
    pub fn fits(self, chain: &Chain, (k, joint): (usize, JointId), loaded: bool) -> bool {
        let slides = chain.joint(joint).kind == JointKind::Prismatic;
        match self {
            Cause::Creep | Cause::Lubricant | Cause::Spring => !slides && loaded,
            Cause::Bridge | Cause::Ram => slides && k < 2,
            Cause::TiltingBearing => k < 3,
            Cause::FourBar => {
                let half = |joint: JointId| chain.joint(joint).limits.map_or(9.0, |(a, b)| b - a);
                let before = k.checked_sub(1).map(|k| chain.movable()[k]);
                let turns = |joint: &JointId| chain.joint(*joint).kind == JointKind::Revolute;
                !slides && before.filter(turns).is_some_and(|before| half(joint) + half(before) < SWING)
            }
            _ => true,
        }
    }
}

impl Hidden {
    /// Middle and half width of a worn part, rad or m.
    pub(super) fn worn(&self) -> [f64; 2] {
        let (lower, upper) = self.limits;
        let long = upper - lower;
        [lower + long * (0.3 + 0.4 * self.u[0]), long * (0.12 + 0.08 * self.u[1])]
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

    /// Errors of these causes.
    pub fn amend_words(
        &self,
        chain: &Chain,
        shop: &Shop,
        (truth, disturbances, blunders): (&mut Truth, &mut Disturbances, &mut Blunders),
        size: f64,
    ) -> Result<(), Box<dyn Error>> {
        let (u, angle) = (self.u, 1e-4 * size);
        let own = angle * if self.slide { self.reach } else { 1.0 };
        let base = |scale: f64| {
            let part = |k: usize| (u[k] - 0.5) * 4.0 * scale * if k < 3 { self.reach } else { 0.5 };
            Mover::Base([0, 1, 2, 3, 4, 5].map(part))
        };
        let place = self.joint.index();
        let instant = self.duration * (0.2 + 0.3 * u[0]);
        let joint = &mut truth.joints[place];
        let mut change = |mover: Mover, amount: Amount| truth.changes.push(Change { mover, amount });
        match self.cause {
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
                let rate = 4.0 * own / (2.0 * friction * self.range / 3.0 / 60.0);
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
                let slides = |k: usize| chain.joints()[k].kind == JointKind::Prismatic;
                for k in 0..chain.joints().len() {
                    let strain = 1e-5 * size * (1.0 + 0.3 * (u[k % 6] - 0.5));
                    change(Mover::Length(k, strain), Amount::Curve(air.clone()));
                    if slides(k) {
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
            Cause::TiltingBearing => {
                let soft = Vector3::new(u[0] - 0.5, u[1] - 0.5, u[2] - 0.5);
                let preload = self.load.1 * (0.3 + 0.3 * u[3]);
                joint.bearing = Some(TiltingBearing { angle, preload, soft, ratio: 1.0 + 2.0 * u[4] });
            }
            Cause::Refraction => {
                disturbances.beam =
                    Some(Beam { curvature: 2e-5 * size, fall: 1.0 + 4.0 * u[1], offset: 0.0 });
            }
            Cause::Sight => disturbances.beam = Some(Beam { curvature: 0.0, fall: 1.0, offset: 1e-4 * size }),
            Cause::Bridge => {
                let (lower, upper) = self.limits;
                let (over, long) = (0.1 + 0.2 * u[0], upper - lower);
                let ends = [lower - over * long, upper + (0.1 + 0.2 * u[1]) * long];
                // A tenth of a millimetre under all that hangs there.
                let weight = 9.81 * 60.0 * self.reach * self.reach;
                let stiffness = weight * long.powi(3) / (48.0 * angle * self.reach);
                let posts = [u[2], u[3]].map(|u| weight / (angle * self.reach) * (3.0 + 5.0 * u));
                joint.bridge = Some(Bridge { ends, stiffness, posts });
            }
            Cause::Ram => {
                let (lower, upper) = self.limits;
                let length = -lower + (0.1 + 0.5 * u[0]) * (upper - lower);
                let full = length + upper;
                let weight = 9.81 * 40.0 * self.reach * self.reach;
                let stiffness = weight * full.powi(3) / (3.0 * angle * self.reach);
                let bush = 6.0 * stiffness / full;
                joint.ram =
                    Some(Ram { length, stiffness, taper: 0.3 * u[1], full: full + 0.1 * self.reach, bush });
            }
            Cause::Wear => {
                joint.worn = Some(self.worn());
            }
            Cause::FourBar => {
                let (driver, (crossed, offset)) = (place - 1, self.crank(chain));
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
                blunders.wrong_stretch = Some(([instant, until], self.payload, 1.0 + 0.1 * size));
            }
            _ => {}
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::super::cause::WORDS;
    use super::super::description::Kind;
    use super::super::stream::Half;
    use super::super::trial::Task;
    use super::*;
    use rayon::prelude::*;

    #[test]
    fn rows_are_found_and_named_on_robots_that_they_have_not_seen() {
        // Every sixth row: the study has them all, and a search takes half a minute here. A linkage needs two neighbouring joints of short
        // travel, which few robots have.
        let rows: Vec<Cause> =
            WORDS.into_iter().filter(|cause| *cause != Cause::FourBar).step_by(6).collect();
        let wrong: Vec<String> = rows
            .par_iter()
            .map(|cause| {
                let robots =
                    (0..20).map(|number| Task::of(Kind::Words, cause.word(), Half::Tuning, number).run());
                let record = robots.into_iter().find(|record| !record.text("ended").starts_with("no plant"));
                let Some(record) = record else { return format!("{}: no robot", cause.word()) };
                let beside = record.number("oracle_ratio").unwrap_or(1.0);
                let good = record.yes("listed") == Some(true) && beside < 1.5;
                if good { String::new() } else { format!("{} {beside}", record.text("words")) }
            })
            .filter(|words| !words.is_empty())
            .collect();
        assert!(wrong.is_empty(), "{wrong:#?}");
    }
}
