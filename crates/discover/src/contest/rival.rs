//! A cause in a contest, and what it scores.
//!
//! ```text
//! score = −2 ln L + C + 2 ln(questions asked of the family) + shapes · ln m [+ what a structure without a name costs]
//! ```
//!
//! C is what its coefficients cost: ln m each (Schwarz 1978), or, of curves and moving frames, what the evidence says ([`crate::statistics::coefficients`]).

use crate::error::DiscoverError;
use crate::hypotheses::candidate::{Candidate, Change};
use crate::hypotheses::family::Family;
use crate::hypotheses::nonlinear::{climbed, found_periods, shapes};
use crate::hypotheses::penalty::by_evidence;
use crate::policy::{WIDE, price};
use crate::problem::likelihood::Likelihood;
use crate::problem::linearisation::Scene;
use crate::screen::candidates::Screen;
use crate::statistics::coefficients::Law;
use crate::statistics::surprisal::Surprise;
use nalgebra::DMatrix;
use truepose_errormodel::Visits;

/// What a structure without a name has to be better by than any named cause.
const NAMELESS: f64 = 25.0;

/// A cause in its best shape.
pub(crate) struct Rival {
    pub candidate: Candidate,
    /// Raw columns, m × k.
    pub columns: DMatrix<f64>,
    /// Directions that the data can judge.
    pub freedom: usize,
    /// The screen's gain of this shape, and how surprising it is.
    pub gain: f64,
    pub surprise: Surprise,
    pub score: f64,
    /// What of the score is neither likelihood nor coefficients.
    pub odds: f64,
    /// What of the odds the data has no part in: for the questions that were asked of its family, and for having no name.
    preference: f64,
    /// Of the law from which its coefficients look drawn, expected sizes.
    pub width: f64,
    pub likelihood: Likelihood,
}

impl Rival {
    /// What had to be found out: coefficients that the data judges, and shapes.
    pub fn unknowns(&self) -> usize {
        self.freedom + shapes(&self.candidate)
    }

    /// Standard deviation of the prior on its coefficients once it is in the model, expected sizes: twice that of the law from which they look
    /// drawn.
    pub fn within(&self) -> f64 {
        2.0 * self.width.max(1e-3)
    }

    /// By how much less likely it makes the data than another, whatever one would rather believe.
    fn behind(&self, other: &Rival) -> f64 {
        (self.score - self.preference) - (other.score - other.preference)
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
    let columns = scene.columns_of(&candidate)?;
    let likelihood = Likelihood::new(scene, &columns, visits)?;
    let law = likelihood.law(0..columns.ncols());
    let (odds, preference) = (odds(scene, screen, &candidate), preference(screen, &candidate));
    let total = likelihood.deviance + cost(&candidate, &law, score.freedom, scene) + odds;
    let (freedom, gain, surprise) = (score.freedom, score.gain, score.surprise);
    let width = law.width;
    Ok(Some(Rival {
        candidate,
        columns,
        freedom,
        gain,
        surprise,
        score: total,
        odds,
        preference,
        width,
        likelihood,
    }))
}

/// Who lost against a rival, with how much less likely each makes the data: the most likely first. The winner itself under no name is none,
/// but where its name says no more than what it follows: a curve over time may be a slow drift or a jump, one over a load a spring that
/// hardens or play.
pub(crate) fn losers<'a>(
    rivals: impl IntoIterator<Item = &'a Rival>,
    winner: &Rival,
) -> Vec<(Candidate, f64)> {
    /// Of −2 ln L, within which two explanations of as many unknowns are the same one: their wide priors differ by as much.
    const SAME: f64 = 0.05;
    let a_curve = matches!(winner.candidate.family, Family::Drift | Family::LoadNonlinearity);
    let itself = |r: &Rival| {
        let alike = (r.likelihood.deviance - winner.likelihood.deviance).abs() < SAME;
        let nameless = r.candidate.family == Family::Unmodelled && r.freedom == winner.freedom && alike;
        (nameless && !a_curve) || r.candidate.same_cause(&winner.candidate)
    };
    let others = rivals.into_iter().filter(|r| !itself(r));
    let mut losers: Vec<_> = others.map(|r| (r.candidate.clone(), r.behind(winner))).collect();
    losers.sort_by(|a, b| a.1.total_cmp(&b.1));
    losers
}

/// What the coefficients of a candidate cost, so many of which the data judges: those of a curve over time or travel, of a frame that moves,
/// or of something without a name that follows the load, as the evidence says; all others their number.
pub(crate) fn cost(candidate: &Candidate, law: &Law, freedom: usize, scene: &Scene<'_>) -> f64 {
    let counted = price(scene.len()) * freedom as f64;
    if by_evidence(candidate) { law.cost.min(counted) } else { counted }
}

/// What a candidate pays for the questions that are asked of its family, for its shapes, and for having no name. A shape on a fine grid
/// pays by the questions that the grid asks, one that was climbed for as an unknown.
pub(crate) fn odds(scene: &Scene<'_>, screen: &Screen, candidate: &Candidate) -> f64 {
    preference(screen, candidate) + price(scene.len()) * climbed(candidate) as f64
}

/// What a candidate pays before the data is looked at: every period of a gear is an answer of its own to the questions asked.
fn preference(screen: &Screen, candidate: &Candidate) -> f64 {
    let nameless = if candidate.family == Family::Unmodelled { NAMELESS } else { 0.0 };
    2.0 * found_periods(candidate).max(1) as f64 * (screen.asked(candidate.family) as f64).ln() + nameless
}

/// Whether size and sign are such as nature has.
pub(crate) fn plausible(rival: &Rival) -> bool {
    let first = (rival.likelihood.coefficients[0], rival.likelihood.deviation(0));
    natural(rival.candidate.family, rival.width, first)
}

/// A link that five hundred newtons bend by a tenth of its length is none ([`WIDE`] times the expected size); and what yields, yields
/// with its load: `first` is the first coefficient with its standard deviation.
fn natural(family: Family, width: f64, first: (f64, f64)) -> bool {
    let (value, deviation) = first;
    let paper = family == Family::LinkCompliance && width > WIDE;
    let pushes_back = family.is_compliance() && value <= -2.0 * deviation;
    !paper && !pushes_back
}

/// The candidate with what the contest found out about its change.
pub(crate) fn adopted(rival: &Rival) -> Candidate {
    let mut candidate = rival.candidate.clone();
    candidate.width = Some(rival.within());
    if let Change::CorrectLoad { mass, .. } = &mut candidate.change {
        *mass = (*mass + rival.likelihood.coefficients[0]).max(0.0);
    }
    candidate
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn links_are_no_paper_and_springs_do_not_push_back() {
        assert!(natural(Family::LinkCompliance, 20.0, (20.0, 1.0)));
        assert!(!natural(Family::LinkCompliance, 600.0, (600.0, 5.0)));
        // What a joint's expected size is worth depends on the robot.
        assert!(natural(Family::JointCompliance, 600.0, (600.0, 5.0)));
        assert!(!natural(Family::JointCompliance, 3.0, (-3.0, 1.0)));
        assert!(natural(Family::JointCompliance, 3.0, (-1.0, 1.0)));
        assert!(natural(Family::Coupling, 3.0, (-3.0, 1.0)));
    }
}
