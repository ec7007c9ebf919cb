//! Constant errors of frames and of single targets.

use crate::hypotheses::candidate::Candidate;
use crate::hypotheses::family::Family;
use crate::hypotheses::place::Place;
use crate::hypotheses::setting::Setting;
use truepose_errormodel::effects::{Expansion, Place as At};
use truepose_kinematics::{Axis, TargetId};

pub(crate) fn add(setting: &Setting<'_>, all: &mut Vec<Candidate>) {
    let chain = setting.chain;
    for frame in chain.frames() {
        let at = At::Frame { frame, components: Axis::ALL.to_vec() };
        let effect = Expansion { at, factors: Vec::new() };
        all.push(Candidate::new(Family::Geometric, Place::frame(chain, frame), effect));
    }
    for target in (0..chain.targets().len()).map(TargetId) {
        let at = At::Target { target, components: Axis::TRANSLATIONS.to_vec() };
        let effect = Expansion { at, factors: Vec::new() };
        all.push(Candidate::new(Family::Target, Place::target(chain, target), effect));
    }
}
