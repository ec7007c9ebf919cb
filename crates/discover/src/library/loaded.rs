//! What joints do as they are loaded, along a curve: a spring that is not straight; or, with no name, whatever follows the load.

use super::Setting;
use crate::{Candidate, Family, Place};
use truepose_errormodel::effects::{Basis, Expansion, Factor, Input, Place as At};
use truepose_kinematics::{Chain, JointId};

/// Equal pieces of the curves.
const PIECES: [usize; 2] = [2, 5];

/// Springs that are not straight.
pub(super) fn add(setting: &Setting<'_>, all: &mut Vec<Candidate>) {
    for (joint, [lower, upper]) in loaded(setting) {
        let place = Place::joint(setting.chain, joint);
        all.extend(PIECES.map(|pieces| {
            let basis = Basis::Spline { lower, upper, pieces, degree: 3 };
            Candidate::new(Family::LoadNonlinearity, place.clone(), curve(joint, basis))
        }));
    }
}

/// The same and straight ones, without a name.
pub(super) fn add_nameless(setting: &Setting<'_>, all: &mut Vec<Candidate>) {
    for (joint, [lower, upper]) in loaded(setting) {
        let place = Place::joint(setting.chain, joint).depending_on(&load_word(setting.chain, joint));
        let straight = Basis::Chebyshev { lower, upper, degrees: vec![1] };
        let curves = PIECES.map(|pieces| Basis::Spline { lower, upper, pieces, degree: 3 });
        all.extend(
            [straight]
                .into_iter()
                .chain(curves)
                .map(|basis| Candidate::new(Family::Unmodelled, place.clone(), curve(joint, basis))),
        );
    }
}

/// How the load about or along a joint is called where something depends on it.
pub(crate) fn load_word(chain: &Chain, joint: JointId) -> String {
    format!("load_{}", chain.joint(joint).name)
}

/// Joints with the range of their load.
fn loaded(setting: &Setting<'_>) -> impl Iterator<Item = (JointId, [f64; 2])> {
    setting.chain.movable().iter().filter_map(|&joint| Some((joint, setting.load_range(joint)?)))
}

/// A joint's own motion along a curve over its load.
fn curve(joint: JointId, basis: Basis) -> Expansion {
    Expansion { at: At::Motion { joint }, factors: vec![Factor { of: Input::Load(joint), basis }] }
}
