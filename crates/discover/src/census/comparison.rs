//! The best causes of a screen of all rows, each with its nonlinear parameter refined, compared on all rows.
//!
//! The score is that of [`crate::contest::competitor`] with the noise of the fit: −gain + k ln m + π.

use crate::census::all_rows::AllRows;
use crate::census::blocks::Blocks;
use crate::census::details::Detail;
use crate::census::scores::sums;
use crate::contest::penalty::log_prior_odds;
use crate::error::DiscoverError;
use crate::hypotheses::candidate::Candidate;
use crate::hypotheses::change::Change;
use crate::hypotheses::limits::Limit;
use crate::hypotheses::nonlinear::Refinement;
use crate::options::DiscoverOptions;
use crate::problem::linearisation::Linearisation;
use crate::screen::candidates::Screen;

/// The best candidate, and those that it was preferred to.
pub(crate) struct Compared {
    pub candidate: Candidate,
    /// With the differences of score from it.
    pub competitors: Vec<(Candidate, f64)>,
    pub prior_width: f64,
    pub detail: Detail,
}

struct Competitor {
    candidate: Candidate,
    detail: Detail,
    score: f64,
    /// The part of the score that does not depend on the data.
    prior: f64,
}

/// Compares the best causes that are not barred; none where nothing is left of them.
pub(crate) fn compared(
    linearisation: &Linearisation<'_>,
    screen: &Screen,
    barred: &[Candidate],
    (all, blocks): (&AllRows, &Blocks),
    options: &DiscoverOptions,
) -> Result<Option<Compared>, DiscoverError> {
    let budget = &options.budget;
    let causes = screen.causes(linearisation);
    let best = causes.iter().map(|cause| cause.variants[0].1).fold(0.0, f64::max);
    let open = causes
        .into_iter()
        .filter(|cause| !barred.iter().any(|b| b.family == cause.family && b.place == cause.place));
    let mut shortlist: Vec<Candidate> = Vec::new();
    for cause in open.take(budget.causes) {
        // One of each size, as in a contest.
        let mut sizes = Vec::new();
        for (candidate, _, freedom) in cause.variants {
            let size = (freedom, candidate.scales());
            let wanted = sizes.len() < budget.variants && !sizes.contains(&size);
            if wanted && matches!(candidate.change, Change::Add(_)) {
                sizes.push(size);
                shortlist.push(candidate);
            }
        }
    }
    let stride = stride(best, blocks);
    let shortlist = refined(linearisation, shortlist, (all, blocks, stride), options)?;
    let penalty = (all.count as f64).ln();
    let of_all = sums(&shortlist, (all, blocks), 1, options)?;
    let mut competitors: Vec<Competitor> = shortlist
        .into_iter()
        .zip(of_all)
        .filter_map(|(candidate, sums)| {
            let detail = Detail::of(&sums?, all, 1, &options.policy)?;
            let counted = penalty * detail.freedom() as f64;
            // All by evidence: at so many numbers a count would favour curves, which the contest of a sample charges so.
            let cost = detail.distribution.penalty.min(counted);
            let prior = log_prior_odds(linearisation, screen, &candidate);
            let score = cost + prior - detail.gain;
            let pushes =
                detail.coefficients[0] <= -options.policy.negative_compliance * detail.first_deviation;
            let wide = detail.distribution.width > options.policy.wide;
            let physical = !(pushes && candidate.has_limit(Limit::FirstNotNegative)
                || wide && candidate.has_limit(Limit::BoundedWidth));
            (physical && score < 0.0).then_some(Competitor { candidate, detail, score, prior })
        })
        .collect();
    competitors.sort_by(|a, b| a.score.total_cmp(&b.score));
    let Some(least) = competitors.first().map(|c| c.score) else { return Ok(None) };
    let tied = competitors.iter().take_while(|c| c.score < least + options.policy.tie).count();
    competitors[..tied].sort_by(|a, b| {
        let family = a.candidate.hypothesis().rank().cmp(&b.candidate.hypothesis().rank());
        let unknowns = |c: &Competitor| c.detail.freedom() + c.candidate.nonlinear().count();
        family.then(unknowns(a).cmp(&unknowns(b))).then(a.score.total_cmp(&b.score))
    });
    let winner = competitors.remove(0);
    let mut others: Vec<(Candidate, f64)> = Vec::new();
    for other in competitors {
        let same = other.candidate.same_cause(&winner.candidate)
            || others.iter().any(|(known, _)| known.same_cause(&other.candidate));
        if !same {
            let behind = (other.score - other.prior) - (winner.score - winner.prior);
            others.push((other.candidate, behind));
        }
    }
    let prior_width = options.policy.prior_widths * winner.detail.distribution.width.max(1e-3);
    Ok(Some(Compared {
        candidate: winner.candidate,
        competitors: others,
        prior_width,
        detail: winner.detail,
    }))
}

