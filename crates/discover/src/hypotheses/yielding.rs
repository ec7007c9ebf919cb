//! Joints that yield otherwise than at once and about their axis: bearings that tilt, creep, a stiffness that changes with the temperature.
//!
//! One place a joint for each, and for each own temperature of the data: as many candidates as joints times channels, where the joint is loaded.

use crate::hypotheses::driver::Driver;
use crate::hypotheses::family::Family;
use crate::hypotheses::hypothesis::Hypothesis;
use crate::hypotheses::limits::Limit;
use crate::hypotheses::nonlinear::{Nonlinear, Refinement};
use crate::hypotheses::place::Place;
use crate::hypotheses::self_heating::clock;
use crate::hypotheses::setting::Setting;
use crate::hypotheses::variant::Variant;
use crate::hypotheses::view::TraceView;
use std::f64::consts::FRAC_PI_4;
use truepose_errormodel::AnyEffect;
use truepose_errormodel::effects::JointCompliance;
use truepose_kinematics::JointId;

/// A bearing tilts under the moment across its axis.
#[derive(Debug)]
pub(crate) struct TiltingBearing;

/// A part of a joint's deflection comes late.
#[derive(Debug)]
pub(crate) struct Creep;

/// A joint is more compliant when it is warm.
#[derive(Debug)]
pub(crate) struct SoftWhenWarm;

fn of(mode: &str, setting: &Setting<'_>, joint: JointId) -> Place {
    Place { mode: Some(mode.into()), ..Place::joint(setting.chain, joint) }
}

/// Of the load of the joint that carries most, below which a joint carries nothing.
const CARRIES: f64 = 1e-2;

/// Joints whose load differs between poses.
fn loaded(setting: &Setting<'_>) -> std::vec::IntoIter<JointId> {
    let swing = |&joint: &JointId| {
        let load = setting.load_range(joint).map_or(0.0, |[lower, upper]| upper - lower);
        (joint, setting.slides(joint), load)
    };
    let all: Vec<(JointId, bool, f64)> = setting.chain.movable().iter().map(swing).collect();
    // Newton metres with newton metres, newtons with newtons.
    let most = |slides: bool| all.iter().filter(|one| one.1 == slides).map(|one| one.2).fold(0.0, f64::max);
    let carries = |one: &&(JointId, bool, f64)| one.2 > CARRIES * most(one.1);
    all.iter().filter(carries).map(|one| one.0).collect::<Vec<_>>().into_iter()
}

impl Hypothesis for TiltingBearing {
    fn family(&self) -> Family {
        Family::JointCompliance
    }

    // The moment across an axis needs weights, not a load about that axis.
    fn variants(&self, setting: &Setting<'_>) -> Vec<Variant> {
        if loaded(setting).next().is_none() {
            return Vec::new();
        }
        let one =
            |&joint: &JointId| Variant::new(of("bearing", setting, joint), JointCompliance::bearing(joint));
        setting.chain.movable().iter().map(one).collect()
    }

    fn meaning(&self, place: &Place) -> String {
        format!(
            "{} tilts across its axis under load. Inspect the preload of its bearing and the bolts of its flange.",
            place.part()
        )
    }

    fn drivers(&self, _: &Place, _: &[Box<dyn AnyEffect>]) -> Vec<Driver> {
        vec![Driver::Wrench]
    }

    // A link that bends behind the joint is nearly the same.
    fn rank(&self) -> Family {
        Family::LinkCompliance
    }

    fn limits(&self) -> &[Limit] {
        &[Limit::FirstNotNegative]
    }
}

impl Hypothesis for Creep {
    fn family(&self) -> Family {
        Family::JointCompliance
    }

    fn variants(&self, setting: &Setting<'_>) -> Vec<Variant> {
        let Some((lags, _)) = clock(setting) else { return Vec::new() };
        let place = |joint| of("creep", setting, joint);
        let one = |joint| {
            let at = |&lag: &f64| Variant::new(place(joint), JointCompliance::creep(joint, lag));
            lags.iter().map(at).collect::<Vec<_>>()
        };
        loaded(setting).flat_map(one).collect()
    }

