//! Reconsideration: every finding is tested again with all others in the model (backward elimination with
//! replacement).
//!
//! Each finding is removed in turn, the residual is screened, and the contest is repeated. A finding that the
//! others explain is removed; one for which another place, family or nonlinear parameter has a clearly
//! smaller score is replaced.

use crate::accept::accepted::Accepted;
use crate::accept::evidence::{Evidence, collect};
use crate::accept::model::Model;
use crate::contest::competition::{Contest, contest};
use crate::contest::competitor::{Competitor, competitor, outcompeted, with_estimates};
use crate::contest::names::{doubted, name_probabilities};
use crate::error::DiscoverError;
use crate::hypotheses::candidate::Candidate;
use crate::model::current::Context;
use crate::policy::Policy;
use crate::problem::dependence::BesideWander;
use crate::problem::likelihood::without as lacking;
use crate::problem::linearisation::Linearisation;
use crate::problem::observation::typical_sd;
use crate::revise::split::{Drives, drives_instead, split};
use crate::screen::candidates::Screen;
use crate::screen::multiplicity::Multiplicity;
use truepose_errormodel::Visits;

/// Tests each of the first `count` findings again with all others in the model; true when the model changed.
pub(crate) fn reconsidered(
    context: &Context<'_>,
    mut model: Model,
    count: usize,
    multiplicity: &Multiplicity,
) -> Result<(Model, bool), DiscoverError> {
    let (mut at, mut iterations) = (0, 0);
    let mut moved = false;
    while at < count.min(model.findings.len()) && iterations < 2 * count {
        iterations += 1;
        let others = model.others(&[at]);
        let Reselection { contest, winner, evidence, drives } =
            without(context, &model, at, (&others, multiplicity))?;
        if let Some(drives) = drives
            && let Some(split) = split(context, &model, at, drives, multiplicity)?
        {
            model = split;
            moved = true;
            at += 1;
            continue;
        }
        let mut findings = model.findings.clone();
        let Some(winner) = winner.map(|k| &contest.competitors[k]) else {
            // The other findings explain it.
            findings.remove(at);
            model = model.refitted(context, findings)?;
            moved = true;
            continue;
        };
        let next = with_estimates(winner);
        let changed = !same_parameters(&next, &findings[at].candidate);
        findings[at].compete(outcompeted(&contest.competitors, winner, context.policy()));
        let floor = winner.likelihood.noise.rows.floor(typical_sd(&model.current.data));
        let doubt = |evidence: &Evidence| {
            evidence.doubt((context.policy(), context.options.alpha), floor, next.follows_time())
        };
        let before = &model.findings[at];
        let likelier = |evidence: &Evidence| {
            let names = name_probabilities(
                (&next, evidence.p_surrogates),
                &doubted_as_found(&findings[at].competitors, before, context.policy()),
                context.policy(),
            );
            let of = |(other, _): &(Candidate, f64)| other.same_cause(&before.candidate);
            let stood = findings[at].competitors.iter().position(of).map_or(0.0, |k| names.each[k]);
            names.own > stood
        };
        match evidence {
            // A replacement by another family or place has to pass the tests of a new finding, and its name has to be more probable once its
            // channel was held against surrogates.
            Some(evidence) if doubt(&evidence).is_some() || !likelier(&evidence) => {
                let surrogates = doubt(&evidence).is_none().then_some(evidence.p_surrogates);
                model.findings[at].stays(&contest, (winner, surrogates), context.policy());
                at += 1;
                continue;
            }
            Some(evidence) => findings[at].evidence = evidence,
            None => {}
        }
        if changed {
            findings[at].candidate = next;
            model = model.refitted(context, findings)?;
            moved = true;
        } else {
            model.findings = findings;
        }
        at += 1;
    }
    Ok((model, moved))
}

