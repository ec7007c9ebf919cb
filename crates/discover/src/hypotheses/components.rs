//! Causes that move a frame, with one of the components more or less in which they move it.

use crate::hypotheses::candidate::Candidate;
use crate::hypotheses::nonlinear::seen_as;
use truepose_errormodel::AnyEffect;
use truepose_errormodel::effects::{Drift, Expansion, Guideway, Place, Shift, Spot, Thermal};
use truepose_kinematics::Axis;

/// The same cause with one component fewer or more, each in turn; none of a cause that moves no frame.
pub(crate) fn neighbours(candidate: &Candidate) -> Vec<Candidate> {
    let [effect] = candidate.effects() else { return Vec::new() };
    let effect: &dyn AnyEffect = &**effect;
    let like = |effect: Box<dyn AnyEffect>| Candidate {
        change: crate::hypotheses::candidate::Change::Add(vec![effect]),
        ..candidate.clone()
    };
    let of_a_frame = |spot: Spot| matches!(spot, Spot::Frame(_));
    if let Some(rail) = seen_as::<Guideway>(effect) {
        let one = |components| like(Box::new(Guideway { components, ..rail.clone() }));
        return others(rail.components.as_deref()).map(one).collect();
    }
    if let Some(drift) = seen_as::<Drift>(effect).filter(|drift| of_a_frame(drift.spot)) {
        let one = |components| like(Box::new(Drift { components, ..drift.clone() }));
        return others(drift.components.as_deref()).map(one).collect();
    }
    if let Some(jump) = seen_as::<Shift>(effect).filter(|jump| of_a_frame(jump.spot)) {
        let one = |components| like(Box::new(Shift { components, ..jump.clone() }));
        return others(jump.components.as_deref()).map(one).collect();
    }
    if let Some(growth) = seen_as::<Thermal>(effect).filter(|growth| of_a_frame(growth.spot)) {
        let one = |components| like(Box::new(Thermal { components, ..growth.clone() }));
        return others(growth.components.as_deref()).map(one).collect();
    }
    if let Some(series) = seen_as::<Expansion>(effect)
        && let Place::Frame { frame, components } = &series.at
    {
        // With one component left it would be another cause: its place names that component.
        let several =
            |set: &Option<Vec<Axis>>| components.len() > 1 && set.as_ref().is_some_and(|s| s.len() > 1);
        let at = |set: Option<Vec<Axis>>| Place::Frame { frame: *frame, components: set.unwrap_or_default() };
        let one = |set| like(Box::new(Expansion { at: at(set), ..series.clone() }));
        return others(Some(components)).filter(several).map(one).collect();
    }
    Vec::new()
}

/// All sets with one component fewer (but for the empty one) or more.
fn others(components: Option<&[Axis]>) -> impl Iterator<Item = Option<Vec<Axis>>> {
    let all = components.unwrap_or(&Axis::ALL).to_vec();
    Axis::ALL.into_iter().filter_map(move |axis| {
        let next: Vec<Axis> = Axis::ALL.into_iter().filter(|a| all.contains(a) != (*a == axis)).collect();
        (!next.is_empty()).then_some(Some(next))
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::hypotheses::family::Family;
    use truepose_kinematics::{FrameId, JointId};

    #[test]
    fn each_component_is_left_out_or_taken_in_once() {
        let rail = Candidate::new(Family::Guideway, crate::Place::default(), Guideway::of(JointId(1)));
        let components = |c: &Candidate| seen_as::<Guideway>(&*c.effects()[0]).unwrap().components.clone();
        let once = neighbours(&rail);
        assert_eq!(once.len(), 6);
        assert!(once.iter().zip(Axis::ALL).all(|(c, axis)| !components(c).unwrap().contains(&axis)));
        let sizes: Vec<usize> = neighbours(&once[0]).iter().map(|c| components(c).unwrap().len()).collect();
        assert_eq!(sizes, [6, 4, 4, 4, 4, 4]);
    }

    #[test]
    fn what_moves_a_joint_has_nothing_to_leave_out() {
        let at = |spot| Shift::of(spot, 1.0);
        let joint = Candidate::new(Family::Shift, crate::Place::default(), at(Spot::Joint(JointId(1))));
        assert!(neighbours(&joint).is_empty());
        let one = Shift { components: Some(vec![Axis::Tx]), ..at(Spot::Frame(FrameId::BASE)) };
        assert_eq!(neighbours(&Candidate::new(Family::Shift, crate::Place::default(), one)).len(), 5);
    }

    #[test]
    fn a_wandering_frame_keeps_two_components_at_least() {
        let at = |components: Vec<Axis>| Place::Frame { frame: FrameId::BASE, components };
        let of = |components| {
            let series = Expansion { at: at(components), factors: Vec::new() };
            Candidate::new(Family::Unmodelled, crate::Place::default(), series)
        };
        assert_eq!(neighbours(&of(Axis::ALL.to_vec())).len(), 6);
        // Four that take one in; neither may go.
        assert_eq!(neighbours(&of(vec![Axis::Tx, Axis::Rz])).len(), 4);
        assert!(neighbours(&of(vec![Axis::Tx])).is_empty());
    }
}