    fn meaning(&self, place: &Place) -> String {
        format!(
            "{} goes on yielding after its load has changed: creep of its gear, belt or mounting. Wait after a change of load, and inspect \
             plastic parts, glued joints and preload.",
            place.part()
        )
    }

    fn drivers(&self, _: &Place, _: &[Box<dyn AnyEffect>]) -> Vec<Driver> {
        vec![Driver::Wrench]
    }

    fn view(&self, _: &Place, _: &[Box<dyn AnyEffect>]) -> TraceView {
        TraceView::of_motion([Driver::Time])
    }

    fn rank(&self) -> Family {
        Family::Shift
    }

    fn limits(&self) -> &[Limit] {
        &[Limit::FirstNotNegative]
    }

    fn nonlinear(&self, effect: &dyn AnyEffect) -> Option<Nonlinear> {
        Some(Nonlinear::new(effect.concrete::<JointCompliance>()?.lag?, Refinement::Scale([0.4, 2.5])))
    }

    fn with_value(
        &self,
        effect: &dyn AnyEffect,
        value: f64,
        range: Option<[f64; 2]>,
    ) -> Option<Box<dyn AnyEffect>> {
        let creep = effect.concrete::<JointCompliance>()?.clone();
        Some(Box::new(JointCompliance { lag: Some(value), lag_range: range, ..creep }))
    }
}

impl Hypothesis for SoftWhenWarm {
    fn family(&self) -> Family {
        Family::JointCompliance
    }

    fn variants(&self, setting: &Setting<'_>) -> Vec<Variant> {
        let mut all = Vec::new();
        for (k, channel) in setting.data.schema.channels.iter().enumerate() {
            let own = channel.temperature && setting.data.late(&channel.name).is_none();
            let (Some([lower, upper]), true) = (setting.channel_range(k), own) else { continue };
            for joint in loaded(setting) {
                let effect = JointCompliance::by_temperature(joint, &channel.name, 0.5 * (lower + upper));
                all.push(Variant::new(of("temperature", setting, joint).following(&channel.name), effect));
            }
        }
        all
    }

    fn meaning(&self, place: &Place) -> String {
        format!(
            "The stiffness of {} changes with {}. Warm up before measuring, and inspect the lubricant and preload of its gear.",
            place.part(),
            place.channel.as_deref().unwrap_or("a temperature")
        )
    }

    fn drivers(&self, _: &Place, _: &[Box<dyn AnyEffect>]) -> Vec<Driver> {
        vec![Driver::Wrench, Driver::Time]
    }

    fn view(&self, place: &Place, _: &[Box<dyn AnyEffect>]) -> TraceView {
        TraceView::of_motion(place.joint.clone().map(Driver::JointLoad))
    }

    fn rank(&self) -> Family {
        Family::LoadNonlinearity
    }
}

/// A spring or counterbalance turns a joint.
#[derive(Debug)]
pub(crate) struct Counterbalance;

/// Levers of which one is about twice the other: 2ab/(a² + b²).
const RATIO: f64 = 0.8;

impl Hypothesis for Counterbalance {
    fn family(&self) -> Family {
        Family::JointCompliance
    }

    fn variants(&self, setting: &Setting<'_>) -> Vec<Variant> {
        // Two coefficients, the angle at which the spring is shortest, and the ratio of its levers.
        let turns = |joint: &&JointId| !setting.slides(**joint) && setting.levels(**joint).determine(4);
        let at = |&joint: &JointId| {
            (0..8).map(move |k| {
                let effect = JointCompliance::counterbalance(joint, f64::from(k) * FRAC_PI_4, RATIO);
                Variant::new(of("counterbalance", setting, joint), effect)
            })
        };
        setting.chain.movable().iter().filter(turns).flat_map(at).collect()
    }