impl Accepted {
    /// The finding stays, with the contest's competing hypotheses: the winner is one of them, as doubtful as its channel makes it, unless it
    /// failed the tests.
    fn stays(&mut self, contest: &Contest, winner: (&Competitor, Option<Option<f64>>), policy: &Policy) {
        let (winner, surrogates) = winner;
        let own = contest.competitors.iter().find(|r| r.candidate.same_cause(&self.candidate));
        let mut others = match own {
            Some(own) => outcompeted(&contest.competitors, own, policy),
            None => self.competitors.clone(),
        };
        match surrogates {
            None => others.retain(|(other, _)| !other.same_cause(&winner.candidate)),
            Some(p) => others
                .iter_mut()
                .filter(|(other, _)| other.same_cause(&winner.candidate))
                .for_each(|other| other.1 = doubted(other.1, p, policy)),
        }
        self.compete(others);
    }
}

/// The competing hypotheses, with the finding that stood until now among them as doubtful as its channel made it.
fn doubted_as_found(
    competitors: &[(Candidate, f64)],
    before: &Accepted,
    policy: &Policy,
) -> Vec<(Candidate, f64)> {
    let one = |(other, behind): &(Candidate, f64)| {
        let stood = other.same_cause(&before.candidate);
        let behind = if stood { doubted(*behind, before.evidence.p_surrogates, policy) } else { *behind };
        (other.clone(), behind)
    };
    competitors.iter().map(one).collect()
}

/// A contest in place of a finding, and its result.
struct Reselection {
    contest: Contest,
    /// Index of the winner; `None` when the other findings explain this one.
    winner: Option<usize>,
    /// Evidence of the winner, if its family or place is another one.
    evidence: Option<Evidence>,
    /// Drives that are more probable than the winner.
    drives: Option<Drives>,
}

/// Repeats the contest without a finding.
fn without(
    context: &Context<'_>,
    model: &Model,
    at: usize,
    (others, multiplicity): (&[Candidate], &Multiplicity),
) -> Result<Reselection, DiscoverError> {
    let Accepted { candidate, shortlist, .. } = &model.findings[at];
    let options = context.options;
    let held = |linearisation: &Linearisation<'_>| {
        let screen =
            Screen::again(linearisation, &options.library, (shortlist, others), &multiplicity.counts);
        // The periods of a transmission were found with fewer effects in the model: they are searched again.
        let mut contest =
            contest(linearisation, &screen, others, candidate.periodic_in(linearisation.chain()).is_some())?;
        // The finding as it stands takes part with its nonlinear parameters.
        if let Some(own) =
            competitor(linearisation, &screen, &Visits::of(linearisation.data), candidate.clone())?
        {
            let same = contest.competitors.iter().position(|r| r.candidate.same_cause(candidate));
            match same {
                Some(k) if contest.competitors[k].score < own.score => {}
                Some(k) => contest.competitors[k] = own,
                None => contest.competitors.push(own),
            }
        }
        let winner = winner(&contest, candidate, &options.policy);
        let another = winner.map(|k| &contest.competitors[k]).filter(|r| !r.candidate.same_cause(candidate));
        let tested = |best: &Competitor| {
            // The p-value of a replacement is its own, from a full screen.
            let p = multiplicity.null.p_value(best.surprisal);
            let wander = BesideWander::of(linearisation, options.seed);
            collect((linearisation, &wander), (&screen, &contest.present), best, p, options)
        };
        let evidence = another.map(tested).transpose()?;
        let instead =
            winner.and_then(|k| Some((drives_instead(&contest.competitors, k, &options.policy)?, k)));
        let drives = match instead {
            Some((first, k)) => {
                let best = &contest.competitors[first];
                let evidence = tested(best)?;
                let floor = linearisation.floor(best.likelihood.noise);
                let stands = evidence.doubt((&options.policy, options.alpha), floor, false).is_none();
                stands
                    .then(|| Drives::new(&contest.competitors, (first, k), evidence, &options.policy))
                    .flatten()
            }
            None => None,
        };
        Ok(Reselection { contest, winner, evidence, drives })
    };
    let current = &*model.current;
    // A corrected payload is part of the data: the model has to be refitted.
    if !current.found[at].effects().is_empty() {
        let linearisation = Linearisation::new(&current.fit, &current.data, options)?;
        if let Some(linearisation) = lacking(linearisation, model.effects_of(context, at))? {
            return held(&linearisation);
        }
    }
    let fewer = context.fit_model(others.to_vec(), &current.outliers.suspects)?;
    held(&Linearisation::new(&fewer.fit, &fewer.data, options)?)
}

