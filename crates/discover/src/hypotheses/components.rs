//! Sets of components of a frame with one fewer or more.

use truepose_errormodel::AnyEffect;
use truepose_errormodel::effects::{Expansion, Place, Spot};
use truepose_kinematics::Axis;

/// All sets with one component fewer (but for the empty one) or more; no set at all means all six.
pub(crate) fn others(components: Option<&[Axis]>) -> impl Iterator<Item = Vec<Axis>> {
    let all = components.unwrap_or(&Axis::ALL).to_vec();
    Axis::ALL.into_iter().filter_map(move |axis| {
        let next: Vec<Axis> = Axis::ALL.into_iter().filter(|a| all.contains(a) != (*a == axis)).collect();
        (!next.is_empty()).then_some(next)
    })
}

/// An effect of a frame with one of its components fewer or more, each in turn: `with` makes it from a set of components. None of an effect of
/// a joint, which has no components to choose.
pub(crate) fn of_spot(
    spot: Spot,
    components: Option<&[Axis]>,
    with: impl Fn(Vec<Axis>) -> Box<dyn AnyEffect>,
) -> Vec<Box<dyn AnyEffect>> {
    match spot {
        Spot::Frame(_) => others(components).map(with).collect(),
        Spot::Joint(_) => Vec::new(),
    }
}

/// A series in several components of a frame with one component fewer or more, two at least: with one left it would be another cause, whose
/// place names that component.
pub(crate) fn of_series(effect: &dyn AnyEffect) -> Vec<Box<dyn AnyEffect>> {
    let Some(series) = effect.concrete::<Expansion>() else { return Vec::new() };
    let Place::Frame { frame, components } = &series.at else { return Vec::new() };
    if components.len() < 2 {
        return Vec::new();
    }
    let at = |components| Place::Frame { frame: *frame, components };
    others(Some(components))
        .filter(|set| set.len() > 1)
        .map(|set| Expansion { at: at(set), ..series.clone() }.boxed())
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::hypotheses::guideway::Rail;
    use crate::hypotheses::hypothesis::Hypothesis;
    use crate::hypotheses::time::Jump;
    use truepose_errormodel::effects::{Guideway, Shift};
    use truepose_kinematics::{FrameId, JointId};

    #[test]
    fn each_component_is_left_out_or_taken_in_once() {
        let components = |effect: &dyn AnyEffect| effect.concrete::<Guideway>().unwrap().components.clone();
        let once = Rail.neighbours(&Guideway::of(JointId(1)));
        assert_eq!(once.len(), 6);
        for (effect, axis) in once.iter().zip(Axis::ALL) {
            assert!(!components(&**effect).unwrap().contains(&axis));
        }
        let twice = Rail.neighbours(&*once[0]);
        let sizes: Vec<usize> = twice.iter().map(|effect| components(&**effect).unwrap().len()).collect();
        assert_eq!(sizes, [6, 4, 4, 4, 4, 4]);
    }

    #[test]
    fn a_jump_of_a_joint_has_no_component_to_leave_out() {
        let at = |spot| Shift::of(spot, 1.0);
        assert!(Jump.neighbours(&at(Spot::Joint(JointId(1)))).is_empty());
        let one = Shift { components: Some(vec![Axis::Tx]), ..at(Spot::Frame(FrameId::BASE)) };
        assert_eq!(Jump.neighbours(&one).len(), 5);
        assert!(Jump.neighbours(&Guideway::of(JointId(1))).is_empty());
    }

    #[test]
    fn a_series_in_a_frame_keeps_two_components_at_least() {
        let of = |components: Vec<Axis>| {
            let at = Place::Frame { frame: FrameId::BASE, components };
            of_series(&Expansion { at, factors: Vec::new() }).len()
        };
        assert_eq!(of(Axis::ALL.to_vec()), 6);
        // Four that take one in; neither may go.
        assert_eq!(of(vec![Axis::Tx, Axis::Rz]), 4);
        assert_eq!(of(vec![Axis::Tx]), 0);
    }
}