    fn meaning(&self, place: &Place) -> String {
        format!(
            "A spring turns {}: a counterbalance or balancer with another force than was thought, or none that was declared. Check its pressure \
             or preload, and its levers.",
            place.part()
        )
    }

    fn drivers(&self, place: &Place, _: &[Box<dyn AnyEffect>]) -> Vec<Driver> {
        place.joint.clone().map(Driver::Joint).into_iter().collect()
    }

    fn view(&self, place: &Place, effects: &[Box<dyn AnyEffect>]) -> TraceView {
        TraceView::of_motion(self.drivers(place, effects))
    }

    // An eccentric gear is nearly the same, and simpler.
    fn rank(&self) -> Family {
        Family::Coupling
    }

    fn limits(&self) -> &[Limit] {
        &[Limit::DriveAngle]
    }

    fn nonlinear(&self, effect: &dyn AnyEffect) -> Option<Nonlinear> {
        let offset = effect.concrete::<JointCompliance>()?.offset?;
        Some(Nonlinear::new(offset, Refinement::Within([offset - FRAC_PI_4, offset + FRAC_PI_4])))
    }

    fn with_value(
        &self,
        effect: &dyn AnyEffect,
        value: f64,
        range: Option<[f64; 2]>,
    ) -> Option<Box<dyn AnyEffect>> {
        let spring = effect.concrete::<JointCompliance>()?.clone();
        Some(Box::new(JointCompliance { offset: Some(value), offset_range: range, ..spring }))
    }

    fn second(&self, effect: &dyn AnyEffect) -> Option<Nonlinear> {
        let ratio = effect.concrete::<JointCompliance>()?.ratio?;
        Some(Nonlinear::new(ratio, Refinement::Within([0.2, 0.98])))
    }

    fn with_second(
        &self,
        effect: &dyn AnyEffect,
        value: f64,
        range: Option<[f64; 2]>,
    ) -> Option<Box<dyn AnyEffect>> {
        let spring = effect.concrete::<JointCompliance>()?.clone();
        Some(Box::new(JointCompliance { ratio: Some(value), ratio_range: range, ..spring }))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use truepose_errormodel::{Channel, Dataset};
    use truepose_kinematics::{Load, Payload, samples};

    #[test]
    fn candidates_grow_with_joints_and_own_temperatures() {
        let chain = samples::ur10();
        let rows = 40;
        let mut data = Dataset {
            joints: (0..6)
                .map(|j| (0..rows).map(|row| (0.7 * ((row * (j + 3)) as f64)).sin()).collect())
                .collect(),
            position: vec![[0.0; 3]; rows],
            target: vec![None; rows],
            visit: (0..rows).collect(),
            load: vec![Load::Payload(Payload { mass: 5.0, com: [0.1, 0.0, 0.0].into() }); rows],
            time: (0..rows).map(|row| 30.0 * row as f64).collect(),
            approach: vec![vec![0.0; rows]; 6],
            ..Dataset::default()
        };
        data.schema.time = true;
        let oil = Channel { name: "oil".into(), unit: "degC".into(), temperature: true };
        data.schema.channels.push(oil);
        data.channels.push((0..rows).map(|row| 20.0 + (0.3 * row as f64).sin()).collect());
        data.follow_late("oil", 200.0);
        let setting = Setting::new(&chain, &data);
        // No weight turns the first joint, whose axis is upright.
        assert_eq!(SoftWhenWarm.variants(&setting).len(), 5);
        assert_eq!((TiltingBearing.variants(&setting).len(), Creep.variants(&setting).len()), (6, 5 * 4));
        let warm = &SoftWhenWarm.variants(&setting)[0];
        assert_eq!(warm.place.words(), "temperature j2 on oil");
        assert!(warm.change.effects().iter().all(|effect| effect.validate(&chain).is_ok()));
        data.load.fill(Load::None);
        let setting = Setting::new(&chain, &data);
        assert!(TiltingBearing.variants(&setting).is_empty() && Creep.variants(&setting).is_empty());
    }
}