/// Every how many blocks are enough to place a nonlinear parameter: a statistic of some hundreds does.
fn stride(gain: f64, blocks: &Blocks) -> usize {
    const ENOUGH: f64 = 1000.0;
    ((gain / ENOUGH) as usize).clamp(1, (blocks.units() / 12).max(1))
}

/// The candidates with their nonlinear parameters refined: the best of a grid about the value, then of a finer one.
fn refined(
    linearisation: &Linearisation<'_>,
    candidates: Vec<Candidate>,
    (all, blocks, stride): (&AllRows, &Blocks, usize),
    options: &DiscoverOptions,
) -> Result<Vec<Candidate>, DiscoverError> {
    /// Values to either side.
    const SIDE: i32 = 4;
    let mut best = candidates;
    let mut reach = 1.0;
    for _ in 0..3 {
        let mut tried: Vec<(usize, Candidate)> = Vec::new();
        for (k, candidate) in best.iter().enumerate() {
            for step in -SIDE..=SIDE {
                let at = reach * f64::from(step) / f64::from(SIDE);
                tried.extend(moved(linearisation, candidate, at).map(|other| (k, other)));
            }
        }
        if tried.is_empty() {
            break;
        }
        let others: Vec<Candidate> = tried.iter().map(|t| t.1.clone()).collect();
        let mut gains = vec![f64::NEG_INFINITY; best.len()];
        for ((k, other), sums) in tried.into_iter().zip(sums(&others, (all, blocks), stride, options)?) {
            let detail = sums.and_then(|sums| Detail::of(&sums, all, stride, &options.policy));
            if let Some(detail) = detail.filter(|detail| detail.gain > gains[k]) {
                gains[k] = detail.gain;
                best[k] = other;
            }
        }
        reach /= f64::from(SIDE);
    }
    Ok(best)
}

/// A candidate with its nonlinear parameter moved by a part, −1 … 1, of what the screen leaves open; none where it has no such parameter.
fn moved(linearisation: &Linearisation<'_>, candidate: &Candidate, part: f64) -> Option<Candidate> {
    let [_] = candidate.effects() else { return None };
    let nonlinear = candidate.nonlinear().next()?;
    let value = nonlinear.value;
    match nonlinear.search {
        Refinement::Period(joint) => {
            let range = linearisation.travel(joint)?.max(1e-9);
            candidate.with_value(1.0 / (1.0 / value + 0.25 * part / range).max(1e-12))
        }
        Refinement::Instant { .. } => {
            let times = &linearisation.data.time;
            let from = times.iter().copied().fold(f64::INFINITY, f64::min);
            let until = times.iter().copied().fold(f64::NEG_INFINITY, f64::max);
            candidate.with_value(value + part * (until - from) / 64.0)
        }
        Refinement::Scale([lower, upper]) | Refinement::Plateau([lower, upper]) => {
            let end = if part < 0.0 { lower } else { upper };
            candidate.with_value(value * (end.ln() * part.abs()).exp())
        }
        Refinement::Within([lower, upper]) => {
            let end = if part < 0.0 { lower } else { upper };
            candidate.with_value(value + (end - value) * part.abs())
        }
        Refinement::Edge(joint) => candidate.with_value(value + part * linearisation.travel(joint)? / 64.0),
        Refinement::Grid => None,
    }
}
