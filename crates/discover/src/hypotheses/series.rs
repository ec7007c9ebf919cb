//! Candidates that are a series in joints, signals and time at one frame: many of them share their functions.

use crate::hypotheses::candidate::Candidate;
use truepose_errormodel::AnyEffect;
use truepose_errormodel::effects::{Expansion, Factor, Place};
use truepose_kinematics::{Axis, FrameId};

/// A series at a frame.
pub(crate) struct Series<'a> {
    pub factors: &'a [Factor],
    pub frame: FrameId,
    pub components: &'a [Axis],
}

/// The series of a candidate that acts on one component of a frame, or on all six, and depends on joints, signals and time alone.
pub(crate) fn series(candidate: &Candidate) -> Option<Series<'_>> {
    let [effect] = candidate.effects() else { return None };
    let series = effect.concrete::<Expansion>()?;
    match &series.at {
        Place::Frame { frame, components }
            if !AnyEffect::load_dependent(series)
                && (components.len() == 1 || components[..] == Axis::ALL) =>
        {
            Some(Series { factors: &series.factors, frame: *frame, components })
        }
        _ => None,
    }
}

/// The functions of a series, as one component of the base emits them.
pub(crate) fn functions(factors: &[Factor]) -> Box<dyn AnyEffect> {
    let at = Place::Frame { frame: FrameId::BASE, components: vec![Axis::ALL[0]] };
    Box::new(Expansion { at, factors: factors.to_vec() })
}
