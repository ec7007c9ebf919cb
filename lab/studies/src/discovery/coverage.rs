//! Intervals of numbers whose truth is a number of the model.

use super::hidden_effects::HiddenEffect;
use super::plants::Made;
use super::record::Interval;
use crate::prelude::*;
use truepose_discover::Finding;

/// Intervals of a finding at the right place, each with its truth.
pub fn intervals(cause: HiddenEffect, made: &Made, found: &Finding) -> Vec<Interval> {
    truths(cause, made, found)
        .into_iter()
        .filter_map(|(name, truth)| {
            let all = found.shape.iter().chain(&found.parameters);
            let mut known = all.filter(|parameter| parameter.name == name);
            let parameter = known.next()?;
            // Two of one name: nothing says which is which.
            let alone = known.next().is_none();
            let interval = Interval { name, truth, value: parameter.value, ci95: parameter.ci95 };
            alone.then_some(interval)
        })
        .collect()
}

/// Names of parameters and what they really are.
fn truths(cause: HiddenEffect, made: &Made, found: &Finding) -> Vec<(String, f64)> {
    let (chain, truth) = (&made.chain, made.plant.truth());
    let place = &found.candidate.place;
    let word = place.joint.clone().unwrap_or_default();
    let at = chain.joint_named(&word).map(|joint| joint.index());
    let errors = at.and_then(|at| truth.joints.get(at));
    let one = |name: String, truth: Option<f64>| truth.map(|truth| (name, truth)).into_iter().collect();
    match cause {
        HiddenEffect::JointCompliance => {
            one(format!("compliance {word}"), errors.map(|e| 1.0 / e.stiffness.drive))
        }
        HiddenEffect::BacklashApproach | HiddenEffect::BacklashLoad => {
            one(format!("gap {word}"), errors.and_then(|e| e.backlash).map(|play| play.width))
        }
        HiddenEffect::Coupling => {
            let driver = place.driver.clone().unwrap_or_default();
            // An eccentric wheel adds to what a richer shape says.
            let ratio = errors.and_then(|e| e.couplings.first()).filter(|c| c.eccentricity.abs() < 1e-12);
            one(format!("coupling {word} by {driver}"), ratio.map(|coupling| coupling.ratio))
        }
        HiddenEffect::Eccentric => match errors.and_then(|e| e.transmission.first()) {
            // ε sin(q − φ), to the first order in ε.
            Some(TransmissionError::Eccentric { ratio, phase }) => vec![
                (format!("transmission {word} sin1"), ratio * phase.cos()),
                (format!("transmission {word} cos1"), -ratio * phase.sin()),
            ],
            _ => Vec::new(),
        },
        // A wheel's n-th tooth: whatever is not a sine in it repeats as often.
        HiddenEffect::Mesh => match errors.and_then(|e| e.transmission.first()) {
            Some(TransmissionError::Mesh { cycles, .. }) => {
                let slides = at.is_some_and(|at| chain.joints()[at].kind == JointKind::Prismatic);
                let turn = if slides { 1.0 } else { std::f64::consts::TAU };
                vec![("period".to_owned(), turn / cycles)]
            }
            _ => Vec::new(),
        },
        HiddenEffect::Shift => {
            let when = truth.changes.iter().find_map(|change| match change.amount {
                Amount::Since(at) => Some(("at".to_owned(), at)),
                _ => None,
            });
            let jump = truth.changes.iter().find_map(|change| match change.mover {
                Mover::Joint(joint, size) if Some(joint) == at => Some(size),
                _ => None,
            });
            own(chain, found, "shift ", jump).into_iter().chain(when).collect()
        }
        HiddenEffect::Thermal => {
            let growth = truth.changes.iter().find_map(|change| match change.mover {
                Mover::Joint(joint, size) | Mover::Length(joint, size) | Mover::Scale(joint, size)
                    if Some(joint) == at =>
                {
                    Some(size)
                }
                _ => None,
            });
            found.parameters.first().map_or_else(Vec::new, |p| one(p.name.clone(), growth))
        }
        HiddenEffect::Payload => {
            let level = place.level.unwrap_or(f64::NAN);
            let labels = &made.plant.blunders.mislabelled;
            let real = labels.iter().find(|(declared, _)| (declared - level).abs() < 1e-6);
            one("mass".into(), real.map(|(_, mass)| *mass))
        }
        _ => Vec::new(),
    }
}

/// The one coefficient of a joint's own motion; a frame has six.
fn own(chain: &Chain, found: &Finding, head: &str, truth: Option<f64>) -> Vec<(String, f64)> {
    let joint = found.candidate.place.joint.as_deref().and_then(|name| chain.joint_named(name));
    let coefficients: Vec<&str> = found
        .parameters
        .iter()
        .map(|parameter| parameter.name.as_str())
        .filter(|name| name.starts_with(head))
        .collect();
    match (joint, truth, &coefficients[..]) {
        (Some(_), Some(truth), [name]) => vec![((*name).to_owned(), truth)],
        _ => Vec::new(),
    }
}
