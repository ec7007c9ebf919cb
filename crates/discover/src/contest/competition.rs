//! Comparison of the best candidates of a screen, each with its nonlinear parameters optimised and its noise
//! estimated.
//!
//! The smallest score ([`crate::contest::competitor`]) wins; of the competitors whose scores are not
//! distinguishable from it, the one whose name is the most probable ([`crate::contest::names`]).

use crate::contest::competitor::{Competitor, competitor, plausible};
use crate::contest::look_ahead;
use crate::error::DiscoverError;
use crate::hypotheses::candidate::Candidate;
use crate::hypotheses::change::Change;
use crate::hypotheses::family::Family;
use crate::hypotheses::place::Place;
use crate::hypotheses::setting::Setting;
use crate::policy::{Policy, penalty_per_coefficient};
use crate::problem::likelihood::Likelihood;
use crate::problem::linearisation::Linearisation;
use crate::problem::projection::Projection;
use crate::screen::candidates::{Cause, Screen};
use crate::screen::periodogram;
use crate::screen::refine::refined;
use nalgebra::DMatrix;
use rayon::prelude::*;
use truepose_errormodel::Visits;

/// The competitors, the preferred one first, and the likelihood of the present model.
pub(crate) struct Contest {
    pub present: Likelihood,
    pub competitors: Vec<Competitor>,
}

/// Compares the best candidates of a screen, except those that are barred. With `more_periods_allowed`
/// further periods are added to the best transmissions: in a search for a new finding, and in the
/// reconsideration of a transmission.
pub(crate) fn contest(
    linearisation: &Linearisation<'_>,
    screen: &Screen,
    barred: &[Candidate],
    more_periods_allowed: bool,
) -> Result<Contest, DiscoverError> {
    let visits = Visits::of(linearisation.data);
    let present = Likelihood::new(linearisation, &DMatrix::zeros(linearisation.len(), 0), &visits)?;
    let mut causes = screen.causes(linearisation);
    causes.retain(|cause| !barred.iter().any(|b| b.family == cause.family && b.place == cause.place));
    let mut found: Vec<Vec<Competitor>> = selected(linearisation, &causes, screen.opener())
        .par_iter()
        .map(|cause| refined_variants(linearisation, screen, &visits, cause))
        .collect::<Result<_, _>>()?;
    if more_periods_allowed {
        add_periods(linearisation, screen, &visits, &mut found)?;
    }
    let competitors: Vec<Competitor> =
        found.into_iter().filter_map(|shapes| simplest(shapes, linearisation.policy)).collect();
    let best = least(&competitors);
    let mut competitors: Vec<Competitor> = competitors
        .into_par_iter()
        .map(|r| {
            if r.score < best + component_reach(&r, linearisation.policy) {
                with_best_components(linearisation, screen, &visits, r)
            } else {
                Ok(r)
            }
        })
        .collect::<Result<_, _>>()?;
    rank(&mut competitors, linearisation.policy);
    look_ahead::join(linearisation, screen, &visits, &mut competitors, &causes)?;
    let first = look_ahead::first(&competitors, linearisation.policy);
    // None at all where no candidate is plausible.
    if let Some(before) = competitors.get_mut(..=first) {
        before.rotate_right(usize::from(first > 0));
    }
    Ok(Contest { present, competitors })
}

/// The best groups of candidates, the one with the smallest p, and the best group of every named family that has none among them.
fn selected<'a>(
    linearisation: &Linearisation<'_>,
    causes: &'a [Cause],
    opener: Option<(Family, Place)>,
) -> Vec<&'a Cause> {
    let penalty = penalty_per_coefficient(linearisation.len());
    let mut selected: Vec<&Cause> = causes.iter().take(linearisation.budget.causes).collect();
    for cause in causes.iter().skip(linearisation.budget.causes) {
        let (_, gain, freedom) = &cause.variants[0];
        let known = selected.iter().any(|other| other.family == cause.family);
        let opens =
            opener.as_ref().is_some_and(|(family, place)| (*family, place) == (cause.family, &cause.place));
        let first_of_family = cause.family.is_named() && !known && gain - penalty * *freedom as f64 > 0.0;
        if opens || first_of_family {
            selected.push(cause);
        }
    }
    selected
}

