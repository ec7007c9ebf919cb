//! Errors of the measurement: a log of joint values that lags, a wrong unit of length, a beam that bends, an offset along it.

use crate::hypotheses::driver::Driver;
use crate::hypotheses::family::Family;
use crate::hypotheses::hypothesis::Hypothesis;
use crate::hypotheses::place::Place;
use crate::hypotheses::setting::Setting;
use crate::hypotheses::variant::Variant;
use crate::hypotheses::view::TraceView;
use truepose_errormodel::effects::{Instrument, InstrumentMode};
use truepose_errormodel::{AnyEffect, Signal};
use truepose_kinematics::JointId;

fn of(mode: &str, place: Place) -> Place {
    Place { mode: Some(mode.into()), ..place }
}

/// Poses in which a joint has to move, so that its last move is no constant.
const FEWEST: usize = 4;

/// The recorded joint values lag behind the joints: in one joint, or in all of them.
#[derive(Debug)]
pub(crate) struct JointLog;

/// The instrument has another unit of length.
#[derive(Debug)]
pub(crate) struct LengthScale;

impl Hypothesis for JointLog {
    fn family(&self) -> Family {
        Family::Instrument
    }

    fn variants(&self, setting: &Setting<'_>) -> Vec<Variant> {
        let chain = setting.chain;
        let moved = |joint: &&JointId| setting.moves(**joint).len() >= FEWEST;
        let joints: Vec<JointId> = chain.movable().iter().filter(moved).copied().collect();
        let mut all = Vec::new();
        if joints.len() > 1 {
            let each = Instrument::lag(&joints);
            all.push(Variant::new(of("lag", Place::default()), Instrument { shared: true, ..each.clone() }));
            all.push(Variant::new(of("lag", Place::default()), each));
        }
        let one =
            |&joint: &JointId| Variant::new(of("lag", Place::joint(chain, joint)), Instrument::lag(&[joint]));
        all.extend(joints.iter().map(one));
        all
    }

    fn meaning(&self, place: &Place) -> String {
        format!(
            "The recorded value of {} falls short by a fraction of its last move: values that are filtered, rounded or read late, or a \
             drive that had not settled. Log later after the move, or use the commanded values. Commands are not corrected for it.",
            place.joint.as_deref().unwrap_or("each joint")
        )
    }

    fn drivers(&self, place: &Place, _: &[Box<dyn AnyEffect>]) -> Vec<Driver> {
        place.joint.clone().map(Driver::Joint).into_iter().collect()
    }

    fn view(&self, place: &Place, effects: &[Box<dyn AnyEffect>]) -> TraceView {
        let channels = effects.iter().flat_map(|effect| effect.needs()).filter_map(|need| match need {
            Signal::Channel(name) => Some(Driver::Channel(name)),
            _ => None,
        });
        if place.joint.is_some() { TraceView::of_motion(channels) } else { TraceView::of_site(channels) }
    }
}

impl Hypothesis for LengthScale {
    fn family(&self) -> Family {
        Family::Instrument
    }

    fn variants(&self, _: &Setting<'_>) -> Vec<Variant> {
        vec![Variant::new(of("scale", Place::default()), Instrument::scale())]
    }

    fn meaning(&self, _: &Place) -> String {
        "All measured lengths are longer or shorter by one fraction: the scale of the instrument, its refraction index or scale bar, or \
         every length and scale of the robot alike. Measure a known length to tell which. Commands are not corrected for it."
            .into()
    }
}

/// The beam of the instrument bends.
#[derive(Debug)]
pub(crate) struct Refraction;

/// The instrument or its reflector has an offset along the line of sight.
#[derive(Debug)]
pub(crate) struct LineOfSight;

impl Hypothesis for Refraction {
    fn family(&self) -> Family {
        Family::Instrument
    }

    fn variants(&self, _: &Setting<'_>) -> Vec<Variant> {
        vec![Variant::new(of("refraction", Place::default()), Instrument::of(InstrumentMode::Refraction))]
    }

    fn meaning(&self, _: &Place) -> String {
        "Measured points are too high or too low by the square of their distance: the beam bends in air that is warmer above than below. Keep it \
         away from heaters and sunlit walls, stir the air, or move the instrument nearer. Commands are not corrected for it."
            .into()
    }
}

impl Hypothesis for LineOfSight {
    fn family(&self) -> Family {
        Family::Instrument
    }

    fn variants(&self, _: &Setting<'_>) -> Vec<Variant> {
        vec![Variant::new(of("sight", Place::default()), Instrument::of(InstrumentMode::Sight))]
    }

    fn meaning(&self, _: &Place) -> String {
        "All points are too far or too near along the line of sight: check the centring of the reflector, the constant of its ball or nest, and \
         the zero of the distance meter. Commands are not corrected for it."
            .into()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use truepose_errormodel::Dataset;
    use truepose_kinematics::{Load, samples};

    #[test]
    fn a_log_lags_in_joints_that_move_alone_and_together() {
        let chain = samples::ur10();
        let rows = 12;
        let mut joints: Vec<Vec<f64>> =
            (0..6).map(|j| (0..rows).map(|row| (0.7 * f64::from(row * (j + 3))).sin()).collect()).collect();
        joints[4] = vec![0.2; rows as usize];
        let rows = rows as usize;
        let data = Dataset {
            joints,
            position: vec![[0.0; 3]; rows],
            target: vec![None; rows],
            visit: (0..rows).collect(),
            load: vec![Load::None; rows],
            time: vec![0.0; rows],
            approach: vec![vec![0.0; rows]; 6],
            ..Dataset::default()
        };
        let all = JointLog.variants(&Setting::new(&chain, &data));
        let words: Vec<String> = all.iter().map(|variant| variant.place.words()).collect();
        assert_eq!(words, ["lag", "lag", "lag j1", "lag j2", "lag j3", "lag j4", "lag j6"]);
        assert!(all.iter().all(|v| v.change.effects().iter().all(|effect| effect.validate(&chain).is_ok())));
        assert!(JointLog.meaning(&all[3].place).contains("value of j2 falls"));
    }
}
