//! Merging: two findings that one candidate explains become one finding.
//!
//! Reconsideration of one finding at a time cannot remove them: each explains what the other leaves. So two
//! findings with the same driver (a joint's motion, the load, time) are removed together, and single
//! candidates are compared in their place. When the smallest score of a single candidate is not distinguishable from that of the
//! pair ([`crate::contest::pair`]), one finding is preferred to two.

use crate::accept::accepted::Accepted;
use crate::accept::evidence::collect;
use crate::accept::model::Model;
use crate::contest::competition::contest;
use crate::contest::competitor::{outcompeted, with_estimates};
use crate::contest::pair::{Side, pair_score};
use crate::error::DiscoverError;
use crate::hypotheses::candidate::Candidate;
use crate::model::current::Context;
use crate::problem::dependence::BesideWander;
use crate::problem::linearisation::Linearisation;
use crate::screen::candidates::Screen;
use crate::screen::multiplicity::Multiplicity;
use truepose_errormodel::Visits;

/// The model with one candidate in place of finding `which` and another one; `None` when no single candidate
/// replaces a pair.
pub(crate) fn merged(
    context: &Context<'_>,
    model: &Model,
    which: usize,
    multiplicity: &Multiplicity,
) -> Result<Option<Model>, DiscoverError> {
    let findings = &model.findings;
    for other in (0..findings.len()).rev().filter(|&k| k != which) {
        if !have_common_driver(&findings[which].candidate, &findings[other].candidate) {
            continue;
        }
        let pair = [which.min(other), which.max(other)];
        if let Some(one) = one_for_both(context, model, pair, multiplicity)? {
            let mut findings = findings.clone();
            findings[pair[0]] = one;
            findings.remove(pair[1]);
            return Ok(Some(model.refitted(context, findings)?));
        }
    }
    Ok(None)
}

/// The candidate that replaces two findings; `None` when the pair has the smaller score by more than `tie` ([`crate::policy::Policy`]).
fn one_for_both(
    context: &Context<'_>,
    model: &Model,
    pair: [usize; 2],
    multiplicity: &Multiplicity,
) -> Result<Option<Accepted>, DiscoverError> {
    let options = context.options;
    let others = model.others(&pair);
    let fewer = context.fit_model(others.clone(), &model.current.outliers.suspects)?;
    let both = pair.map(|k| &model.findings[k]);
    let linearisation = Linearisation::new(&fewer.fit, &fewer.data, options)?;
    let shortlist: Vec<Candidate> = both.iter().flat_map(|a| a.shortlist.iter().cloned()).collect();
    let screen = Screen::again(&linearisation, &options.library, (&shortlist, &others), &multiplicity.counts);
    let contest = contest(&linearisation, &screen, &others, false)?;
    let Some(best) = contest.competitors.iter().min_by(|a, b| a.score.total_cmp(&b.score)) else {
        return Ok(None);
    };
    let columns =
        [linearisation.columns_of(&both[0].candidate)?, linearisation.columns_of(&both[1].candidate)?];
    let side = |k: usize| Side {
        candidate: &both[k].candidate,
        columns: &columns[k],
        freedom: both[k].evidence.unknowns,
    };
    let visits = Visits::of(linearisation.data);
    let score = pair_score(&linearisation, &screen, &visits, [side(0), side(1)])?;
    if best.score > score + options.policy.tie {
        return Ok(None);
    }
    let p = multiplicity.null.p_value(best.surprisal);
    let wander = BesideWander::of(&linearisation, options.seed);
    let evidence = collect((&linearisation, &wander), (&screen, &contest.present), best, p, options)?;
    let competitors = outcompeted(&contest.competitors, best, &options.policy);
    Ok(Some(Accepted { candidate: with_estimates(best), evidence, competitors, shortlist }))
}

/// Whether two candidates have a driver in common, so that one effect may have been found as two.
fn have_common_driver(a: &Candidate, b: &Candidate) -> bool {
    let drivers = a.drivers();
    b.drivers().iter().any(|driver| drivers.contains(driver))
}

#[cfg(test)]
#[path = "merge_tests.rs"]
mod tests;
