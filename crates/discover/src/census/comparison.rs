//! The best causes of a screen of all rows, each with its nonlinear parameter refined, compared on all rows.
//!
//! The score is that of [`crate::contest::competitor`] with the noise of the fit: −gain + k ln m + π.

use crate::census::all_rows::AllRows;
use crate::census::blocks::Blocks;
use crate::census::details::Detail;
use crate::census::sums::sums;
use crate::contest::names::name_prior;
use crate::contest::penalty::log_prior_odds;
use crate::error::DiscoverError;
use crate::hypotheses::candidate::Candidate;
use crate::hypotheses::change::Change;
use crate::hypotheses::family::Family;
use crate::hypotheses::limits::Limit;
use crate::hypotheses::nonlinear::Refinement;
use crate::hypotheses::place::Place;
use crate::options::DiscoverOptions;
use crate::problem::linearisation::Linearisation;
use crate::screen::candidates::{Cause, Screen};
use std::sync::Arc;

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

/// What all rows say of the causes of one screen that were looked at: a cause that is barred changes nothing in it.
#[derive(Default)]
pub(crate) struct Known(Vec<KnownCause>);

struct KnownCause {
    family: Family,
    place: Place,
    variants: Vec<(Candidate, Detail)>,
}

impl KnownCause {
    fn is(&self, (family, place): (Family, &Place)) -> bool {
        self.family == family && self.place == *place
    }
}

