//! Deflection of a joint that is not in proportion to its load; or, unmodelled, whatever follows the load.

use crate::hypotheses::covariate::Covariate;
use crate::hypotheses::driver::Driver;
use crate::hypotheses::family::Family;
use crate::hypotheses::hypothesis::Hypothesis;
use crate::hypotheses::nonlinear::{Nonlinear, Refinement};
use crate::hypotheses::place::Place;
use crate::hypotheses::setting::Setting;
use crate::hypotheses::variant::Variant;
use crate::hypotheses::view::TraceView;
use truepose_errormodel::AnyEffect;
use truepose_errormodel::effects::{Basis, Expansion, Factor, Input, LoadNonlinearity, Place as At};
use truepose_kinematics::JointId;

/// Equal pieces of the curves.
const PIECES: [usize; 2] = [2, 5];
/// And of those that may do anything from one to the next.
const AT_ONCE: [usize; 2] = [8, 20];

/// A joint does not yield in proportion to its load: by powers, over a soft range, or along a curve.
#[derive(Debug)]
pub(crate) struct CurvedSpring;

impl Hypothesis for CurvedSpring {
    fn family(&self) -> Family {
        Family::LoadNonlinearity
    }

    fn variants(&self, setting: &Setting<'_>) -> Vec<Variant> {
        let chain = setting.chain;
        let mut all = Vec::new();
        for &joint in chain.movable() {
            let place = Place::joint(chain, joint);
            for powers in [vec![2], vec![3], vec![2, 3]] {
                all.push(Variant::new(place.clone(), LoadNonlinearity::with_powers(joint, powers)));
            }
            let largest = setting.largest_load(joint);
            for share in [0.05, 0.2, 0.6].iter().filter(|_| largest > 0.0) {
                all.push(Variant::new(place.clone(), LoadNonlinearity::soft(joint, share * largest)));
            }
        }
        for (joint, [lower, upper]) in loaded(setting) {
            let place = Place::joint(chain, joint);
            all.extend(PIECES.map(|pieces| {
                let basis = Basis::Spline { lower, upper, pieces, degree: 3 };
                Variant::new(place.clone(), curve(joint, basis))
            }));
        }
        all
    }

    fn meaning(&self, place: &Place) -> String {
        format!(
            "The deflection of {} is not proportional to its load: clearance in a bearing or gear, or a strain wave gear that \
             stiffens.",
            place.part()
        )
    }

    fn drivers(&self, _: &Place, _: &[Box<dyn AnyEffect>]) -> Vec<Driver> {
        vec![Driver::Wrench]
    }

    fn view(&self, place: &Place, _: &[Box<dyn AnyEffect>]) -> TraceView {
        TraceView::of_motion(place.joint.clone().map(Driver::JointLoad))
    }

    // Both bend the curve of a joint against its load.
    fn rank(&self) -> Family {
        Family::Backlash
    }

    fn is_curve(&self) -> bool {
        true
    }

    fn nonlinear(&self, effect: &dyn AnyEffect) -> Option<Nonlinear> {
        let load = effect.concrete::<LoadNonlinearity>()?.soft_load?;
        Some(Nonlinear::new(load, Refinement::Scale([0.4, 2.5])))
    }

    fn with_value(
        &self,
        effect: &dyn AnyEffect,
        value: f64,
        range: Option<[f64; 2]>,
    ) -> Option<Box<dyn AnyEffect>> {
        let spring = effect.concrete::<LoadNonlinearity>()?.clone();
        Some(Box::new(LoadNonlinearity { soft_load: Some(value), soft_range: range, ..spring }))
    }
}

/// Curves over the load, straight lines, curves that may do anything from one piece to the next, and the side of the load: unmodelled.
pub(crate) fn unmodelled(setting: &Setting<'_>) -> impl Iterator<Item = Variant> {
    loaded(setting).flat_map(|(joint, range)| {
        let [lower, upper] = range;
        let name = setting.chain.joint(joint).name.clone();
        let place = Place::joint(setting.chain, joint).depending_on(Covariate::Load(name));
        let straight = Basis::Chebyshev { lower, upper, degrees: vec![1] };
        let curves = PIECES.map(|pieces| Basis::Spline { lower, upper, pieces, degree: 3 });
        let jagged =
            AT_ONCE.into_iter().flat_map(move |pieces| [0, 1].map(|degree| pieces_of(range, pieces, degree)));
        [straight]
            .into_iter()
            .chain(curves)
            .chain(jagged)
            .chain(sides(range))
            .map(move |basis| Variant::new(place.clone(), curve(joint, basis)))
    })
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
