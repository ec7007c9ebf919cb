//! A cause in a contest, and what it scores.
//!
//! ```text
//! score = −2 ln L + C + 2 ln(questions asked of the family) + shapes · ln m [+ what a structure without a name costs]
//! ```
//!
//! C is what its coefficients cost: ln m each (Schwarz 1978), or, of curves and moving frames, what the evidence says ([`crate::law`]).

use crate::candidate::Candidate;
use crate::law::Law;
use crate::likelihood::Likelihood;
use crate::scene::Scene;
use crate::screen::{Screen, price};
use crate::shape::{climbed, seen_as, shapes};
use crate::{DiscoverError, Family};
use nalgebra::DMatrix;
use truepose_errormodel::Visits;
use truepose_errormodel::effects::{Expansion, Place};

/// What a structure without a name has to be better by than any named cause.
const NAMELESS: f64 = 25.0;

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
    pub fn unknowns(&self) -> usize {
        self.freedom + shapes(&self.candidate)
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
    if by_evidence(candidate) { law.cost.min(counted) } else { counted }
}

/// Whether the coefficients of a candidate are those of a curve over time or travel, or of a frame that moves.
pub(crate) fn by_evidence(candidate: &Candidate) -> bool {
    match candidate.family {
        Family::Guideway | Family::Drift | Family::Shift | Family::Thermal => true,
        Family::Unmodelled => wanders(candidate),
        _ => false,
    }
}

/// Whether several components of a frame move along curves.
fn wanders(candidate: &Candidate) -> bool {
    let [effect] = candidate.effects() else { return false };
    seen_as::<Expansion>(&**effect)
        .is_some_and(|series| matches!(&series.at, Place::Frame { components, .. } if components.len() > 1))
}

/// What a candidate pays for the questions that are asked of its family, for its shapes, and for having no name. A shape on a fine grid
/// pays by the questions that the grid asks, one that was climbed for as an unknown.
pub(crate) fn odds(scene: &Scene<'_>, screen: &Screen, candidate: &Candidate) -> f64 {
    let nameless = if candidate.family == Family::Unmodelled { NAMELESS } else { 0.0 };
    let asked = 2.0 * (screen.asked(candidate.family) as f64).ln();
    asked + price(scene.len()) * climbed(candidate) as f64 + nameless
}

/// Whether the sign is one that nature has: what yields, yields with its load.
pub(crate) fn plausible(rival: &Rival) -> bool {
    if !rival.candidate.family.is_compliance() {
        return true;
    }
    let (value, deviation) = (rival.likelihood.coefficients[0], rival.likelihood.deviation(0));
    value > -2.0 * deviation
}