/// The variants of a group, one for each number of coefficients and of nonlinear parameters on a coarse grid, with these optimised: the best
/// value of such a parameter hides the law without it in the screen, though that may predict as well.
fn refined_variants(
    linearisation: &Linearisation<'_>,
    screen: &Screen,
    visits: &Visits,
    cause: &Cause,
) -> Result<Vec<Competitor>, DiscoverError> {
    let mut competitors = Vec::new();
    let mut sizes = Vec::new();
    for (candidate, _, freedom) in &cause.variants {
        let size = (*freedom, candidate.scales());
        if sizes.contains(&size) || sizes.len() >= linearisation.budget.variants {
            continue;
        }
        sizes.push(size);
        let variant = refined(linearisation, &screen.projection, candidate);
        competitors.extend(competitor(linearisation, screen, visits, variant)?);
    }
    competitors.extend(richer(linearisation, screen, visits, cause)?);
    Ok(competitors)
}

/// The best richer variants of a group, one for each number of coefficients and of nonlinear parameters: all are compared by their gain,
/// the best ones as competitors.
fn richer(
    linearisation: &Linearisation<'_>,
    screen: &Screen,
    visits: &Visits,
    cause: &Cause,
) -> Result<Vec<Competitor>, DiscoverError> {
    let setting = Setting::new(linearisation.chain(), linearisation.data);
    let mut sizes = Vec::new();
    let mut all: Vec<(Candidate, f64)> = Vec::new();
    let penalty = penalty_per_coefficient(linearisation.len());
    // What does not pay for its own unknowns is not made richer.
    let pays = cause.variants.iter().filter(|(_, gain, freedom)| *gain > penalty * *freedom as f64);
    for (variant, _, freedom) in pays {
        let size = (*freedom, variant.scales());
        if sizes.contains(&size) || sizes.len() >= linearisation.budget.richer {
            continue;
        }
        sizes.push(size);
        for more in variant.richer(&setting) {
            if let Some(score) = screen.projection.judge(linearisation, &more) {
                let worth = score.gain - penalty * score.freedom as f64;
                all.push((more, worth));
            }
        }
    }
    all.sort_by(|a, b| b.1.total_cmp(&a.1));
    all.truncate(linearisation.budget.richer);
    let refined = all.into_iter().map(|(more, _)| refined(linearisation, &screen.projection, &more));
    let competitors = refined.map(|more| competitor(linearisation, screen, visits, more));
    competitors.filter_map(Result::transpose).collect()
}

/// Adds further periods to the best transmissions.
fn add_periods(
    linearisation: &Linearisation<'_>,
    screen: &Screen,
    visits: &Visits,
    found: &mut [Vec<Competitor>],
) -> Result<(), DiscoverError> {
    let mut transmissions: Vec<usize> = (0..found.len())
        .filter(|&k| {
            found[k].first().is_some_and(|r| r.candidate.periodic_in(linearisation.chain()).is_some())
        })
        .collect();
    transmissions.sort_by(|&a, &b| least(&found[a]).total_cmp(&least(&found[b])));
    transmissions.truncate(linearisation.budget.transmissions);
    let grown: Vec<Option<Competitor>> = transmissions
        .par_iter()
        .map(|&k| {
            let best = found[k].iter().min_by(|a, b| a.score.total_cmp(&b.score));
            match best.and_then(|best| more_periods(linearisation, &screen.projection, &best.candidate)) {
                Some(candidate) => competitor(linearisation, screen, visits, candidate),
                None => Ok(None),
            }
        })
        .collect::<Result<_, _>>()?;
    transmissions.iter().zip(grown).for_each(|(&k, grown)| found[k].extend(grown));
    Ok(())
}

