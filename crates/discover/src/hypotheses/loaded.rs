//! What joints do as they are loaded, along a curve: a spring that is not straight; or, with no name, whatever follows the load.

use crate::hypotheses::candidate::Candidate;
use crate::hypotheses::covariate::load_word;
use crate::hypotheses::family::Family;
use crate::hypotheses::place::Place;
use crate::hypotheses::setting::Setting;
use truepose_errormodel::effects::{Basis, Expansion, Factor, Input, Place as At};
use truepose_kinematics::JointId;

/// Equal pieces of the curves.
const PIECES: [usize; 2] = [2, 5];
/// And of those that may do anything from one to the next.
const AT_ONCE: [usize; 2] = [8, 20];

/// Springs that are not straight.
pub(crate) fn add(setting: &Setting<'_>, all: &mut Vec<Candidate>) {
    for (joint, [lower, upper]) in loaded(setting) {
        let place = Place::joint(setting.chain, joint);
        all.extend(PIECES.map(|pieces| {
            let basis = Basis::Spline { lower, upper, pieces, degree: 3 };
            Candidate::new(Family::LoadNonlinearity, place.clone(), curve(joint, basis))
        }));
    }
}

/// The same, straight ones, such as may do anything from one piece to the next, and the side of the load, without a name.
pub(crate) fn add_nameless(setting: &Setting<'_>, all: &mut Vec<Candidate>) {
    for (joint, range) in loaded(setting) {
        let [lower, upper] = range;
        let place = Place::joint(setting.chain, joint).depending_on(&load_word(setting.chain, joint));
        let straight = Basis::Chebyshev { lower, upper, degrees: vec![1] };
        let curves = PIECES.map(|pieces| Basis::Spline { lower, upper, pieces, degree: 3 });
        let jagged = AT_ONCE.iter().flat_map(|&pieces| [0, 1].map(|degree| pieces_of(range, pieces, degree)));
        all.extend(
            [straight]
                .into_iter()
                .chain(curves)
                .chain(jagged)
                .chain(sides(range))
                .map(|basis| Candidate::new(Family::Unmodelled, place.clone(), curve(joint, basis))),
        );
    }
}

/// Another value (degree 0) or slope (1) in each of so many equal pieces, of which two meet where the load changes its side.
fn pieces_of([lower, upper]: [f64; 2], pieces: usize, degree: usize) -> Basis {
    let width = (upper - lower) / pieces as f64;
    let (mut lower, mut pieces) = (lower, pieces);
    if lower < 0.0 && upper > 0.0 {
        let [below, above] = [-lower, upper].map(|end| (end / width).ceil());
        (lower, pieces) = (-below * width, (below + above) as usize);
    }
    Basis::Spline { lower, upper: lower + pieces as f64 * width, pieces, degree }
}

/// One value on either side of no load, where there are two.
fn sides([lower, upper]: [f64; 2]) -> Option<Basis> {
    let wide = upper.max(-lower);
    (lower < 0.0 && upper > 0.0).then_some(Basis::Spline { lower: -wide, upper: wide, pieces: 2, degree: 0 })
}

/// Joints with the range of their load.
fn loaded(setting: &Setting<'_>) -> impl Iterator<Item = (JointId, [f64; 2])> {
    setting.chain.movable().iter().filter_map(|&joint| Some((joint, setting.load_range(joint)?)))
}

/// A joint's own motion along a curve over its load.
fn curve(joint: JointId, basis: Basis) -> Expansion {
    Expansion { at: At::Motion { joint }, factors: vec![Factor { of: Input::Load(joint), basis }] }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pieces_meet_where_the_load_changes_its_side() {
        let of = |range, pieces| match pieces_of(range, pieces, 0) {
            Basis::Spline { lower, upper, pieces, degree: 0 } => (lower, upper, pieces),
            other => panic!("{other:?}"),
        };
        let (lower, upper, pieces) = of([-7.0, 13.0], 8);
        assert_eq!((lower, upper, pieces), (-7.5, 15.0, 9));
        assert_eq!(of([2.0, 10.0], 8), (2.0, 10.0, 8));
        let two = Basis::Spline { lower: -13.0, upper: 13.0, pieces: 2, degree: 0 };
        assert_eq!(sides([-7.0, 13.0]), Some(two));
        assert_eq!(sides([2.0, 10.0]), None);
    }
}
