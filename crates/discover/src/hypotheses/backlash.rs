//! Backlash: a joint error that switches with the side of approach or with the load.

use crate::hypotheses::driver::Driver;
use crate::hypotheses::family::Family;
use crate::hypotheses::hypothesis::Hypothesis;
use crate::hypotheses::limits::Limit;
use crate::hypotheses::nonlinear::{Nonlinear, Refinement, concrete};
use crate::hypotheses::place::Place;
use crate::hypotheses::setting::Setting;
use crate::hypotheses::variant::Variant;
use crate::hypotheses::view::TraceView;
use truepose_errormodel::AnyEffect;
use truepose_errormodel::effects::{Backlash, Side};
use truepose_kinematics::JointId;

/// A joint has backlash.
#[derive(Debug)]
pub(crate) struct LostMotion;

impl Hypothesis for LostMotion {
    fn family(&self) -> Family {
        Family::Backlash
    }

    fn variants(&self, setting: &Setting<'_>) -> Vec<Variant> {
        let chain = setting.chain;
        let approach = setting.data.schema.approach;
        let mut all = Vec::new();
        for &joint in chain.movable().iter().filter(|&&joint| setting.range(joint).is_some()) {
            let place = Place::joint(chain, joint);
            if approach {
                all.push(Variant::new(place.clone(), Backlash::of(joint, Side::Approach)));
            }
            all.push(Variant::new(place.clone(), Backlash::of(joint, Side::Load)));
            for flank in flanks(setting, joint) {
                for side in [Side::Load, Side::LoadThenApproach] {
                    if side == Side::Load || approach {
                        let play = Backlash::of(joint, side);
                        let effect = Backlash { flank_load: Some(flank), flank_range: None, ..play };
                        all.push(Variant::new(place.clone(), effect));
                    }
                }
            }
        }
        all
    }

    fn meaning(&self, place: &Place) -> String {
        format!(
            "The error of {} switches with its direction of approach. Inspect gear backlash, belt tension and preload.",
            place.part()
        )
    }

    fn drivers(&self, place: &Place, _: &[Box<dyn AnyEffect>]) -> Vec<Driver> {
        place.joint.clone().map(Driver::Joint).into_iter().collect()
    }

    fn view(&self, place: &Place, effects: &[Box<dyn AnyEffect>]) -> TraceView {
        let play = effects.first().and_then(|effect| concrete::<Backlash>(&**effect));
        let by_load = play.is_some_and(|play| play.side != Side::Approach);
        let driver = if by_load { Driver::JointLoad } else { Driver::Joint };
        TraceView::of_motion(place.joint.clone().map(driver)).by_approach()
    }

    fn limits(&self) -> &[Limit] {
        &[Limit::DriveAngle]
    }

    fn nonlinear(&self, effect: &dyn AnyEffect) -> Option<Nonlinear> {
        let load = concrete::<Backlash>(effect)?.flank_load?;
        Some(Nonlinear::new(load, Refinement::Scale([0.4, 1.8])))
    }

    fn with_value(
        &self,
        effect: &dyn AnyEffect,
        value: f64,
        range: Option<[f64; 2]>,
    ) -> Option<Box<dyn AnyEffect>> {
        let play = concrete::<Backlash>(effect)?.clone();
        Some(Box::new(Backlash { flank_load: Some(value), flank_range: range, ..play }))
    }
}

/// Loads at which play may be taken up: shares of the largest load seen.
fn flanks(setting: &Setting<'_>, joint: JointId) -> Vec<f64> {
    let largest = setting.largest_load(joint);
    if largest > 0.0 { vec![0.03 * largest, 0.1 * largest, 0.25 * largest] } else { Vec::new() }
}
