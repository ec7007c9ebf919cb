//! Slides whose rail is not straight.

use crate::hypotheses::components::others;
use crate::hypotheses::driver::Driver;
use crate::hypotheses::family::Family;
use crate::hypotheses::hypothesis::Hypothesis;
use crate::hypotheses::penalty::Penalty;
use crate::hypotheses::place::Place;
use crate::hypotheses::setting::Setting;
use crate::hypotheses::variant::Variant;
use truepose_errormodel::AnyEffect;
use truepose_errormodel::effects::Guideway;
use truepose_kinematics::Axis;

/// A slide errs as it travels.
#[derive(Debug)]
pub(crate) struct Rail;

impl Hypothesis for Rail {
    fn family(&self) -> Family {
        Family::Guideway
    }

    fn variants(&self, setting: &Setting<'_>) -> Vec<Variant> {
        let chain = setting.chain;
        let mut all = Vec::new();
        for &joint in chain.movable().iter().filter(|&&joint| setting.slides(joint)) {
            let Some(range) = setting.range(joint) else { continue };
            let place = Place::joint(chain, joint);
            let whole = Guideway { range: Some(range), ..Guideway::of(joint) };
            for pieces in [1, 2, 4, 6, 8, 11, 15] {
                let smooth = Guideway { pieces, ..whole.clone() };
                all.push(Variant::new(place.clone(), smooth.clone()));
                let turns = Guideway {
                    components: Some(vec![Axis::Ty, Axis::Tz, Axis::Rx, Axis::Ry, Axis::Rz]),
                    ..smooth.clone()
                };
                all.push(Variant::new(place.clone(), turns));
                if pieces <= 8 {
                    for axis in Axis::ALL {
                        let one = Guideway { components: Some(vec![axis]), ..smooth.clone() };
                        all.push(Variant::new(place.clone(), one));
                    }
                }
            }
        }
        all
    }

    fn meaning(&self, place: &Place) -> String {
        format!(
            "The linear guideway of {} has errors of straightness or angle along its travel. Inspect its bolts, shims and \
             carriage.",
            place.part()
        )
    }

    fn drivers(&self, place: &Place, _: &[Box<dyn AnyEffect>]) -> Vec<Driver> {
        place.joint.clone().map(Driver::Joint).into_iter().collect()
    }

    fn penalty(&self, _: &[Box<dyn AnyEffect>]) -> Penalty {
        Penalty::MarginalLikelihood
    }

    fn neighbours(&self, effect: &dyn AnyEffect) -> Vec<Box<dyn AnyEffect>> {
        let Some(rail) = effect.concrete::<Guideway>() else { return Vec::new() };
        others(rail.components.as_deref())
            .map(|axes| Guideway { components: Some(axes), ..rail.clone() }.boxed())
            .collect()
    }
}
