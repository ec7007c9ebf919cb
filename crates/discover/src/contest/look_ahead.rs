//! One step ahead: a rich cause may imitate two simple ones, better than either of them alone.
//!
//! Before the best rival is believed, each rival is given its best partner, and pairs are compared:
//!
//! ```text
//! score(a + b) = −2 ln L(a + b) + C_a + C_b + 2 ln(questions asked of each family)
//! ```
//!
//! When a pair without the best rival is better than the best rival with its own partner, the stronger half of that pair goes first. The
//! best rival is nobody else's partner.

use crate::contest::rival::{Rival, cost, odds};
use crate::error::DiscoverError;
use crate::hypotheses::candidate::Candidate;
use crate::hypotheses::family::Family;
use crate::policy::{TIE, price};
use crate::problem::likelihood::Likelihood;
use crate::problem::linearisation::Scene;
use crate::problem::projection::Heard;
use crate::screen::candidates::{Cause, Screen};
use rayon::prelude::*;
use truepose_errormodel::Visits;

/// Rivals that are given a partner, and partners tried.
const RIVALS: usize = 8;
const PARTNERS: usize = 80;
/// A partner that gains less is chance.
const LEAST: f64 = 12.0;

/// The position of the rival that should go first.
pub(crate) fn first(
    scene: &Scene<'_>,
    screen: &Screen,
    visits: &Visits,
    rivals: &[Rival],
    causes: &[Cause],
) -> Result<usize, DiscoverError> {
    if rivals.len() < 2 {
        return Ok(0);
    }
    let price = price(scene.len());
    let first: Vec<&Candidate> = causes
        .iter()
        .filter(|cause| cause.family != Family::Unmodelled)
        .take(PARTNERS)
        .map(|cause| &cause.variants[0].0)
        .collect();
    let partners: Vec<(&Candidate, Heard)> = first
        .into_par_iter()
        .map(|candidate| Ok((candidate, screen.projection.hear(scene, candidate)?)))
        .collect::<Result<_, DiscoverError>>()?;
    let named: Vec<usize> = (0..rivals.len())
        .filter(|&k| k == 0 || rivals[k].candidate.family != Family::Unmodelled)
        .take(RIVALS)
        .collect();
    let pairs: Vec<Option<(f64, Candidate, f64)>> = named
        .par_iter()
        .map(|&k| -> Result<Option<(f64, Candidate, f64)>, DiscoverError> {
            let rival = &rivals[k];
            let alike = |partner: &Candidate, k: usize| partner.same_cause(&rivals[k].candidate);
            let others: Vec<&(&Candidate, Heard)> =
                partners.iter().filter(|(partner, _)| !alike(partner, k) && !alike(partner, 0)).collect();
            let heard: Vec<&Heard> = others.iter().map(|(_, heard)| heard).collect();
            let Some(gains) = screen.projection.beside(&rival.columns, &heard) else { return Ok(None) };
            let best = others
                .iter()
                .zip(gains)
                .filter_map(|((partner, _), gain)| {
                    let (gain, freedom) = gain?;
                    Some((gain - price * freedom as f64, freedom, *partner))
                })
                .max_by(|a, b| a.0.total_cmp(&b.0));
            let Some((worth, freedom, partner)) = best.filter(|best| best.0 > LEAST) else {
                return Ok(Some((rival.score, rival.candidate.clone(), 0.0)));
            };
            let columns = scene.columns_of(partner)?;
            let width = rival.columns.ncols() + columns.ncols();
            let mut both = rival.columns.clone().resize_horizontally(width, 0.0);
            both.columns_mut(rival.columns.ncols(), columns.ncols()).copy_from(&columns);
            let likelihood = Likelihood::new(scene, &both, visits)?;
            let own = rival.columns.ncols();
            let costs = cost(&rival.candidate, &likelihood.law(0..own), rival.freedom, scene)
                + cost(partner, &likelihood.law(own..width), freedom, scene);
            let score = likelihood.deviance + costs + rival.odds + odds(scene, screen, partner);
            Ok(Some((score.min(rival.score), partner.clone(), worth)))
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
    if chosen == 0 || score > own - 2.0 * TIE {
        return Ok(0);
    }
    // The stronger half of the pair, if it is a rival as well; whoever shines only beside a stronger one does not go first.
    let Some((_, partner, worth)) = &pairs[named.iter().position(|&k| k == chosen).unwrap_or(0)] else {
        return Ok(chosen);
    };
    let other = rivals.iter().position(|r| r.candidate.same_cause(partner) && r.score < rivals[chosen].score);
    let weaker = *worth > rivals[chosen].gain;
    Ok(other.unwrap_or(if weaker { 0 } else { chosen }))
}
