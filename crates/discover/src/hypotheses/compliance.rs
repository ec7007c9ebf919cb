//! What yields in proportion to its load: joints, links, the base; with declared and with free weights.

use crate::hypotheses::driver::Driver;
use crate::hypotheses::family::Family;
use crate::hypotheses::hypothesis::Hypothesis;
use crate::hypotheses::limits::Limit;
use crate::hypotheses::place::Place;
use crate::hypotheses::setting::Setting;
use crate::hypotheses::variant::Variant;
use crate::hypotheses::view::TraceView;
use truepose_errormodel::AnyEffect;
use truepose_errormodel::effects::{
    BaseCompliance, JointCompliance, LinkCompliance, OwnWeight, Section, Tilt,
};
use truepose_kinematics::{Chain, FrameId};

/// Whether the weights of all links are known.
pub(crate) fn weights_declared(chain: &Chain) -> bool {
    chain.joints().iter().all(|joint| joint.link.is_some())
}

/// A joint yields about or along its axis.
#[derive(Debug)]
pub(crate) struct OfJoints;

impl Hypothesis for OfJoints {
    fn family(&self) -> Family {
        Family::JointCompliance
    }

    fn variants(&self, setting: &Setting<'_>) -> Vec<Variant> {
        let chain = setting.chain;
        let mut all = Vec::new();
        for &joint in chain.movable() {
            let place = Place::joint(chain, joint);
            let yields = JointCompliance::of(joint);
            all.push(Variant::new(place.clone(), yields.clone()));
            if !weights_declared(chain) {
                for links in [1, 2] {
                    let free = JointCompliance { own_weight: OwnWeight::Free, links, ..yields.clone() };
                    all.push(Variant::new(place.clone(), free));
                }
            }
        }
        all
    }

    fn meaning(&self, place: &Place) -> String {
        format!(
            "The deflection of {} is proportional to the load about its axis: stiffness of gear, bearing or drive.",
            place.part()
        )
    }

    fn drivers(&self, _: &Place, _: &[Box<dyn AnyEffect>]) -> Vec<Driver> {
        vec![Driver::Wrench]
    }

    fn view(&self, place: &Place, _: &[Box<dyn AnyEffect>]) -> TraceView {
        TraceView::of_motion(place.joint.clone().map(Driver::JointLoad))
    }

    fn limits(&self) -> &[Limit] {
        &[Limit::FirstNotNegative]
    }
}

/// A link bends or twists.
#[derive(Debug)]
pub(crate) struct OfLinks;

impl Hypothesis for OfLinks {
    fn family(&self) -> Family {
        Family::LinkCompliance
    }

    fn variants(&self, setting: &Setting<'_>) -> Vec<Variant> {
        let chain = setting.chain;
        let mut all = Vec::new();
        for &joint in chain.movable() {
            let place = Place::joint(chain, joint);
            for section in [Section::Tube, Section::Symmetric, Section::General] {
                let bends = LinkCompliance { section, ..LinkCompliance::of(joint) };
                all.push(Variant::new(place.clone(), bends.clone()));
                if !weights_declared(chain) {
                    for links in [0, 2] {
                        let free = LinkCompliance { own_weight: OwnWeight::Free, links, ..bends.clone() };
                        all.push(Variant::new(place.clone(), free));
                    }
                }
            }
        }
        all
    }

    fn meaning(&self, place: &Place) -> String {
        format!(
            "The link behind {} bends or twists under load. Inspect its flange bolts and bearings; otherwise it is the \
             stiffness of the link.",
            place.part()
        )
    }

    fn drivers(&self, _: &Place, _: &[Box<dyn AnyEffect>]) -> Vec<Driver> {
        vec![Driver::Wrench]
    }

    fn limits(&self) -> &[Limit] {
        &[Limit::FirstNotNegative, Limit::BoundedWidth]
    }
}

/// The base tilts or sinks.
#[derive(Debug)]
pub(crate) struct OfBase;

impl Hypothesis for OfBase {
    fn family(&self) -> Family {
        Family::BaseCompliance
    }

    fn variants(&self, setting: &Setting<'_>) -> Vec<Variant> {
        let base = Place::frame(setting.chain, FrameId::BASE);
        let put = |yields: BaseCompliance| Variant::new(base.clone(), yields);
        let of = |tilt, sink| BaseCompliance { tilt, sink, ..BaseCompliance::default() };
        let mut all: Vec<Variant> =
            [(Tilt::Isotropic, false), (Tilt::Isotropic, true), (Tilt::Separate, true)]
                .map(|(tilt, sink)| put(of(tilt, sink)))
                .into();
        if !weights_declared(setting.chain) {
            let free = |tilt, links| BaseCompliance { own_weight: OwnWeight::Free, links, ..of(tilt, false) };
            all.extend([2, 3].map(|links| put(free(Tilt::Isotropic, links))));
            all.push(put(free(Tilt::Separate, 3)));
        }
        all
    }

    fn meaning(&self, _: &Place) -> String {
        "The base tilts or sinks under the load. Inspect its anchoring.".into()
    }

    fn drivers(&self, _: &Place, _: &[Box<dyn AnyEffect>]) -> Vec<Driver> {
        vec![Driver::Wrench]
    }

    fn limits(&self) -> &[Limit] {
        &[Limit::FirstNotNegative]
    }
}
