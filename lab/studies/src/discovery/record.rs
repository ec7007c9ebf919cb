//! One line a robot.
//!
//! Intervals of numbers whose truth is a number of the model.

use super::hidden_effects::HiddenEffect;
use super::plants::Made;
use crate::prelude::*;
use truepose_discover::Finding;

/// A parameter with its interval and its truth.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Interval {
    pub name: String,
    pub truth: f64,
    pub value: f64,
    pub ci95: [f64; 2],
}

impl Interval {
    pub fn covers(&self) -> bool {
        (self.ci95[0]..=self.ci95[1]).contains(&self.truth)
    }

    /// An interval without a width has no information.
    pub fn empty(&self) -> bool {
        self.ci95[1] - self.ci95[0] <= 1e-12 * self.value.abs()
    }
}

/// What became of one robot.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct Record {
    pub cause: String,
    pub multiple: f64,
    pub seed: u64,
    pub robot: String,
    /// Heavy-tailed noise.
    pub heavy: bool,
    pub visits: usize,
    #[serde(with = "number")]
    pub lambda: f64,
    /// The first finding's family; `none`, `error`, `panic`, `no_plant`.
    pub first: String,
    /// The first finding has the right name and place.
    pub first_right: bool,
    /// Some finding has.
    pub found: bool,
    pub findings: usize,
    /// Findings that are not the hidden cause.
    pub extras: usize,
    /// The right one (or, with its family taken out, `unmodelled`) is an equivalent alternative of the first.
    pub listed: bool,
    /// Family-wise p of the first finding; of the last screen.
    #[serde(with = "number")]
    pub p_first: f64,
    #[serde(with = "number")]
    pub p_value: f64,
    pub significant: bool,
    /// Held-out RMS over that of the true plant, after and before.
    #[serde(with = "number")]
    pub ratio: f64,
    #[serde(with = "number")]
    pub ratio_before: f64,
    /// On the wall, and of the processor where the system reports it.
    #[serde(with = "number")]
    pub seconds: f64,
    #[serde(with = "number")]
    pub processor: f64,
    pub intervals: Vec<Interval>,
    pub story: String,
}

impl Record {
    /// Whether this is what became of that task.
    pub fn is(&self, cause: &str, multiple: f64, seed: u64) -> bool {
        self.cause == cause && (self.multiple - multiple).abs() < 1e-9 && self.seed == seed
    }

    /// Whether a plant was made and the loop came to an end.
    pub fn ended(&self) -> bool {
        !["error", "panic", "no_plant"].contains(&self.first.as_str())
    }
}

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
