//! Constant errors of frames and of single targets.

use crate::hypotheses::components::of_series;
use crate::hypotheses::driver::Driver;
use crate::hypotheses::family::Family;
use crate::hypotheses::hypothesis::Hypothesis;
use crate::hypotheses::place::Place;
use crate::hypotheses::setting::Setting;
use crate::hypotheses::variant::Variant;
use crate::hypotheses::view::TraceView;
use truepose_errormodel::AnyEffect;
use truepose_errormodel::effects::{Expansion, Place as At};
use truepose_kinematics::{Axis, TargetId};

/// A frame differs from the description.
#[derive(Debug)]
pub(crate) struct OfFrames;

impl Hypothesis for OfFrames {
    fn family(&self) -> Family {
        Family::Geometric
    }

    fn variants(&self, setting: &Setting<'_>) -> Vec<Variant> {
        let chain = setting.chain;
        let constant = |frame| {
            let at = At::Frame { frame, components: Axis::ALL.to_vec() };
            Variant::new(Place::frame(chain, frame), Expansion { at, factors: Vec::new() })
        };
        chain.frames().map(constant).collect()
    }

    fn meaning(&self, place: &Place) -> String {
        format!(
            "The frame of {} differs from the description. Inspect its seat and dowels, or correct the description.",
            place.part()
        )
    }

    fn view(&self, place: &Place, _: &[Box<dyn AnyEffect>]) -> TraceView {
        TraceView::of_site(place.joint.clone().map(Driver::Joint))
    }

    fn neighbours(&self, effect: &dyn AnyEffect) -> Vec<Box<dyn AnyEffect>> {
        of_series(effect)
    }
}

/// The position of a target differs from the description.
#[derive(Debug)]
pub(crate) struct OfTargets;

impl Hypothesis for OfTargets {
    fn family(&self) -> Family {
        Family::Target
    }

    fn variants(&self, setting: &Setting<'_>) -> Vec<Variant> {
        let chain = setting.chain;
        let constant = |target| {
            let at = At::Target { target, components: Axis::TRANSLATIONS.to_vec() };
            Variant::new(Place::target(chain, target), Expansion { at, factors: Vec::new() })
        };
        (0..chain.described_targets().len()).map(TargetId).map(constant).collect()
    }

    fn meaning(&self, place: &Place) -> String {
        let target = place.target.as_deref().unwrap_or("");
        format!("The position of target {target} differs from the description. Measure it again.")
    }

    fn view(&self, _: &Place, _: &[Box<dyn AnyEffect>]) -> TraceView {
        TraceView::of_site([Driver::Pose])
    }
}