/// Index of the winner. Another family or place needs a score that is smaller by [`Policy::tie`], or, where the scores are not
/// distinguishable, a name that is more probable; the same one may change its nonlinear parameters. `None` when no score is below the
/// −2 ln L of the model without the finding.
fn winner(contest: &Contest, mine: &Candidate, policy: &Policy) -> Option<usize> {
    let competitors = &contest.competitors;
    let worth = |&k: &usize| competitors[k].score < contest.present.deviance;
    let still = competitors.iter().position(|r| r.candidate.same_cause(mine));
    let best = Some(0).filter(|_| !competitors.is_empty()).filter(worth).or(still.filter(worth))?;
    let Some(still) = still.filter(|&k| competitors[k].score < competitors[best].score + policy.tie) else {
        return Some(best);
    };
    Some(likeliest(competitors, still, policy).filter(worth).unwrap_or(still))
}

/// Of the competitors whose scores are not distinguishable from the best one, that with the most probable name, if it is a named cause
/// and more probable than the one that stands.
fn likeliest(competitors: &[Competitor], still: usize, policy: &Policy) -> Option<usize> {
    let least = competitors.iter().map(|r| r.score).fold(f64::INFINITY, f64::min);
    let of_name = |k: usize| competitors[k].name_score(policy);
    let tied = (0..competitors.len())
        .filter(|&k| competitors[k].score < least + policy.tie && competitors[k].candidate.family.is_named());
    let likeliest = tied.min_by(|&a, &b| of_name(a).total_cmp(&of_name(b)))?;
    (of_name(likeliest) + policy.same_explanation < of_name(still)).then_some(likeliest)
}

/// Whether both have the same family, place and parameters.
fn same_parameters(a: &Candidate, b: &Candidate) -> bool {
    let parameters = |c: &Candidate| -> Vec<_> {
        c.effects().iter().map(|e| (e.kind(), e.parameters().to_string())).collect()
    };
    a.same_cause(b) && parameters(a) == parameters(b)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::options::DiscoverOptions;
    use crate::problem::synthetic::{data_of, fitted, normal};

    #[test]
    fn a_finding_keeps_its_place_unless_another_is_better_by_more_than_a_tie() {
        let actual = |joints: &[f64]| {
            let mut actual = joints.to_vec();
            actual[1] += 4e-4 * (7.0 * joints[1]).sin();
            actual
        };
        let (chain, data) =
            data_of(60, 6, &actual, &|_, _, row| std::array::from_fn(|axis| 2e-5 * normal(3 * row + axis)));
        let fit = fitted(&chain, &data);
        let options = DiscoverOptions::default();
        let linearisation = Linearisation::new(&fit, &data, &options).unwrap();
        let screen = Screen::new(&linearisation, &options.library, &[]);
        let mut contest = contest(&linearisation, &screen, &[], false).unwrap();
        let (best, second) =
            (contest.competitors[0].candidate.clone(), contest.competitors[1].candidate.clone());
        let least = contest.competitors[0].score;
        let policy = &options.policy;
        assert_eq!(winner(&contest, &best, policy), Some(0));
        contest.competitors[1].score = least + policy.tie - 0.1;
        assert_eq!(winner(&contest, &second, policy), Some(1));
        contest.competitors[1].score = least + policy.tie + 0.1;
        assert_eq!(winner(&contest, &second, policy), Some(0));
        // Of named causes that are not distinguishable the one with the more probable name is taken, whichever stands.
        contest.competitors.retain(|competitor| competitor.candidate.family.is_named());
        contest.competitors.truncate(2);
        for (k, behind) in [0.0, 0.9 * policy.tie].into_iter().enumerate() {
            contest.competitors[k].score = least + behind;
        }
        let [a, b] = &contest.competitors[..] else { panic!("two named causes") };
        let likelier = usize::from(b.name_score(policy) < a.name_score(policy));
        for stands in [a, b].map(|competitor| competitor.candidate.clone()) {
            assert_eq!(winner(&contest, &stands, policy), Some(likelier));
        }
        // Where nothing is worth its unknowns the others explain it.
        let present = contest.present.deviance;
        contest.competitors.iter_mut().for_each(|competitor| competitor.score = present + 1.0);
        assert_eq!(winner(&contest, &best, policy), None);
    }
}
