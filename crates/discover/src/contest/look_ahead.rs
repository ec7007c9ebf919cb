//! Comparison of pairs: one candidate with many coefficients may imitate two simple effects better than
//! either of them alone.
//!
//! Before the best competitor is accepted, each competitor is joined with its best partner, and the pairs are
//! compared ([`crate::contest::pair`]). Partners are weighed under the noise of the competitor: under that of the present model, which has the
//! effect in its residual, a partner explains next to nothing. When the best pair without the leading competitor has a score that is smaller by
//! `pair_ties` times `tie` ([`crate::policy::Policy`]) than the leading competitor with its partner, the member of that pair with the
//! smaller score is moved to the front. The leading competitor is excluded as a partner.

use crate::contest::competitor::Competitor;
use crate::contest::names::name_prior;
use crate::contest::pair::{Partner, Side, pair_score, yield_together};
use crate::contest::penalty::prior_penalty;
use crate::error::DiscoverError;
use crate::hypotheses::candidate::Candidate;
use crate::policy::{Policy, penalty_per_coefficient};
use crate::problem::beside::Pool;
use crate::problem::linearisation::Linearisation;
use crate::screen::candidates::{Cause, Screen};
use rayon::prelude::*;
use truepose_errormodel::Visits;

/// Joins the named competitors and the leading one with their best partners.
pub(crate) fn join(
    linearisation: &Linearisation<'_>,
    screen: &Screen,
    visits: &Visits,
    competitors: &mut [Competitor],
    causes: &[&Cause],
) -> Result<(), DiscoverError> {
    if competitors.len() < 2 {
        return Ok(());
    }
    let named = causes.iter().filter(|cause| cause.family.is_named());
    let partners: Vec<&Cause> = named.take(linearisation.budget.partners).copied().collect();
    let joined: Vec<usize> = (0..competitors.len())
        .filter(|&k| k == 0 || competitors[k].candidate.family.is_named())
        .take(linearisation.budget.competitors)
        .collect();
    let columns = partners.par_iter().map(|partner| partner.columns(linearisation));
    let columns = columns.collect::<Result<Vec<_>, _>>()?;
    let pool = Pool::new(linearisation, &columns);
    let best: Vec<Option<Partner>> = joined
        .par_iter()
        .map(|&k| {
            let alike =
                |partner: &Candidate| [k, 0].iter().any(|&k| partner.same_cause(&competitors[k].candidate));
            let may = |partner: &Cause| !alike(&partner.variants[0].0);
            partner((linearisation, screen, visits), &competitors[k], (&partners, &pool), &may)
        })
        .collect::<Result<_, _>>()?;
    for (k, partner) in joined.into_iter().zip(best) {
        competitors[k].partner = partner;
    }
    Ok(())
}

/// The best of the partners that a competitor `may` have, each the best variant of its cause; `None` where none is worth its unknowns.
fn partner(
    (linearisation, screen, visits): (&Linearisation<'_>, &Screen, &Visits),
    competitor: &Competitor,
    (partners, pool): (&[&Cause], &Pool),
    may: &dyn Fn(&Cause) -> bool,
) -> Result<Option<Partner>, DiscoverError> {
    let gains = pool.gains(linearisation, &competitor.columns, competitor.likelihood.noise);
    let penalty = penalty_per_coefficient(linearisation.len());
    let worth = |(k, gain): (usize, Option<(f64, usize)>)| {
        let (gain, freedom) = gain.filter(|_| may(partners[k]))?;
        let worth = gain - penalty * freedom as f64;
        let partner = &partners[k].variants[0].0;
        // A drive beside a drive is expected; any other cause has to be probable by itself.
        let prior = match yield_together(&competitor.candidate, partner) {
            true => 0.0,
            false => {
                prior_penalty(linearisation, screen, partner)
                    + name_prior(partner.family, linearisation.policy)
            }
        };
        (worth > linearisation.policy.partner_margin).then_some((worth - prior, freedom, k))
    };
    let best = gains.into_iter().enumerate().filter_map(worth).max_by(|a, b| a.0.total_cmp(&b.0));
    let Some((_, freedom, k)) = best else { return Ok(None) };
    let (candidate, alone, _) = &partners[k].variants[0];
    let own =
        Side { candidate: &competitor.candidate, columns: &competitor.columns, freedom: competitor.freedom };
    let other = Side { candidate, columns: partners[k].columns(linearisation)?, freedom };
    let score = pair_score(linearisation, screen, visits, [own, other])?;
    Ok(Some(Partner { candidate: (**candidate).clone(), score, leads: *alone > competitor.gain }))
}

/// The position of the competitor that comes first, of competitors that were joined with their partners.
pub(crate) fn first(competitors: &[Competitor], policy: &Policy) -> usize {
    let with_partner = |r: &Competitor| {
        let pair = r.partner.as_ref().map_or(f64::INFINITY, |partner| partner.score.total);
        pair.min(r.score)
    };
    // Those that were joined: the others have no partner, and a score that is no smaller.
    let all = competitors.iter().enumerate().filter(|(k, r)| *k == 0 || r.candidate.family.is_named());
    let best = all.min_by(|a, b| with_partner(a.1).total_cmp(&with_partner(b.1)));
    let Some((chosen, pair)) = best else { return 0 };
    if chosen == 0 || with_partner(pair) > with_partner(&competitors[0]) - policy.pair_ties * policy.tie {
        return 0;
    }
    // The member of the pair with the smaller score, if it is a competitor as well; a competitor that is
    // weaker than its partner is not moved to the front.
    let Some(partner) = &pair.partner else { return chosen };
    let other =
        competitors.iter().position(|r| r.candidate.same_cause(&partner.candidate) && r.score < pair.score);
    other.unwrap_or(if partner.leads { 0 } else { chosen })
}
