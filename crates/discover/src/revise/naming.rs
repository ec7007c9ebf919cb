//! The name of each finding at the end of a search: that of the most probable cause which the refitted model admits.
//!
//! A contest is decided by scores, which count the tests of a family; the probability of a name
//! ([`crate::contest::names`]) does not. So a finding may have a competing hypothesis with a more probable name. Here that
//! hypothesis takes its place, if the refitted model has it significant and physical and predicts unseen poses no worse; otherwise
//! it is no competing hypothesis any longer.

use crate::accept::accepted::Accepted;
use crate::accept::admit::kept;
use crate::accept::model::Model;
use crate::accept::surrogates::among_surrogates;
use crate::contest::names::{doubted, name_probabilities};
use crate::error::DiscoverError;
use crate::hypotheses::candidate::Candidate;
use crate::model::admissible::objection;
use crate::model::current::Context;
use crate::policy::Policy;
use crate::problem::likelihood::without;
use crate::problem::linearisation::Linearisation;
use crate::screen::candidates::Screen;

/// The model with each finding under its most probable name.
pub(crate) fn named(context: &Context<'_>, mut model: Model) -> Result<Model, DiscoverError> {
    for at in 0..model.findings.len() {
        // Each competing hypothesis takes its place once at the most.
        for _ in 0..model.findings[at].competitors.len() {
            let Some(rival) = more_probable(context, &model, at) else { break };
            let (other, behind) = model.findings[at].competitors[rival].clone();
            let surrogates = surrogates(context, &model, at, &other)?;
            let renamed = model.findings[at].renamed((rival, surrogates), context.policy());
            // As doubtful as its channel makes it, it may be less probable.
            if renamed.is_outnamed_by(&model.findings[at].candidate, context.policy()) {
                let behind = doubted(behind, surrogates, context.policy());
                model.findings[at].competitors[rival].1 = behind.max(0.0);
                continue;
            }
            match admitted(context, &model, (at, renamed))? {
                Some(next) => model = next,
                None => drop(model.findings[at].competitors.remove(rival)),
            }
        }
    }
    Ok(model)
}

/// The number of the competing hypothesis of a finding with the most probable name, where that is more probable than the finding's.
/// The order of the poses is none: later poses have no place in it.
fn more_probable(context: &Context<'_>, model: &Model, at: usize) -> Option<usize> {
    /// Probabilities that differ by less are printed alike: the finding keeps its name.
    const ALIKE: f64 = 0.005;
    let Accepted { candidate, evidence, competitors, .. } = &model.findings[at];
    let names = name_probabilities((candidate, evidence.p_surrogates), competitors, context.policy());
    let of_use = |c: &Candidate| {
        c.family.is_named()
            && !c.is_of_order(context.data)
            && !model.others(&[at]).iter().any(|o| o.same_cause(c))
    };
    let rivals = (0..competitors.len()).filter(|&k| of_use(&competitors[k].0));
    let first = rivals.max_by(|&a, &b| names.each[a].total_cmp(&names.each[b]))?;
    (names.each[first] > names.own + ALIKE).then_some(first)
}

/// p of a candidate in place of a finding, among surrogates of the channel that it reads.
fn surrogates(
    context: &Context<'_>,
    model: &Model,
    at: usize,
    candidate: &Candidate,
) -> Result<Option<f64>, DiscoverError> {
    let current = &*model.current;
    let linearisation = Linearisation::new(&current.fit, &current.data, context.options)?;
    let Some(linearisation) = without(linearisation, model.effects_of(context, at))? else { return Ok(None) };
    let screen = Screen::new(&linearisation, &context.options.library, &model.others(&[at]));
    among_surrogates(&linearisation, &screen, candidate, context.options)
}

/// The model with a finding under another name; none where its coefficients are not significant or not physical, or it predicts unseen
/// poses worse.
fn admitted(
    context: &Context<'_>,
    model: &Model,
    (at, renamed): (usize, Accepted),
) -> Result<Option<Model>, DiscoverError> {
    let mut findings = model.findings.clone();
    findings[at] = renamed;
    let next = model.refitted(context, findings)?;
    let own = next.effects_of(context, at);
    match objection(&next.current.fit, &next.current.found[at], own, context.policy()) {
        Some(_) => Ok(None),
        None => kept(context, model, next),
    }
}

impl Accepted {
    /// The finding with a competing hypothesis as its name, and its own name among the competing hypotheses.
    fn renamed(&self, (rival, among_surrogates): (usize, Option<f64>), policy: &Policy) -> Accepted {
        let mut renamed = self.clone();
        let (candidate, behind) = renamed.competitors.remove(rival);
        renamed.competitors.iter_mut().for_each(|other| other.1 -= behind);
        renamed.candidate = candidate;
        renamed.evidence.p_surrogates = among_surrogates;
        let earlier = doubted(-behind, self.evidence.p_surrogates, policy);
        renamed.competitors.push((self.candidate.clone(), earlier));
        renamed.competitors.sort_by(|a, b| a.1.total_cmp(&b.1));
        renamed
    }

    /// Whether the name of this competing hypothesis is more probable than that of the finding.
    fn is_outnamed_by(&self, other: &Candidate, policy: &Policy) -> bool {
        let names =
            name_probabilities((&self.candidate, self.evidence.p_surrogates), &self.competitors, policy);
        let place = self.competitors.iter().position(|(known, _)| known.same_cause(other));
        place.is_some_and(|k| names.each[k] > names.own)
    }
}
