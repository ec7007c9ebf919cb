//! The second look: the best causes of the screen against each other, each in its best shape and with its own noise.
//!
//! ```text
//! score = −2 ln L + C + 2 ln(questions asked of the family) + shapes · ln m [+ what a structure without a name costs]
//! ```
//!
//! C is what its coefficients cost: ln m each (Schwarz 1978), or, of curves and moving frames, what the evidence says ([`crate::law`]).
//!
//! The smallest score wins; among those that the data cannot tell from it, the simplest one.

use crate::candidate::{Candidate, Change};
use crate::law::Law;
use crate::library::{neighbours, richer};
use crate::likelihood::Likelihood;
use crate::periodogram;
use crate::projection::Projection;
use crate::scene::Scene;
use crate::screen::{Cause, Screen, price};
use crate::shape::{climbed, refined, seen_as, shapes};
use crate::{DiscoverError, Family, look_ahead};
use nalgebra::DMatrix;
use rayon::prelude::*;
use truepose_errormodel::Visits;
use truepose_errormodel::effects::Transmission;

/// Scores that differ by less cannot be told apart.
pub(crate) const TIE: f64 = 6.0;
/// What a structure without a name has to be better by than any named cause.
const NAMELESS: f64 = 25.0;
/// Who is behind by more than this will not win by other components, and what a set of components has to be better by.
const FAR: f64 = 120.0;
const WORTH: f64 = 1.0;
/// Causes that get a second look, and variants of each.
const CAUSES: usize = 10;
const VARIANTS: usize = 3;
/// Gears that may grow in one contest.
const GEARS: usize = 2;
/// Frequencies that one gear may have.
const MOST_PERIODS: usize = 12;

/// A cause in its best shape.
pub(crate) struct Rival {
    pub candidate: Candidate,
    /// Raw columns, m × k.
    pub columns: DMatrix<f64>,
    /// Directions that the data can judge.
    pub freedom: usize,
    /// The screen's gain of this shape.
    pub gain: f64,
    pub score: f64,
    /// What of the score is neither likelihood nor coefficients.
    pub odds: f64,
    /// Of the law from which its coefficients look drawn, expected sizes.
    pub width: f64,
    pub likelihood: Likelihood,
}

impl Rival {
    /// What had to be found out: coefficients that the data judges, and shapes.
    fn unknowns(&self) -> usize {
        self.freedom + shapes(&self.candidate)
    }
}

/// The rivals, the one that should be believed first, and the present model's own likelihood.
pub(crate) struct Contest {
    pub present: Likelihood,
    pub rivals: Vec<Rival>,
}