/// The simplest variant of a cause that is not distinguishable from the best one.
fn simplest(mut shapes: Vec<Competitor>, policy: &Policy) -> Option<Competitor> {
    shapes.retain(|r| plausible(r, policy) && r.score.is_finite());
    let best = least(&shapes);
    let tied = shapes.into_iter().filter(|r| r.score < best + policy.variant_ties * policy.tie);
    tied.min_by(|a, b| a.unknowns().cmp(&b.unknowns()).then(a.score.total_cmp(&b.score)))
}

/// Best first; of those that are not distinguishable from the best one, the one with the most probable name, and of those with the same
/// probability the simplest.
fn rank(competitors: &mut [Competitor], policy: &Policy) {
    competitors.sort_by(|a, b| a.score.total_cmp(&b.score));
    let best = least(competitors);
    let tied = competitors.iter().take_while(|r| r.score < best + policy.tie).count();
    let tied = &mut competitors[..tied];
    tied.sort_by(|a, b| {
        let family = a.candidate.hypothesis().rank().cmp(&b.candidate.hypothesis().rank());
        family.then(a.unknowns().cmp(&b.unknowns())).then(a.score.total_cmp(&b.score))
    });
    let likeliest = tied.iter().map(|r| r.name_score(policy)).fold(f64::INFINITY, f64::min);
    if let Some(first) = tied.iter().position(|r| r.name_score(policy) <= likeliest + policy.same_explanation)
    {
        tied[..=first].rotate_right(1);
    }
}

/// Largest distance from the best score at which other sets of components of a competitor are tried.
fn component_reach(competitor: &Competitor, policy: &Policy) -> f64 {
    match competitor.candidate.family.is_named() {
        true => policy.component_reach,
        false => policy.component_reach_unnamed,
    }
}

fn least(competitors: &[Competitor]) -> f64 {
    competitors.iter().map(|r| r.score).fold(f64::INFINITY, f64::min)
}

/// The competitor with the set of components of the smallest score: greedy descent, one component more or
/// fewer at a time.
fn with_best_components(
    linearisation: &Linearisation<'_>,
    screen: &Screen,
    visits: &Visits,
    mut current: Competitor,
) -> Result<Competitor, DiscoverError> {
    loop {
        let mut best: Option<Competitor> = None;
        for candidate in current.candidate.neighbours() {
            let Some(other) = competitor(linearisation, screen, visits, candidate)? else { continue };
            if other.score
                < best
                    .as_ref()
                    .map_or(current.score - linearisation.policy.component_margin, |best| best.score)
            {
                best = Some(other);
            }
        }
        match best {
            Some(better) => current = better,
            None => return Ok(current),
        }
    }
}

/// The same transmission with further periods, added by forward selection as long as each is significant on
/// the grid of periods and exceeds its penalty.
fn more_periods(
    linearisation: &Linearisation<'_>,
    present: &Projection,
    candidate: &Candidate,
) -> Option<Candidate> {
    let joint = candidate.periodic_in(linearisation.chain())?;
    let grid = periodogram::grid(linearisation, joint);
    let log_tests = (grid.len().max(2) as f64).ln();
    let threshold =
        2.0 * log_tests + 2.0 * penalty_per_coefficient(linearisation.len()) + linearisation.policy.tie;
    let mut grown = candidate.clone();
    let mut projection = present.with(&linearisation.columns_of(&grown).ok()?)?;
    let mut added = 0;
    while added < linearisation.budget.periods {
        let wave = periodogram::scan(linearisation, &projection, joint, &grid)?;
        let (period, gain, surprisal) = wave.strongest()?;
        // The surprisal among poses has to exceed ln(periods on the grid): Bonferroni's bound at one expected
        // false period, valid while other effects are missing.
        if gain < threshold || surprisal < log_tests {
            break;
        }
        let one = refined(linearisation, &projection, &candidate.at_period(joint, period)?);
        let more = projection.with(&linearisation.columns_of(&one).ok()?);
        if let (Change::Add(effects), Change::Add(more)) = (&mut grown.change, one.change) {
            effects.extend(more);
        }
        added += 1;
        let Some(more) = more else { break };
        projection = more;
    }
    (added > 0).then_some(grown)
}
