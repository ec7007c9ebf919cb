//! What an effect is set against.

use crate::conclude::trace::own::Own;
use crate::conclude::trace::point::TracePoint;
use crate::hypotheses::candidate::Candidate;
use crate::hypotheses::covariate::load_word;
use crate::hypotheses::family::Family;
use truepose_errormodel::Dataset;
use truepose_kinematics::{Chain, FrameId, JointId, Site};

/// What a finding is set against.
pub(super) enum Driver {
    Joint(usize),
    JointLoad(JointId),
    /// The component of the wrench at a frame that goes with the effect.
    Wrench(FrameId),
    Channel(usize),
    Time,
    Visit,
}

/// What drives a finding.
pub(super) fn driver(chain: &Chain, data: &Dataset, candidate: &Candidate, own: &Own) -> Driver {
    let place = &candidate.place;
    let joint = |name: &Option<String>| name.as_deref().and_then(|name| chain.joint_named(name));
    let coordinate = |name: &Option<String>| joint(name).and_then(|joint| chain.coordinate(joint));
    let channel = |name: &Option<String>| name.as_deref().and_then(|name| data.schema.channel(name));
    let when = if data.schema.time { Driver::Time } else { Driver::Visit };
    match candidate.family {
        Family::Backlash => {
            let side = candidate.effects().first().and_then(|e| e.parameters().get("side").cloned());
            let by_load = side.is_some_and(|side| side != "approach");
            match joint(&place.joint) {
                Some(joint) if by_load => Driver::JointLoad(joint),
                Some(joint) => chain.coordinate(joint).map_or(when, Driver::Joint),
                None => when,
            }
        }
        Family::JointCompliance | Family::LoadNonlinearity => {
            joint(&place.joint).map_or(when, Driver::JointLoad)
        }
        Family::LinkCompliance | Family::BaseCompliance => match own {
            Own::Site(Site::Frame(frame, _)) => Driver::Wrench(*frame),
            _ => when,
        },
        Family::Coupling => coordinate(&place.driver).map_or(when, Driver::Joint),
        Family::Thermal => {
            let late = candidate.effects().iter().flat_map(|e| e.needs()).find_map(|need| match need {
                truepose_errormodel::Signal::Channel(name) => data.schema.channel(&name),
                _ => None,
            });
            late.or_else(|| channel(&place.channel)).map_or(when, Driver::Channel)
        }
        Family::Shift | Family::Drift | Family::Payload | Family::Outlier => when,
        Family::Target => Driver::Visit,
        Family::Unmodelled => coordinate(&place.covariate)
            .map(Driver::Joint)
            .or_else(|| channel(&place.covariate).map(Driver::Channel))
            .or_else(|| loaded(chain, &place.covariate).map(Driver::JointLoad))
            .unwrap_or(when),
        Family::Transmission | Family::Guideway | Family::Geometric => {
            coordinate(&place.joint).map_or(when, Driver::Joint)
        }
    }
}

/// The joint on whose load something depends.
fn loaded(chain: &Chain, covariate: &Option<String>) -> Option<JointId> {
    let word = covariate.as_deref()?;
    chain.movable().iter().copied().find(|&joint| load_word(chain, joint) == word)
}

/// The component of the wrench that goes most with what the model says.
pub(super) fn strongest(points: &[TracePoint], wrenches: &[[f64; 6]]) -> usize {
    let n = points.len().max(1) as f64;
    let mean = points.iter().map(|p| p.fitted).sum::<f64>() / n;
    let together = |k: usize| -> f64 {
        let middle = wrenches.iter().map(|w| w[k]).sum::<f64>() / n;
        let (mut both, mut square) = (0.0, 0.0);
        for (point, wrench) in points.iter().zip(wrenches) {
            both += (point.fitted - mean) * (wrench[k] - middle);
            square += (wrench[k] - middle).powi(2);
        }
        if square > 0.0 { both * both / square } else { 0.0 }
    };
    (0..6).max_by(|&a, &b| together(a).total_cmp(&together(b))).unwrap_or(0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_component_that_goes_with_the_effect_is_chosen() {
        let wave = |k: usize| (0.7 * k as f64).sin();
        let points: Vec<TracePoint> = (0..40)
            .map(|row| TracePoint {
                row,
                driver: 0.0,
                before: 0.0,
                after: 0.0,
                fitted: 3.0 + wave(row),
                sd: 0.0,
                lever: 1.0,
                class: 0,
            })
            .collect();
        let wrenches: Vec<[f64; 6]> =
            (0..40).map(|k| [9.0, (1.9 * k as f64).cos(), k as f64, 0.0, -50.0 * wave(k), 2.0]).collect();
        assert_eq!(strongest(&points, &wrenches), 4);
    }
}