/// Holds the contest between the best causes of a screen, leaving out those that are barred. The most promising gears may grow further
/// periods, where a new cause is looked for.
pub(crate) fn contest(
    scene: &Scene<'_>,
    screen: &Screen,
    barred: &[Candidate],
    gears_grow: bool,
) -> Result<Contest, DiscoverError> {
    let visits = Visits::of(scene.data);
    let present = Likelihood::new(scene, &DMatrix::zeros(scene.len(), 0), &visits)?;
    let price = price(scene.len());
    let causes: Vec<Cause> = screen
        .causes(scene)
        .into_iter()
        .filter(|cause| !barred.iter().any(|b| b.family == cause.family && b.place == cause.place))
        .collect();
    let mut taken: Vec<usize> = (0..causes.len().min(CAUSES)).collect();
    // The best of every named family gets its chance.
    for (k, cause) in causes.iter().enumerate().skip(CAUSES) {
        let (_, gain, freedom) = &cause.variants[0];
        let known = taken.iter().any(|&t| causes[t].family == cause.family);
        if cause.family != Family::Unmodelled && !known && gain - price * *freedom as f64 > 0.0 {
            taken.push(k);
        }
    }
    let found: Vec<Result<Vec<Rival>, DiscoverError>> = taken
        .par_iter()
        .map(|&k| {
            let mut rivals = Vec::new();
            let mut freedoms = Vec::new();
            for (candidate, _, freedom) in &causes[k].variants {
                // One shape of each richness.
                if freedoms.contains(freedom) || freedoms.len() >= VARIANTS {
                    continue;
                }
                freedoms.push(*freedom);
                let shaped = refined(scene, &screen.projection, candidate);
                rivals.extend(rival(scene, screen, &visits, shaped)?);
            }
            if let Some(more) = causes[k].variants.first().and_then(|(candidate, ..)| richer(candidate)) {
                rivals.extend(rival(scene, screen, &visits, more)?);
            }
            Ok(rivals)
        })
        .collect();
    let mut found: Vec<Vec<Rival>> = found.into_iter().collect::<Result<_, _>>()?;
    // Gears with several periods: the most promising ones get the chance to grow.
    let least = |part: &[Rival]| part.iter().map(|r| r.score).fold(f64::INFINITY, f64::min);
    let mut gears: Vec<usize> = (0..found.len())
        .filter(|&k| found[k].first().is_some_and(|r| r.candidate.family == Family::Transmission))
        .collect();
    gears.sort_by(|&a, &b| least(&found[a]).total_cmp(&least(&found[b])));
    gears.truncate(if gears_grow { GEARS } else { 0 });
    let grown: Vec<Option<Rival>> = gears
        .par_iter()
        .map(|&k| {
            let best = found[k].iter().min_by(|a, b| a.score.total_cmp(&b.score));
            match best.and_then(|best| more_periods(scene, &screen.projection, &best.candidate)) {
                Some(candidate) => rival(scene, screen, &visits, candidate),
                None => Ok(None),
            }
        })
        .collect::<Result<_, _>>()?;
    gears.iter().zip(grown).for_each(|(&k, grown)| found[k].extend(grown));
    let mut rivals: Vec<Rival> = Vec::new();
    for mut part in found {
        // The best shape of each cause.
        part.retain(|r| plausible(r) && r.score.is_finite());
        part.sort_by(|a, b| a.score.total_cmp(&b.score));
        let best = part.first().map(|r| r.score);
        // The simplest of the shapes that cannot be told apart.
        part.retain(|r| best.is_some_and(|best| r.score < best + 0.5 * TIE));
        part.sort_by(|a, b| a.freedom.cmp(&b.freedom).then(a.score.total_cmp(&b.score)));
        rivals.extend(part.into_iter().next());
    }
    let best = least(&rivals);
    let mut rivals: Vec<Rival> = rivals
        .into_par_iter()
        .map(|r| if r.score < best + FAR { fitted_out(scene, screen, &visits, r) } else { Ok(r) })
        .collect::<Result<_, _>>()?;
    rivals.sort_by(|a, b| a.score.total_cmp(&b.score));
    if let Some(best) = rivals.first().map(|r| r.score) {
        let tied = rivals.iter().take_while(|r| r.score < best + TIE).count();
        rivals[..tied].sort_by(|a, b| {
            let key = |r: &Rival| r.candidate.family.rank();
            let simple = a.unknowns().cmp(&b.unknowns());
            key(a).cmp(&key(b)).then(simple).then(a.score.total_cmp(&b.score))
        });
    }
    let first = look_ahead::first(scene, screen, &visits, &rivals, &causes)?;
    rivals[..=first].rotate_right(usize::from(first > 0));
    Ok(Contest { present, rivals })
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

/// A candidate with its likelihood; none when the data cannot judge it.
pub(crate) fn rival(
    scene: &Scene<'_>,
    screen: &Screen,
    visits: &Visits,
    candidate: Candidate,
) -> Result<Option<Rival>, DiscoverError> {
    let Some(score) = screen.projection.judge(scene, &candidate) else { return Ok(None) };
    let columns = candidate.columns(scene)?;
    let likelihood = Likelihood::new(scene, &columns, visits)?;
    let law = likelihood.law(0..columns.ncols());
    let odds = odds(scene, screen, &candidate);
    let total = likelihood.deviance + cost(&candidate, &law, score.freedom, scene) + odds;
    let (freedom, gain) = (score.freedom, score.gain);
    Ok(Some(Rival { candidate, columns, freedom, gain, score: total, odds, width: law.width, likelihood }))
}

/// What the coefficients of a candidate cost, so many of which the data judges: those of a curve over time or travel, or of a
/// frame that moves, as the evidence says; all others their number.
pub(crate) fn cost(candidate: &Candidate, law: &Law, freedom: usize, scene: &Scene<'_>) -> f64 {
    let counted = price(scene.len()) * freedom as f64;
    match candidate.family {
        Family::Guideway | Family::Drift | Family::Shift | Family::Thermal => law.cost.min(counted),
        _ => counted,
    }
}

/// What a candidate pays for the questions that are asked of its family, for its shapes, and for having no name. A shape on a fine grid
/// pays by the questions that the grid asks, one that was climbed for as an unknown.
pub(crate) fn odds(scene: &Scene<'_>, screen: &Screen, candidate: &Candidate) -> f64 {
    let nameless = if candidate.family == Family::Unmodelled { NAMELESS } else { 0.0 };
    let asked = 2.0 * (screen.asked(candidate.family) as f64).ln();
    asked + price(scene.len()) * climbed(candidate) as f64 + nameless
}

/// Whether the sign is one that nature has: what yields, yields with its load.
fn plausible(rival: &Rival) -> bool {
    if !rival.candidate.family.is_compliance() {
        return true;
    }
    let (value, deviation) = (rival.likelihood.coefficients[0], rival.likelihood.deviation(0));
    value > -2.0 * deviation
}

/// The same gear with further periods, as long as each pays for itself.
fn more_periods(scene: &Scene<'_>, present: &Projection, candidate: &Candidate) -> Option<Candidate> {
    if candidate.family != Family::Transmission {
        return None;
    }
    let joint = seen_as::<Transmission>(&**candidate.effects().first()?)?.joint;
    let grid = periodogram::grid(scene, joint);
    let threshold = 2.0 * (grid.len().max(2) as f64).ln() + 2.0 * price(scene.len()) + TIE;
    let mut grown = candidate.clone();
    let mut projection = present.with(&grown.columns(scene).ok()?)?;
    let mut added = 0;
    while added < MOST_PERIODS {
        let wave = periodogram::scan(scene, &projection, joint, &grid)?;
        let &(period, gain) = wave.peaks(1).first()?;
        if gain < threshold {
            break;
        }
        let one =
            refined(scene, &projection, &crate::library::transmission_at(scene.chain(), joint, &[period]));
        let more = projection.with(&one.columns(scene).ok()?);
        if let (Change::Add(effects), Change::Add(more)) = (&mut grown.change, one.change) {
            effects.extend(more);
        }
        added += 1;
        let Some(more) = more else { break };
        projection = more;
    }
    (added > 0).then_some(grown)
}