/// Compares the best causes that are not barred; none where nothing is left of them. `known` are those of earlier comparisons of the screen.
pub(crate) fn compared(
    linearisation: &Linearisation<'_>,
    screen: &Screen,
    (barred, known): (&[Candidate], &mut Known),
    (all, blocks): (&AllRows, &Blocks),
    options: &DiscoverOptions,
) -> Result<Option<Compared>, DiscoverError> {
    let budget = &options.budget;
    let causes = screen.causes(linearisation);
    let best = causes.iter().map(|cause| cause.variants[0].1).fold(0.0, f64::max);
    let is_barred = |family, place: &Place| barred.iter().any(|b| b.family == family && b.place == *place);
    let mut shortlist: Vec<Candidate> = Vec::new();
    let open: Vec<Cause> =
        causes.into_iter().filter(|cause| !is_barred(cause.family, &cause.place)).collect();
    let own: Vec<(Family, Place)> =
        open.iter().take(budget.causes).map(|cause| (cause.family, cause.place.clone())).collect();
    // After a refusal with those that come in at the next ones: a pass over the rows for each costs more.
    let ahead = match barred.len() {
        0 => 0,
        refused => budget.contests.saturating_sub(1 + refused),
    };
    let is_new = |cause: &Cause| !known.0.iter().any(|known| known.is((cause.family, &cause.place)));
    for cause in open.into_iter().take(budget.causes + ahead).filter(is_new) {
        // One of each size, as in a contest.
        let mut sizes = Vec::new();
        for (candidate, _, freedom) in cause.variants {
            let size = (freedom, candidate.scales());
            let wanted = sizes.len() < budget.variants && !sizes.contains(&size);
            if wanted && matches!(candidate.change, Change::Add(_)) {
                sizes.push(size);
                shortlist.push(Arc::unwrap_or_clone(candidate));
            }
        }
    }
    let stride = stride(best, blocks);
    let refined = refined(linearisation, shortlist, (all, blocks, stride), options)?;
    for of_cause in refined.chunk_by(|a, b| a.0.same_cause(&b.0)) {
        let (family, place) = (of_cause[0].0.family, of_cause[0].0.place.clone());
        let judged =
            of_cause.iter().filter_map(|(candidate, detail)| Some((candidate.clone(), detail.clone()?)));
        known.0.push(KnownCause { family, place, variants: judged.collect() });
    }
    let penalty = (all.count as f64).ln();
    let judged = known.0.iter().filter(|known| own.iter().any(|(family, place)| known.is((*family, place))));
    let mut competitors: Vec<Competitor> = judged
        .flat_map(|known| known.variants.iter().cloned())
        .filter_map(|(candidate, detail)| {
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
    // Of these the one with the most probable name.
    let of_name = |c: &Competitor| c.score - c.prior + name_prior(c.candidate.family, &options.policy);
    let likeliest = competitors[..tied].iter().map(of_name).fold(f64::INFINITY, f64::min);
    let alike = likeliest + options.policy.same_explanation;
    if let Some(first) = competitors[..tied].iter().position(|c| of_name(c) <= alike) {
        competitors[..=first].rotate_right(1);
    }
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

/// A value of a candidate's nonlinear parameter, and what was said of it.
struct Tried {
    /// Its part of what the screen leaves open, −1 … 1.
    at: f64,
    candidate: Candidate,
    detail: Detail,
}

/// The candidates with their nonlinear parameters refined, and what all rows say of each: the best of a grid about the value, then up to twice the
/// vertex of the parabola through the best value and its neighbours.
fn refined(
    linearisation: &Linearisation<'_>,
    candidates: Vec<Candidate>,
    (all, blocks, stride): (&AllRows, &Blocks, usize),
    options: &DiscoverOptions,
) -> Result<Vec<(Candidate, Option<Detail>)>, DiscoverError> {
    /// Values to either side.
    const SIDE: i32 = 4;
    let details = |tried: &[Candidate], stride: usize| -> Result<Vec<Option<Detail>>, DiscoverError> {
        let sums = sums(tried, (all, blocks), stride, options)?;
        Ok(sums.into_iter().map(|sums| Detail::of(&sums?, all, stride, &options.policy)).collect())
    };
    let mut known: Vec<Vec<Tried>> = candidates.iter().map(|_| Vec::new()).collect();
    for round in 0..3 {
        let mut next: Vec<(usize, f64, Candidate)> = Vec::new();
        for (k, candidate) in candidates.iter().enumerate() {
            let before = next.len();
            let places: Vec<f64> = match round {
                0 => (-SIDE..=SIDE).map(|step| f64::from(step) / f64::from(SIDE)).collect(),
                _ => {
                    let of: Vec<[f64; 2]> =
                        known[k].iter().map(|tried| [tried.at, tried.detail.gain]).collect();
                    vertex(&of).into_iter().collect()
                }
            };
            let moved = |at: f64| Some((k, at, moved(linearisation, candidate, at)?));
            next.extend(places.into_iter().filter_map(moved));
            if round == 0 && next.len() == before {
                next.push((k, 0.0, candidate.clone()));
            }
        }
        let others: Vec<Candidate> = next.iter().map(|next| next.2.clone()).collect();
        for ((k, at, candidate), detail) in next.into_iter().zip(details(&others, stride)?) {
            if let Some(detail) = detail {
                let place = known[k].partition_point(|other| other.at < at);
                known[k].insert(place, Tried { at, candidate, detail });
            }
        }
    }
    let best = |(candidate, tried): (Candidate, Vec<Tried>)| {
        let best = tried.into_iter().max_by(|a, b| a.detail.gain.total_cmp(&b.detail.gain));
        best.map_or((candidate, None), |best| (best.candidate, Some(best.detail)))
    };
    let best: Vec<(Candidate, Option<Detail>)> = candidates.into_iter().zip(known).map(best).collect();
    if stride == 1 {
        return Ok(best);
    }
    let chosen: Vec<Candidate> = best.into_iter().map(|(candidate, _)| candidate).collect();
    let of_all = details(&chosen, 1)?;
    Ok(chosen.into_iter().zip(of_all).collect())
}

/// Where the parabola through the best value and its neighbours has its vertex; in the middle of the last gap where the best value is an end. None where that would
/// win nothing over the best value. `tried`: values, ascending, with the gain of each.
fn vertex(tried: &[[f64; 2]]) -> Option<f64> {
    /// Parts of the range nearer than that are one value.
    const NEAR: f64 = 2e-3;
    /// A gain that is none: a third of the standard deviation of the parameter.
    const NOTHING: f64 = 0.1;
    let gain = |k: usize| tried[k][1];
    let best = (0..tried.len()).max_by(|&a, &b| gain(a).total_cmp(&gain(b)))?;
    let at = |k: usize| tried[k][0];
    let wanted = match (best.checked_sub(1), (best + 1 < tried.len()).then_some(best + 1)) {
        (Some(left), Some(right)) => {
            let (to_left, to_right) = (at(best) - at(left), at(best) - at(right));
            let (fall_left, fall_right) = (gain(best) - gain(left), gain(best) - gain(right));
            let bend = to_left * fall_right - to_right * fall_left;
            let slope = to_left * to_left * fall_right - to_right * to_right * fall_left;
            // Of the parabola through the three values.
            let won = 0.25 * slope * slope / (bend * to_left * -to_right * (to_left - to_right));
            if won < NOTHING {
                return None;
            }
            at(best) - 0.5 * slope / bend
        }
        (Some(other), None) | (None, Some(other)) => 0.5 * (at(best) + at(other)),
        (None, None) => return None,
    };
    (wanted.is_finite() && tried.iter().all(|other| (other[0] - wanted).abs() > NEAR)).then_some(wanted)
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_best_value_lies_at_the_vertex_and_beyond_an_end_half_a_gap_is_tried() {
        let grid = |peak: f64| -> Vec<[f64; 2]> {
            (-4..=4).map(|k| 0.25 * f64::from(k)).map(|at| [at, 50.0 - 30.0 * (at - peak).powi(2)]).collect()
        };
        for peak in [-0.61, 0.07, 0.31] {
            assert!((vertex(&grid(peak)).unwrap() - peak).abs() < 1e-12);
        }
        // The best value is there already.
        assert_eq!(vertex(&grid(0.25)), None);
        assert_eq!(vertex(&grid(1.4)), Some(0.875));
        // Neighbours that are not equally far away, as after a first vertex.
        let uneven = |bend: f64| [-0.5, 0.1, 0.2].map(|at: f64| [at, 3.0 - bend * (at - 0.13).powi(2)]);
        assert!((vertex(&uneven(200.0)).unwrap() - 0.13).abs() < 1e-12);
        // It would win 0.09.
        assert_eq!(vertex(&uneven(100.0)), None);
        assert_eq!(vertex(&[[0.0, 1.0]]), None);
    }
}
