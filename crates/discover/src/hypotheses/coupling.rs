//! A joint error that depends on another joint.

use crate::hypotheses::driver::Driver;
use crate::hypotheses::family::Family;
use crate::hypotheses::hypothesis::Hypothesis;
use crate::hypotheses::limits::Limit;
use crate::hypotheses::place::Place;
use crate::hypotheses::setting::Setting;
use crate::hypotheses::variant::Variant;
use crate::hypotheses::view::TraceView;
use truepose_errormodel::AnyEffect;
use truepose_errormodel::effects::Coupling;

/// Another joint drags a joint along.
#[derive(Debug)]
pub(crate) struct Drag;

impl Hypothesis for Drag {
    fn family(&self) -> Family {
        Family::Coupling
    }

    fn variants(&self, setting: &Setting<'_>) -> Vec<Variant> {
        let chain = setting.chain;
        let mut all = Vec::new();
        for &joint in chain.movable().iter().filter(|&&joint| setting.range(joint).is_some()) {
            for &driver in chain.movable().iter().filter(|&&driver| driver != joint) {
                let Some(range) = setting.range(driver) else { continue };
                let place =
                    Place { driver: Some(chain.joint(driver).name.clone()), ..Place::joint(chain, joint) };
                let linear = Coupling { range: Some(range), ..Coupling::of(joint, driver) };
                for degree in [1, 2, 3] {
                    all.push(Variant::new(place.clone(), Coupling { degree, ..linear.clone() }));
                }
                if !setting.slides(driver) {
                    let effect = Coupling { degree: 0, harmonics: vec![1], ..linear };
                    all.push(Variant::new(place, effect));
                }
            }
        }
        all
    }

    fn meaning(&self, place: &Place) -> String {
        let driver = place.driver.as_deref().unwrap_or("another joint");
        format!(
            "The error of {} depends on the position of {driver}: belts, wrist gears or the calibration of coupled axes.",
            place.part()
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
}
