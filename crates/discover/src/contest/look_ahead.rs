//! Comparison of pairs: one candidate with many coefficients may imitate two simple effects better than
//! either of them alone.
//!
//! Before the best competitor is accepted, each competitor is joined with its best partner, and the pairs are
//! compared ([`crate::contest::pair`]). When the best pair without the leading competitor has a score that is smaller by
//! `pair_ties` times `tie` ([`crate::policy::Policy`]) than the leading competitor with its partner, the member of that pair with the
//! smaller score is moved to the front. The leading competitor is excluded as a partner.

use crate::contest::competitor::Competitor;
use crate::contest::pair::{Side, pair_score};
use crate::error::DiscoverError;
use crate::hypotheses::candidate::Candidate;
use crate::policy::penalty_per_coefficient;
use crate::problem::linearisation::Linearisation;
use crate::problem::projection::Accumulated;
use crate::screen::candidates::{Cause, Screen};
use rayon::prelude::*;
use truepose_errormodel::Visits;

/// The position of the competitor that comes first.
pub(crate) fn first(
    linearisation: &Linearisation<'_>,
    screen: &Screen,
    visits: &Visits,
    competitors: &[Competitor],
    causes: &[Cause],
) -> Result<usize, DiscoverError> {
    if competitors.len() < 2 {
        return Ok(0);
    }
    let penalty = penalty_per_coefficient(linearisation.len());
    let first: Vec<&Candidate> = causes
        .iter()
        .filter(|cause| cause.family.is_named())
        .take(linearisation.budget.partners)
        .map(|cause| &cause.variants[0].0)
        .collect();
    let partners: Vec<(&Candidate, Accumulated)> = first
        .into_par_iter()
        .map(|candidate| Ok((candidate, screen.projection.accumulate(linearisation, candidate)?)))
        .collect::<Result<_, DiscoverError>>()?;
    let named: Vec<usize> = (0..competitors.len())
        .filter(|&k| k == 0 || competitors[k].candidate.family.is_named())
        .take(linearisation.budget.competitors)
        .collect();
    let pairs: Vec<Option<(f64, Candidate, f64)>> = named
        .par_iter()
        .map(|&k| -> Result<Option<(f64, Candidate, f64)>, DiscoverError> {
            let competitor = &competitors[k];
            let alike = |partner: &Candidate, k: usize| partner.same_cause(&competitors[k].candidate);
            let others: Vec<&(&Candidate, Accumulated)> =
                partners.iter().filter(|(partner, _)| !alike(partner, k) && !alike(partner, 0)).collect();
            let accumulated: Vec<&Accumulated> = others.iter().map(|(_, accumulated)| accumulated).collect();
            let Some(gains) = screen.projection.beside(&competitor.columns, &accumulated) else {
                return Ok(None);
            };
            let best = others
                .iter()
                .zip(gains)
                .filter_map(|((partner, _), gain)| {
                    let (gain, freedom) = gain?;
                    Some((gain - penalty * freedom as f64, freedom, *partner))
                })
                .max_by(|a, b| a.0.total_cmp(&b.0));
            let Some((worth, freedom, partner)) =
                best.filter(|best| best.0 > linearisation.policy.partner_margin)
            else {
                return Ok(Some((competitor.score, competitor.candidate.clone(), 0.0)));
            };
            let columns = linearisation.columns_of(partner)?;
            let (own, other) = (
                Side {
                    candidate: &competitor.candidate,
                    columns: &competitor.columns,
                    freedom: competitor.freedom,
                },
                Side { candidate: partner, columns: &columns, freedom },
            );
            let score = pair_score(linearisation, screen, visits, [own, other])?;
            Ok(Some((score.min(competitor.score), partner.clone(), worth)))
        })
        .collect::<Result<_, _>>()?;
    let mut best: Option<(usize, f64)> = None;
    for (&k, pair) in named.iter().zip(&pairs) {
        if let Some((score, ..)) = pair
            && best.is_none_or(|(_, least)| *score < least)
        {
            best = Some((k, *score));
        }
    }
    let Some((chosen, score)) = best else { return Ok(0) };
    let Some((own, ..)) = &pairs[0] else { return Ok(0) };
    if chosen == 0 || score > own - linearisation.policy.pair_ties * linearisation.policy.tie {
        return Ok(0);
    }
    // The member of the pair with the smaller score, if it is a competitor as well; a competitor that is
    // weaker than its partner is not moved to the front.
    let Some((_, partner, worth)) = &pairs[named.iter().position(|&k| k == chosen).unwrap_or(0)] else {
        return Ok(chosen);
    };
    let other = competitors
        .iter()
        .position(|r| r.candidate.same_cause(partner) && r.score < competitors[chosen].score);
    let weaker = *worth > competitors[chosen].gain;
    Ok(other.unwrap_or(if weaker { 0 } else { chosen }))
}
