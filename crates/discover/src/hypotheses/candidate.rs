//! A candidate: a change of the model that might explain what is left.

use crate::hypotheses::change::Change;
use crate::hypotheses::driver::Driver;
use crate::hypotheses::family::Family;
use crate::hypotheses::hypothesis::Hypothesis;
use crate::hypotheses::limits::Limit;
use crate::hypotheses::nonlinear::{Nonlinear, Refinement};
use crate::hypotheses::penalty::Penalty;
use crate::hypotheses::place::Place;
use crate::hypotheses::setting::Setting;
use crate::hypotheses::variant::Variant;
use std::sync::Arc;
use truepose_errormodel::{AnyEffect, Dataset, NonlinearParameter, Signal};
use truepose_kinematics::{Chain, JointId};

/// The side of approach of a joint before its first move.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct FirstSide {
    /// The joint, by its place among the movable ones.
    pub column: usize,
    /// −1 or +1.
    pub side: f64,
}

/// A variant of a hypothesis, as it stands in a search or in a model.
#[derive(Debug, Clone)]
pub struct Candidate {
    /// The family of its hypothesis.
    pub family: Family,
    /// Where.
    pub place: Place,
    /// What would be done.
    pub change: Change,
    /// Standard deviation of the prior on its coefficients, in expected sizes; none before it was fitted.
    pub width: Option<f64>,
    /// The side of its joint before the first move; none where it needs none, or the data does not tell.
    pub(crate) first_side: Option<FirstSide>,
    hypothesis: Arc<dyn Hypothesis>,
}

impl Candidate {
    /// A variant of a hypothesis.
    pub fn new(hypothesis: Arc<dyn Hypothesis>, variant: Variant) -> Self {
        let Variant { place, change } = variant;
        Candidate { family: hypothesis.family(), place, change, width: None, first_side: None, hypothesis }
    }

    /// The hypothesis that it is a variant of.
    pub fn hypothesis(&self) -> &dyn Hypothesis {
        &*self.hypothesis
    }

    /// The same with other effects.
    pub(crate) fn with_effects(&self, effects: Vec<Box<dyn AnyEffect>>) -> Self {
        Candidate { change: Change::Add(effects), ..self.clone() }
    }

    /// Whether both are the same cause at the same place, with whatever effects.
    pub fn same_cause(&self, other: &Candidate) -> bool {
        self.family == other.family && self.place == other.place
    }

    /// Its effects; none of a corrected load or of excluded rows.
    pub fn effects(&self) -> &[Box<dyn AnyEffect>] {
        self.change.effects()
    }

    /// The direction (−1, +1) from which its joint is taken to have come before its first move; none where none is needed, or the data
    /// do not tell.
    pub fn first_side(&self) -> Option<f64> {
        self.first_side.map(|first| first.side)
    }

    /// In a few words: `backlash a1`.
    pub fn words(&self) -> String {
        format!("{} {}", self.family, self.place.words()).trim_end().to_owned()
    }

    /// One sentence for a mechanic.
    pub fn meaning(&self) -> String {
        self.hypothesis.meaning(&self.place)
    }

    /// What drives it.
    pub fn drivers(&self) -> Vec<Driver> {
        self.hypothesis.drivers(&self.place, self.effects())
    }

    /// Whether it is driven by the time.
    pub fn follows_time(&self) -> bool {
        self.drivers().contains(&Driver::Time)
    }

    /// Whether it reads the place of a pose in the order of this data, of which later poses have none.
    pub(crate) fn is_of_order(&self, data: &Dataset) -> bool {
        data.by_order && self.effects().iter().any(|effect| effect.needs().contains(&Signal::Time))
    }

    /// Whether its coefficients are penalised by the marginal likelihood.
    pub(crate) fn by_evidence(&self) -> bool {
        self.hypothesis.penalty(self.effects()) == Penalty::MarginalLikelihood
    }

    /// Whether the mechanism has this limit.
    pub(crate) fn has_limit(&self, limit: Limit) -> bool {
        self.hypothesis.limits().contains(&limit)
    }

    /// The same cause with one component fewer or more, each in turn; none of a cause with several effects.
    pub(crate) fn neighbours(&self) -> Vec<Candidate> {
        let [effect] = self.effects() else { return Vec::new() };
        let near = self.hypothesis.neighbours(&**effect);
        near.into_iter().map(|effect| self.with_effects(vec![effect])).collect()
    }

