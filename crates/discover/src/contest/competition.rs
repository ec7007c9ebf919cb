//! The second look: the best causes of the screen against each other, each in its best shape and with its own noise.
//!
//! The smallest score wins; among those that the data cannot tell from it, the simplest one.

use crate::contest::look_ahead;
use crate::contest::rival::{Rival, plausible, rival};
use crate::error::DiscoverError;
use crate::hypotheses::candidate::{Candidate, Change};
use crate::hypotheses::components::neighbours;
use crate::hypotheses::family::Family;
use crate::hypotheses::nonlinear::seen_as;
use crate::hypotheses::unmodelled::richer;
use crate::policy::{TIE, price};
use crate::problem::likelihood::Likelihood;
use crate::problem::linearisation::Scene;
use crate::problem::projection::Projection;
use crate::screen::candidates::{Cause, Screen};
use crate::screen::periodogram;
use crate::screen::refine::refined;
use nalgebra::DMatrix;
use rayon::prelude::*;
use truepose_errormodel::Visits;
use truepose_errormodel::effects::Transmission;

/// Who is behind by more than this will not win by other components.
const FAR: f64 = 120.0;
/// The same of curves in all components that have no name: each set of components has many coefficients to fit.
const NEAR: f64 = 30.0;
/// What a set of components has to be better by.
const WORTH: f64 = 1.0;
/// Causes that get a second look, and variants of each.
const CAUSES: usize = 10;
const VARIANTS: usize = 3;
/// Gears that may grow in one contest.
const GEARS: usize = 2;
/// Frequencies that one gear may have.
const MOST_PERIODS: usize = 12;

/// The rivals, the one that should be believed first, and the present model's own likelihood.
pub(crate) struct Contest {
    pub present: Likelihood,
    pub rivals: Vec<Rival>,
}

/// Holds the contest between the best causes of a screen, leaving out those that are barred. The most promising gears may grow further
/// periods, where a new cause is looked for or a gear defends its place.
pub(crate) fn contest(
    scene: &Scene<'_>,
    screen: &Screen,
    barred: &[Candidate],
    gears_grow: bool,
) -> Result<Contest, DiscoverError> {
    let visits = Visits::of(scene.data);
    let present = Likelihood::new(scene, &DMatrix::zeros(scene.len(), 0), &visits)?;
    let mut causes = screen.causes(scene);
    causes.retain(|cause| !barred.iter().any(|b| b.family == cause.family && b.place == cause.place));
    let mut found: Vec<Vec<Rival>> = invited(scene, &causes)
        .par_iter()
        .map(|cause| shaped(scene, screen, &visits, cause))
        .collect::<Result<_, _>>()?;
    if gears_grow {
        grow(scene, screen, &visits, &mut found)?;
    }
    let rivals: Vec<Rival> = found.into_iter().filter_map(simplest).collect();
    let best = least(&rivals);
    let mut rivals: Vec<Rival> = rivals
        .into_par_iter()
        .map(|r| if r.score < best + reach(&r) { fitted_out(scene, screen, &visits, r) } else { Ok(r) })
        .collect::<Result<_, _>>()?;
    rank(&mut rivals);
    let first = look_ahead::first(scene, screen, &visits, &rivals, &causes)?;
    rivals[..=first].rotate_right(usize::from(first > 0));
    Ok(Contest { present, rivals })
}

/// The best causes, and the best of every named family: each gets its chance.
fn invited<'a>(scene: &Scene<'_>, causes: &'a [Cause]) -> Vec<&'a Cause> {
    let price = price(scene.len());
    let mut invited: Vec<&Cause> = causes.iter().take(CAUSES).collect();
    for cause in causes.iter().skip(CAUSES) {
        let (_, gain, freedom) = &cause.variants[0];
        let known = invited.iter().any(|other| other.family == cause.family);
        if cause.family != Family::Unmodelled && !known && gain - price * *freedom as f64 > 0.0 {
            invited.push(cause);
        }
    }
    invited
}

/// A cause in its shapes, one of each richness.
fn shaped(
    scene: &Scene<'_>,
    screen: &Screen,
    visits: &Visits,
    cause: &Cause,
) -> Result<Vec<Rival>, DiscoverError> {
    let mut rivals = Vec::new();
    let mut freedoms = Vec::new();
    for (candidate, _, freedom) in &cause.variants {
        if freedoms.contains(freedom) || freedoms.len() >= VARIANTS {
            continue;
        }
        freedoms.push(*freedom);
        let shaped = refined(scene, &screen.projection, candidate);
        rivals.extend(rival(scene, screen, visits, shaped)?);
    }
    if let Some(more) = cause.variants.first().and_then(|(candidate, ..)| richer(candidate)) {
        rivals.extend(rival(scene, screen, visits, more)?);
    }
    Ok(rivals)
}

