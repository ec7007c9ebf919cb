//! Merging: two findings that one candidate explains become one finding.
//!
//! Reconsideration of one finding at a time cannot remove them: each explains what the other leaves. So two
//! findings with the same driver (a joint's motion, the load, time) are removed together, and single
//! candidates are compared in their place. When the smallest score of a single candidate is not distinguishable from that of the
//! pair ([`crate::contest::pair`]), one finding is preferred to two. Two drives that yield count as one cause: another cause takes
//! their place where it is more probable, prior included.

use crate::accept::accepted::Accepted;
use crate::accept::evidence::collect;
use crate::accept::model::Model;
use crate::contest::competition::contest;
use crate::contest::competitor::{outcompeted, with_estimates};
use crate::contest::names::name_prior;
use crate::contest::pair::{Side, pair_score, yield_together};
use crate::error::DiscoverError;
use crate::hypotheses::candidate::Candidate;
use crate::model::current::Context;
use crate::problem::dependence::BesideWander;
use crate::problem::linearisation::Linearisation;
use crate::screen::candidates::Screen;
use crate::screen::multiplicity::Multiplicity;
use truepose_errormodel::Visits;

/// The model with one candidate in place of finding `which` and another one, and whether there is one. Where the pair stays the candidate is
/// noted as a competing hypothesis of both.
pub(crate) fn merged(
    context: &Context<'_>,
    mut model: Model,
    which: usize,
    multiplicity: &Multiplicity,
) -> Result<(Model, bool), DiscoverError> {
    for other in (0..model.findings.len()).rev().filter(|&k| k != which) {
        if !have_common_driver(&model.findings[which].candidate, &model.findings[other].candidate) {
            continue;
        }
        let pair = [which.min(other), which.max(other)];
        match one_for_both(context, &model, pair, multiplicity)? {
            Best::Replaces(one) => {
                let mut findings = model.findings.clone();
                findings[pair[0]] = *one;
                findings.remove(pair[1]);
                return Ok((model.refitted(context, findings)?, true));
            }
            Best::Behind(one, behind) => {
                pair.into_iter().for_each(|k| model.findings[k].note_instead(&one, behind));
            }
            Best::None => {}
        }
    }
    Ok((model, false))
}

/// The best single candidate in place of two findings.
enum Best {
    Replaces(Box<Accepted>),
    /// The pair stays; the difference from it, as of competing hypotheses.
    Behind(Box<Candidate>, f64),
    None,
}

/// The best candidate in place of two findings. It replaces them unless the pair has the smaller score by more than `tie`
/// ([`crate::policy::Policy`]).
fn one_for_both(
    context: &Context<'_>,
    model: &Model,
    pair: [usize; 2],
    multiplicity: &Multiplicity,
) -> Result<Best, DiscoverError> {
    let options = context.options;
    let others = model.others(&pair);
    let fewer = context.fit_model(others.clone(), &model.current.outliers.suspects)?;
    let both = pair.map(|k| &model.findings[k]);
    let linearisation = Linearisation::new(&fewer.fit, &fewer.data, options)?;
    let shortlist: Vec<Candidate> = both.iter().flat_map(|a| a.shortlist.iter().cloned()).collect();
    let screen = Screen::again(&linearisation, &options.library, (&shortlist, &others), &multiplicity.counts);
    let contest = contest(&linearisation, &screen, &others, false)?;
    let Some(best) = contest.competitors.iter().min_by(|a, b| a.score.total_cmp(&b.score)) else {
        return Ok(Best::None);
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
    let policy = &options.policy;
    let stays = match yield_together(&both[0].candidate, &both[1].candidate) {
        true => best.data_alone() + name_prior(best.candidate.family, policy) > score.data,
        false => best.score > score.total + policy.tie,
    };
    if stays {
        let another = both.iter().all(|finding| !finding.candidate.same_cause(&best.candidate));
        return Ok(match another {
            true => Best::Behind(Box::new(with_estimates(best)), best.data_alone() - score.data),
            false => Best::None,
        });
    }
    let p = multiplicity.null.p_value(best.surprisal);
    let wander = BesideWander::of(&linearisation, options.seed);
    let evidence = collect((&linearisation, &wander), (&screen, &contest.present), best, p, options)?;
    let competitors = outcompeted(&contest.competitors, best, &options.policy);
    let candidate = with_estimates(best);
    Ok(Best::Replaces(Box::new(Accepted {
        candidate,
        evidence,
        competitors,
        shortlist,
        instead: Vec::new(),
    })))
}

/// Whether two candidates have a driver in common, so that one effect may have been found as two.
fn have_common_driver(a: &Candidate, b: &Candidate) -> bool {
    let drivers = a.drivers();
    b.drivers().iter().any(|driver| drivers.contains(driver))
}

#[cfg(test)]
#[path = "merge_tests.rs"]
mod tests;
