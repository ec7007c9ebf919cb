//! Splitting: two drives that yield take the place of a cause that imitates both.
//!
//! One link that bends, with weights that nobody declared, turns what lies beyond it about a point between two joints, by as many free
//! coefficients as both have. Alone neither drive explains as much. The drives of an arm yield together, so that the pair
//! ([`crate::contest::pair`]) counts as one cause; it is taken where it is more probable, prior included.

use crate::accept::accepted::Accepted;
use crate::accept::evidence::{Evidence, collect};
use crate::accept::model::Model;
use crate::contest::competition::contest;
use crate::contest::competitor::{Competitor, competitor, outcompeted, with_estimates};
use crate::contest::pair::yield_together;
use crate::error::DiscoverError;
use crate::hypotheses::candidate::Candidate;
use crate::model::current::Context;
use crate::policy::Policy;
use crate::problem::dependence::BesideWander;
use crate::problem::linearisation::Linearisation;
use crate::screen::candidates::Screen;
use crate::screen::multiplicity::Multiplicity;
use truepose_errormodel::Visits;

/// The first of two drives that take the place of a finding.
pub(crate) struct Drives {
    candidate: Candidate,
    evidence: Evidence,
    competitors: Vec<(Candidate, f64)>,
    /// The second.
    partner: Candidate,
    /// What stood in their place, and how far it is behind both.
    instead: (Candidate, f64),
}

/// The best competitor that is a drive and has another one as its partner, where the name of both is more probable than that of the winner
/// ([`crate::contest::names`]; π counts tests, which say nothing about the name).
pub(crate) fn drives_instead(competitors: &[Competitor], winner: usize, policy: &Policy) -> Option<usize> {
    let stands = &competitors[winner];
    let score = |r: &Competitor| {
        let partner = r.partner.as_ref().filter(|partner| !partner.leads)?;
        let both = yield_together(&r.candidate, &partner.candidate);
        (both && !r.candidate.same_cause(&stands.candidate)).then_some(partner.score.data)
    };
    let pairs = competitors.iter().enumerate().filter_map(|(k, r)| Some((k, score(r)?)));
    let (best, score) = pairs.min_by(|a, b| a.1.total_cmp(&b.1))?;
    (score < stands.name_score(policy)).then_some(best)
}

impl Drives {
    /// Competitor `first` with its partner in place of the winner; `None` where it has no partner.
    pub fn new(
        competitors: &[Competitor],
        (first, winner): (usize, usize),
        evidence: Evidence,
        policy: &Policy,
    ) -> Option<Self> {
        let (own, stood) = (&competitors[first], &competitors[winner]);
        let partner = own.partner.as_ref()?;
        Some(Drives {
            candidate: with_estimates(own),
            evidence,
            competitors: outcompeted(competitors, own, policy),
            partner: partner.candidate.clone(),
            instead: (with_estimates(stood), stood.data_alone() - partner.score.data),
        })
    }
}

/// The model with two drives in place of a finding; `None` where no second drive passes the tests beside the first.
pub(crate) fn split(
    context: &Context<'_>,
    model: &Model,
    at: usize,
    drives: Drives,
    multiplicity: &Multiplicity,
) -> Result<Option<Model>, DiscoverError> {
    let options = context.options;
    let mut findings = model.findings.clone();
    let shortlist = findings[at].shortlist.clone();
    let Drives { candidate, evidence, competitors, partner, instead } = drives;
    findings[at] = Accepted {
        candidate,
        evidence,
        competitors,
        shortlist: shortlist.clone(),
        instead: vec![instead.clone()],
    };
    let first = model.refitted(context, findings)?;
    let current = &*first.current;
    let linearisation = Linearisation::new(&current.fit, &current.data, options)?;
    let found = first.others(&[]);
    let screen = Screen::again(&linearisation, &options.library, (&shortlist, &found), &multiplicity.counts);
    let contest = contest(&linearisation, &screen, &found, false)?;
    let visits = Visits::of(linearisation.data);
    let same = contest.competitors.iter().find(|r| r.candidate.same_cause(&partner));
    let alone = match same {
        Some(_) => None,
        None => competitor(&linearisation, &screen, &visits, partner)?,
    };
    let Some(own) = same.or(alone.as_ref()) else { return Ok(None) };
    let wander = BesideWander::of(&linearisation, options.seed);
    let p = multiplicity.null.p_value(own.surprisal);
    let evidence = collect((&linearisation, &wander), (&screen, &contest.present), own, p, options)?;
    let floor = linearisation.floor(own.likelihood.noise);
    if evidence.doubt((&options.policy, options.alpha), floor, false).is_some() {
        return Ok(None);
    }
    let second = Accepted {
        candidate: with_estimates(own),
        evidence,
        competitors: outcompeted(&contest.competitors, own, &options.policy),
        shortlist,
        instead: Vec::new(),
    };
    let Some((mut findings, last)) = first.joined(second) else { return Ok(None) };
    findings[last].note_instead(&instead.0, instead.1);
    Ok(Some(first.refitted(context, findings)?))
}

#[cfg(test)]
#[path = "split_tests.rs"]
mod tests;