/// Gears with several periods: the most promising ones get the chance to grow.
fn grow(
    scene: &Scene<'_>,
    screen: &Screen,
    visits: &Visits,
    found: &mut [Vec<Rival>],
) -> Result<(), DiscoverError> {
    let mut gears: Vec<usize> = (0..found.len())
        .filter(|&k| found[k].first().is_some_and(|r| r.candidate.family == Family::Transmission))
        .collect();
    gears.sort_by(|&a, &b| least(&found[a]).total_cmp(&least(&found[b])));
    gears.truncate(GEARS);
    let grown: Vec<Option<Rival>> = gears
        .par_iter()
        .map(|&k| {
            let best = found[k].iter().min_by(|a, b| a.score.total_cmp(&b.score));
            match best.and_then(|best| more_periods(scene, &screen.projection, &best.candidate)) {
                Some(candidate) => rival(scene, screen, visits, candidate),
                None => Ok(None),
            }
        })
        .collect::<Result<_, _>>()?;
    gears.iter().zip(grown).for_each(|(&k, grown)| found[k].extend(grown));
    Ok(())
}

/// The simplest of a cause's shapes that cannot be told from the best one.
fn simplest(mut shapes: Vec<Rival>) -> Option<Rival> {
    shapes.retain(|r| plausible(r) && r.score.is_finite());
    let best = least(&shapes);
    let tied = shapes.into_iter().filter(|r| r.score < best + 0.5 * TIE);
    tied.min_by(|a, b| a.freedom.cmp(&b.freedom).then(a.score.total_cmp(&b.score)))
}

/// Best first; of those that cannot be told from the best one, the simplest.
fn rank(rivals: &mut [Rival]) {
    rivals.sort_by(|a, b| a.score.total_cmp(&b.score));
    let best = least(rivals);
    let tied = rivals.iter().take_while(|r| r.score < best + TIE).count();
    rivals[..tied].sort_by(|a, b| {
        let family = a.candidate.family.rank().cmp(&b.candidate.family.rank());
        family.then(a.unknowns().cmp(&b.unknowns())).then(a.score.total_cmp(&b.score))
    });
}

/// How far behind the best a rival may be to try other components.
fn reach(rival: &Rival) -> f64 {
    if rival.candidate.family == Family::Unmodelled { NEAR } else { FAR }
}

fn least(rivals: &[Rival]) -> f64 {
    rivals.iter().map(|r| r.score).fold(f64::INFINITY, f64::min)
}

/// The rival with the components that pay for themselves.
fn fitted_out(
    scene: &Scene<'_>,
    screen: &Screen,
    visits: &Visits,
    mut now: Rival,
) -> Result<Rival, DiscoverError> {
    loop {
        let mut best: Option<Rival> = None;
        for candidate in neighbours(&now.candidate) {
            let Some(other) = rival(scene, screen, visits, candidate)? else { continue };
            if other.score < best.as_ref().map_or(now.score - WORTH, |best| best.score) {
                best = Some(other);
            }
        }
        match best {
            Some(better) => now = better,
            None => return Ok(now),
        }
    }
}

/// The same gear with further periods, as long as each pays for itself.
fn more_periods(scene: &Scene<'_>, present: &Projection, candidate: &Candidate) -> Option<Candidate> {
    if candidate.family != Family::Transmission {
        return None;
    }
    let joint = seen_as::<Transmission>(&**candidate.effects().first()?)?.joint;
    let grid = periodogram::grid(scene, joint);
    let questions = (grid.len().max(2) as f64).ln();
    let threshold = 2.0 * questions + 2.0 * price(scene.len()) + TIE;
    let mut grown = candidate.clone();
    let mut projection = present.with(&scene.columns_of(&grown).ok()?)?;
    let mut added = 0;
    while added < MOST_PERIODS {
        let wave = periodogram::scan(scene, &projection, joint, &grid)?;
        let (period, gain, surprise) = wave.strongest()?;
        // What visits alone, of which some are off for other reasons, would show somewhere on the grid by chance is no period.
        if gain < threshold || surprise < questions {
            break;
        }
        let one = refined(
            scene,
            &projection,
            &crate::hypotheses::motion::transmission_at(scene.chain(), joint, &[period]),
        );
        let more = projection.with(&scene.columns_of(&one).ok()?);
        if let (Change::Add(effects), Change::Add(more)) = (&mut grown.change, one.change) {
            effects.extend(more);
        }
        added += 1;
        let Some(more) = more else { break };
        projection = more;
    }
    (added > 0).then_some(grown)
}
