//! Errors of a joint that are periodic in its own motion: gears, belts, screws.

use crate::hypotheses::backlash::parts;
use crate::hypotheses::driver::Driver;
use crate::hypotheses::family::Family;
use crate::hypotheses::hypothesis::Hypothesis;
use crate::hypotheses::limits::Limit;
use crate::hypotheses::nonlinear::{Nonlinear, Refinement};
use crate::hypotheses::place::Place;
use crate::hypotheses::setting::Setting;
use crate::hypotheses::variant::Variant;
use crate::hypotheses::view::TraceView;
use std::f64::consts::TAU;
use truepose_errormodel::AnyEffect;
use truepose_errormodel::effects::Transmission;
use truepose_kinematics::JointId;

/// A drive errs periodically.
#[derive(Debug)]
pub(crate) struct Drive;

impl Hypothesis for Drive {
    fn family(&self) -> Family {
        Family::Transmission
    }

    fn variants(&self, setting: &Setting<'_>) -> Vec<Variant> {
        let chain = setting.chain;
        let mut all = Vec::new();
        for &joint in chain.movable() {
            let Some([lower, upper]) = setting.range(joint) else { continue };
            let place = Place::joint(chain, joint);
            let turns = !setting.slides(joint);
            let levels = setting.levels(joint);
            if turns {
                let series =
                    [vec![1], vec![2], vec![1, 2], vec![1, 2, 3], vec![1, 2, 3, 4], vec![3], vec![4]];
                for harmonics in series.into_iter().filter(|series| levels.determine_harmonics(series)) {
                    let effect =
                        Transmission { period: Some(TAU), ..Transmission::turning(joint, harmonics) };
                    all.push(Variant::new(place.clone(), effect));
                }
            }
            // Long periods that the quick scan leaves out.
            let travel = upper - lower;
            let unit = if turns { TAU } else { 2.0 * travel };
            let periods = (1..=8).map(|cycles| unit / (0.5 + 0.4 * f64::from(cycles)));
            for period in
                periods.filter(|&p| (levels.shortest_period()..=longest(turns, travel)).contains(&p))
            {
                all.push(Variant::new(place.clone(), Transmission::of(joint, period)));
            }
        }
        all
    }

    fn meaning(&self, place: &Place) -> String {
        format!(
            "The transmission error of {} is periodic: eccentricity, gear mesh, strain wave gear or lead screw.",
            place.part()
        )
    }

    fn drivers(&self, place: &Place, _: &[Box<dyn AnyEffect>]) -> Vec<Driver> {
        place.joint.clone().map(Driver::Joint).into_iter().collect()
    }

    fn view(&self, place: &Place, effects: &[Box<dyn AnyEffect>]) -> TraceView {
        TraceView::of_motion(self.drivers(place, effects))
    }

    fn limits(&self) -> &[Limit] {
        &[Limit::DriveAngle]
    }

    fn nonlinear(&self, effect: &dyn AnyEffect) -> Option<Nonlinear> {
        let wave = effect.concrete::<Transmission>()?;
        Some(Nonlinear::new(free_period(wave)?, Refinement::Period(wave.joint)))
    }

    fn with_value(
        &self,
        effect: &dyn AnyEffect,
        value: f64,
        range: Option<[f64; 2]>,
    ) -> Option<Box<dyn AnyEffect>> {
        let wave = effect.concrete::<Transmission>()?.clone();
        Some(Box::new(Transmission { period: Some(value), period_range: range, ..wave }))
    }

    // The same harmonics with an amplitude that follows the load.
    fn richer(&self, effect: &dyn AnyEffect) -> Option<Box<dyn AnyEffect>> {
        let wave = effect.concrete::<Transmission>()?.clone();
        Some(Box::new(Transmission { by_load: true, ..wave }))
    }

    // The same in a part of the travel: local wear.
    fn richer_in(&self, effect: &dyn AnyEffect, setting: &Setting<'_>) -> Vec<Box<dyn AnyEffect>> {
        let Some(wave) = effect.concrete::<Transmission>() else { return Vec::new() };
        let mut all: Vec<Box<dyn AnyEffect>> = self.richer(effect).into_iter().collect();
        if wave.between.is_none() {
            let worn = |part| Transmission { between: Some(part), ..wave.clone() }.boxed();
            all.extend(parts(setting, wave.joint).map(worn));
        }
        all
    }

    fn at_period(&self, joint: JointId, period: f64) -> Option<Box<dyn AnyEffect>> {
        Some(Box::new(Transmission::of(joint, period)))
    }
}

/// A period that is not known; a turn of the joint is.
fn free_period(wave: &Transmission) -> Option<f64> {
    wave.period.filter(|p| (p - TAU).abs() > 1e-9)
}

/// The longest period that an error of a drive may have and that is found rather than known, rad or m: the visited travel, and at most a turn
/// and a little. Of what is slower not even one cycle was seen: it is a curve, and no drive's period.
pub(crate) fn longest(turns: bool, travel: f64) -> f64 {
    if turns { travel.min(TAU / 0.9) } else { travel }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_period_is_a_nonlinear_parameter_unless_it_is_one_turn() {
        let joint = JointId(2);
        let wave = Drive.at_period(joint, 0.2).unwrap();
        let found = Drive.nonlinear(&*wave).unwrap();
        assert_eq!(found, Nonlinear::new(0.2, Refinement::Period(joint)));
        let free = Drive.with_value(&*wave, 0.3, Some([0.1, 0.4])).unwrap();
        assert_eq!((free.shape()[0].value, free.shape()[0].lower), (0.3, 0.1));
        assert_eq!(Drive.nonlinear(&*Drive.at_period(joint, TAU).unwrap()), None);
    }
}
