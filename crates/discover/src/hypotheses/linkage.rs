//! A parallelogram or four-bar between a joint and the one in front of it.

use crate::hypotheses::driver::Driver;
use crate::hypotheses::family::Family;
use crate::hypotheses::hypothesis::Hypothesis;
use crate::hypotheses::limits::Limit;
use crate::hypotheses::nonlinear::{Nonlinear, Refinement};
use crate::hypotheses::place::Place;
use crate::hypotheses::setting::Setting;
use crate::hypotheses::variant::Variant;
use crate::hypotheses::view::TraceView;
use std::f64::consts::{FRAC_PI_2, PI};
use truepose_errormodel::AnyEffect;
use truepose_errormodel::effects::Coupling;

/// The farthest that the angle of a linkage comes to its dead centre, rad.
const DEAD_CENTRE: f64 = 0.15;

/// The links of a closed chain are not as long as drawn.
#[derive(Debug)]
pub(crate) struct Parallelogram;

impl Hypothesis for Parallelogram {
    fn family(&self) -> Family {
        Family::Coupling
    }

    // One pair a joint: a linkage leads past one joint.
    fn variants(&self, setting: &Setting<'_>) -> Vec<Variant> {
        let chain = setting.chain;
        let mut all = Vec::new();
        for pair in chain.movable().windows(2) {
            let (driver, joint) = (pair[0], pair[1]);
            if setting.slides(joint) || setting.slides(driver) {
                continue;
            }
            let (Some(a), Some(b)) = (chain.coordinate(driver), chain.coordinate(joint)) else { continue };
            let moved = setting.range(joint).is_some() && setting.range(driver).is_some();
            for crossed in [false, true].into_iter().filter(|_| moved) {
                let sign = if crossed { -1.0 } else { 1.0 };
                let angles =
                    || setting.data.joints[b].iter().zip(&setting.data.joints[a]).map(|(b, a)| b + sign * a);
                let lower = angles().fold(f64::INFINITY, f64::min);
                let upper = angles().fold(f64::NEG_INFINITY, f64::max);
                // A linkage that passes its dead centre is none.
                if upper - lower > PI - 2.0 * DEAD_CENTRE {
                    continue;
                }
                let place = Place {
                    driver: Some(chain.joint(driver).name.clone()),
                    mode: Some("linkage".into()),
                    ..Place::joint(chain, joint)
                };
                let effect = Coupling::linkage(joint, driver, FRAC_PI_2 - 0.5 * (lower + upper), crossed);
                all.push(Variant::new(place, effect));
            }
        }
        all
    }

    fn meaning(&self, place: &Place) -> String {
        format!(
            "The error of {} follows the angle of a closed linkage with {}: crank, rod or rocker of the parallelogram are not as long as \
             described. Measure their lengths, and inspect their bearings.",
            place.part(),
            place.driver.as_deref().unwrap_or("another joint")
        )
    }

    fn drivers(&self, place: &Place, _: &[Box<dyn AnyEffect>]) -> Vec<Driver> {
        place.driver.clone().map(Driver::Joint).into_iter().collect()
    }

    fn view(&self, place: &Place, effects: &[Box<dyn AnyEffect>]) -> TraceView {
        TraceView::of_motion(self.drivers(place, effects))
    }

    fn limits(&self) -> &[Limit] {
        &[Limit::DriveAngle]
    }

    fn nonlinear(&self, effect: &dyn AnyEffect) -> Option<Nonlinear> {
        let at = effect.concrete::<Coupling>()?.offset?;
        Some(Nonlinear::new(at, Refinement::Within([at - REACH, at + REACH])))
    }

    fn with_value(
        &self,
        effect: &dyn AnyEffect,
        value: f64,
        range: Option<[f64; 2]>,
    ) -> Option<Box<dyn AnyEffect>> {
        let linkage = effect.concrete::<Coupling>()?.clone();
        Some(Box::new(Coupling { offset: Some(value), offset_range: range, ..linkage }))
    }
}

/// How far from the middle the angle of a linkage is looked for, rad.
const REACH: f64 = 0.7;