    /// The same cause with more terms, or in a part of the data alone; none where there are no such variants.
    pub(crate) fn richer(&self, setting: &Setting<'_>) -> Vec<Candidate> {
        let [effect] = self.effects() else { return Vec::new() };
        let richer = self.hypothesis.richer_in(&**effect, setting).into_iter();
        let fits = richer.filter(|effect| effect.validate(setting.chain).is_ok());
        fits.map(|effect| Candidate { width: None, ..self.with_effects(vec![effect]) }).collect()
    }

    /// The joint whose motion it is periodic in, where a cause may have further periods.
    pub(crate) fn periodic_in(&self, chain: &Chain) -> Option<JointId> {
        let joint = chain.joint_named(self.place.joint.as_deref()?)?;
        self.hypothesis.at_period(joint, 1.0).map(|_| joint)
    }

    /// The same cause with this period alone.
    pub(crate) fn at_period(&self, joint: JointId, period: f64) -> Option<Candidate> {
        let effect = self.hypothesis.at_period(joint, period)?;
        Some(Candidate { width: None, ..self.with_effects(vec![effect]) })
    }

    /// The nonlinear parameters of its effects that were found rather than known.
    pub(crate) fn nonlinear(&self) -> impl Iterator<Item = Nonlinear> {
        self.effects().iter().flat_map(|effect| {
            [self.hypothesis.nonlinear(&**effect), self.hypothesis.second(&**effect)].into_iter().flatten()
        })
    }

    /// Its first and second nonlinear parameter, where it has one effect.
    pub(crate) fn pair(&self) -> [Option<Nonlinear>; 2] {
        let [effect] = self.effects() else { return [None, None] };
        [self.hypothesis.nonlinear(&**effect), self.hypothesis.second(&**effect)]
    }

    /// The candidate, of one effect, with another value of its second nonlinear parameter.
    pub(crate) fn with_second(&self, value: f64) -> Option<Candidate> {
        let [effect] = self.effects() else { return None };
        Some(self.with_effects(vec![self.hypothesis.with_second(&**effect, value, None)?]))
    }

    /// How many of them are on a coarse grid of variants, so that they are penalised as unknowns.
    pub(crate) fn scales(&self) -> usize {
        self.nonlinear().filter(Nonlinear::is_scale).count() + self.ends()
    }

    /// The ends of a stretch of time in which a payload is wrong: both are chosen among all poses.
    pub(crate) fn ends(&self) -> usize {
        match self.change {
            Change::CorrectLoad { during: Some(_), .. } => 2,
            Change::CorrectLoad { .. } | Change::Add(_) | Change::Exclude { .. } => 0,
        }
    }

    /// How many of them are periods.
    pub(crate) fn periods(&self) -> usize {
        self.nonlinear().filter(|found| matches!(found.search, Refinement::Period(_))).count()
    }

    /// Whether a candidate of one effect has a nonlinear parameter to refine.
    pub(crate) fn is_refinable(&self) -> bool {
        let [_] = self.effects() else { return false };
        self.nonlinear().any(|found| found.search != Refinement::Grid)
    }

    /// The candidate, of one effect, with another value of its nonlinear parameter.
    pub(crate) fn with_value(&self, value: f64) -> Option<Candidate> {
        let [effect] = self.effects() else { return None };
        Some(self.with_effects(vec![self.hypothesis.with_value(&**effect, value, None)?]))
    }

    /// The nonlinear parameters that were found of one of its effects, each within the range in which its interval is looked for.
    pub(crate) fn shapes_of(&self, effect: &dyn AnyEffect, data: &Dataset) -> Vec<NonlinearParameter> {
        /// Times, up and down.
        const REACH: f64 = 4.0;
        let range = |Nonlinear { value, search }: Nonlinear| match search {
            Refinement::Instant { .. } => {
                data.time.iter().fold([f64::INFINITY, f64::NEG_INFINITY], |[a, b], &t| [a.min(t), b.max(t)])
            }
            Refinement::Within(range) => range,
            Refinement::Period(_)
            | Refinement::Scale(_)
            | Refinement::Plateau(_)
            | Refinement::Edge(_)
            | Refinement::Grid => [value / REACH, value * REACH],
        };
        let Some(first) = self.hypothesis.nonlinear(effect) else { return Vec::new() };
        // What is flat between two rows has no interval.
        if matches!(first.search, Refinement::Edge(_) | Refinement::Plateau(_)) {
            return Vec::new();
        }
        let Some(mut free) = self.hypothesis.with_value(effect, first.value, Some(range(first))) else {
            return Vec::new();
        };
        if let Some(second) = self.hypothesis.second(effect)
            && let Some(both) = self.hypothesis.with_second(&*free, second.value, Some(range(second)))
        {
            free = both;
        }
        free.shape()
    }
}
