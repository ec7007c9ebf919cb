//! What yields in proportion to its load: joints, links, the base; with declared and with free weights.

use crate::hypotheses::candidate::Candidate;
use crate::hypotheses::family::Family;
use crate::hypotheses::place::Place;
use crate::hypotheses::setting::Setting;
use truepose_errormodel::effects::{
    BaseCompliance, JointCompliance, LinkCompliance, LoadNonlinearity, OwnWeight, Section, Tilt,
};
use truepose_kinematics::FrameId;

pub(crate) fn add(setting: &Setting<'_>, all: &mut Vec<Candidate>) {
    let chain = setting.chain;
    let weights_declared = chain.joints().iter().all(|joint| joint.link.is_some());
    for &joint in chain.movable() {
        let place = Place::joint(chain, joint);
        let yields = JointCompliance::of(joint);
        all.push(Candidate::new(Family::JointCompliance, place.clone(), yields.clone()));
        if !weights_declared {
            for links in [1, 2] {
                let free = JointCompliance { own_weight: OwnWeight::Free, links, ..yields.clone() };
                all.push(Candidate::new(Family::JointCompliance, place.clone(), free));
            }
        }
        for powers in [vec![2], vec![3], vec![2, 3]] {
            let effect = LoadNonlinearity::with_powers(joint, powers);
            all.push(Candidate::new(Family::LoadNonlinearity, place.clone(), effect));
        }
        let largest = setting.largest_load(joint);
        for share in [0.05, 0.2, 0.6].iter().filter(|_| largest > 0.0) {
            let effect = LoadNonlinearity::soft(joint, share * largest);
            all.push(Candidate::new(Family::LoadNonlinearity, place.clone(), effect));
        }
        for section in [Section::Tube, Section::Symmetric, Section::General] {
            let bends = LinkCompliance { section, ..LinkCompliance::of(joint) };
            all.push(Candidate::new(Family::LinkCompliance, place.clone(), bends.clone()));
            if !weights_declared {
                let free = LinkCompliance { own_weight: OwnWeight::Free, ..bends };
                all.push(Candidate::new(Family::LinkCompliance, place.clone(), free));
            }
        }
    }
    let base = Place::frame(chain, FrameId::BASE);
    for (tilt, sink) in [(Tilt::Isotropic, false), (Tilt::Isotropic, true), (Tilt::Separate, true)] {
        let effect = BaseCompliance { tilt, sink };
        all.push(Candidate::new(Family::BaseCompliance, base.clone(), effect));
    }
}
