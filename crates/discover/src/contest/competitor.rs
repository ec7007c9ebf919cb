//! A candidate in a contest, and its score.
//!
//! ```text
//! score = −2 ln L + C + π,     π = 2 n_θ ln(tests of the family) + n_s ln m [+ 25 for an unnamed structure]
//! ```
//!
//! | symbol | here | |
//! | --- | --- | --- |
//! | C | [`coefficient_penalty`] | k ln m (Schwarz 1978); for curves and moving frames the marginal likelihood ([`crate::statistics::coefficients`]) where that is smaller |
//! | π | [`log_prior_odds`] | −2 × log prior odds: multiplicity, nonlinear parameters, prior against unnamed structures |
//! | n_θ | number of periods, at least one | each period is an answer of its own to all tests of the family |
//! | n_s | nonlinear parameters with a coarse grid, optimised continuously | each counts as a coefficient |
//! | m | number of observations | |

use crate::error::DiscoverError;
use crate::hypotheses::candidate::{Candidate, Change};
use crate::hypotheses::family::Family;
use crate::hypotheses::nonlinear::{climbed, found_periods, nonlinear_count};
use crate::hypotheses::penalty::by_evidence;
use crate::policy::{Policy, penalty_per_coefficient};
use crate::problem::likelihood::Likelihood;
use crate::problem::linearisation::Linearisation;
use crate::screen::candidates::Screen;
use crate::statistics::coefficients::CoefficientDistribution;
use crate::statistics::surprisal::Surprisal;
use nalgebra::DMatrix;
use truepose_errormodel::Visits;

/// A cause in its best shape.
pub(crate) struct Competitor {
    pub candidate: Candidate,
    /// Raw columns, m × k.
    pub columns: DMatrix<f64>,
    /// Degrees of freedom: directions that the present model does not absorb.
    pub freedom: usize,
    /// Score statistic of the screen with these nonlinear parameters, and its surprisal.
    pub gain: f64,
    pub surprisal: Surprisal,
    pub score: f64,
    /// π: the part of the score that is neither likelihood nor coefficient penalty.
    pub log_prior_odds: f64,
    /// The part of π that does not depend on the data: tests of the family, and the prior against unnamed
    /// structures.
    prior_penalty: f64,
    /// Of the distribution from which its coefficients look drawn, expected sizes.
    pub width: f64,
    /// Standard deviation of the prior on its coefficients once it is in the model, expected sizes.
    pub prior_width: f64,
    pub likelihood: Likelihood,
}

impl Competitor {
    /// Number of estimated parameters: degrees of freedom and nonlinear parameters.
    pub fn unknowns(&self) -> usize {
        self.freedom + nonlinear_count(&self.candidate)
    }

    /// By how much less likely it makes the data than another, whatever one would rather believe.
    fn deficit(&self, other: &Competitor) -> f64 {
        (self.score - self.prior_penalty) - (other.score - other.prior_penalty)
    }
}

/// A candidate with its likelihood and score; `None` when the present model absorbs it or the data lacks a
/// covariate.
pub(crate) fn competitor(
    linearisation: &Linearisation<'_>,
    screen: &Screen,
    visits: &Visits,
    candidate: Candidate,
) -> Result<Option<Competitor>, DiscoverError> {
    let Some(score) = screen.projection.judge(linearisation, &candidate) else { return Ok(None) };
    let columns = linearisation.columns_of(&candidate)?;
    let likelihood = Likelihood::new(linearisation, &columns, visits)?;
    let distribution = likelihood.coefficient_distribution(0..columns.ncols());
    let (log_prior_odds, prior_penalty) =
        (log_prior_odds(linearisation, screen, &candidate), prior_penalty(linearisation, screen, &candidate));
    let total =
        likelihood.deviance + cost(&candidate, &distribution, score.freedom, linearisation) + log_prior_odds;
    let (freedom, gain, surprisal) = (score.freedom, score.gain, score.surprisal);
    let width = distribution.width;
    let prior_width = linearisation.policy.prior_widths * width.max(1e-3);
    Ok(Some(Competitor {
        candidate,
        columns,
        freedom,
        gain,
        surprisal,
        score: total,
        log_prior_odds,
        prior_penalty,
        width,
        prior_width,
        likelihood,
    }))
}

/// The competing hypotheses of a winner, with their difference of score: smallest first. An unnamed structure
/// that fits the data like the winner, with as many degrees of freedom, is the winner itself and is left out;
/// except beside a curve over time (a drift or a jump) or over a load (nonlinear compliance or backlash),
/// where the family is the question.
pub(crate) fn outcompeted<'a>(
    competitors: impl IntoIterator<Item = &'a Competitor>,
    winner: &Competitor,
    policy: &Policy,
) -> Vec<(Candidate, f64)> {
    let a_curve = matches!(winner.candidate.family, Family::Drift | Family::LoadNonlinearity);
    let itself = |r: &Competitor| {
        let alike = (r.likelihood.deviance - winner.likelihood.deviance).abs() < policy.same_explanation;
        let unnamed = r.candidate.family == Family::Unmodelled && r.freedom == winner.freedom && alike;
        (unnamed && !a_curve) || r.candidate.same_cause(&winner.candidate)
    };
    let others = competitors.into_iter().filter(|r| !itself(r));
    let mut outcompeted: Vec<_> = others.map(|r| (r.candidate.clone(), r.deficit(winner))).collect();
    outcompeted.sort_by(|a, b| a.1.total_cmp(&b.1));
    outcompeted
}

/// C: penalty of a candidate's coefficients, in units of −2 ln L. `freedom` ln m; for curves over time or
/// travel, moving frames and unnamed functions of load the marginal likelihood, where that is smaller.
pub(crate) fn cost(
    candidate: &Candidate,
    distribution: &CoefficientDistribution,
    freedom: usize,
    linearisation: &Linearisation<'_>,
) -> f64 {
    let counted = penalty_per_coefficient(linearisation.len()) * freedom as f64;
    if by_evidence(candidate) { distribution.penalty.min(counted) } else { counted }
}

/// π: −2 × log prior odds of a candidate. A nonlinear parameter on a fine grid is penalised by the tests of
/// the grid; one that was optimised continuously from a coarse grid counts as a coefficient, ln m.
pub(crate) fn log_prior_odds(
    linearisation: &Linearisation<'_>,
    screen: &Screen,
    candidate: &Candidate,
) -> f64 {
    prior_penalty(linearisation, screen, candidate)
        + penalty_per_coefficient(linearisation.len()) * climbed(candidate) as f64
}

/// What a candidate pays before the data is looked at: every period of a gear is an answer of its own to the questions asked.
fn prior_penalty(linearisation: &Linearisation<'_>, screen: &Screen, candidate: &Candidate) -> f64 {
    let unnamed =
        if candidate.family == Family::Unmodelled { linearisation.policy.unnamed_penalty } else { 0.0 };
    2.0 * found_periods(candidate).max(1) as f64 * (screen.tests_of(candidate.family) as f64).ln() + unnamed
}

/// Whether size and sign are such as nature has.
pub(crate) fn plausible(competitor: &Competitor, policy: &Policy) -> bool {
    let first = (competitor.likelihood.coefficients[0], competitor.likelihood.deviation(0));
    is_physical(competitor.candidate.family, competitor.width, first, policy)
}

/// A link that five hundred newtons bend by a tenth of its length is none ([`Policy::wide`] times the expected size); and what yields, yields
/// with its load: `first` is the first coefficient with its standard deviation.
fn is_physical(family: Family, width: f64, first: (f64, f64), policy: &Policy) -> bool {
    let (value, deviation) = first;
    let paper = family == Family::LinkCompliance && width > policy.wide;
    let pushes_back = family.is_compliance() && value <= -policy.negative_compliance * deviation;
    !paper && !pushes_back
}

/// The candidate with the estimates of the contest: prior width, and mass of a corrected payload.
pub(crate) fn with_estimates(competitor: &Competitor) -> Candidate {
    let mut candidate = competitor.candidate.clone();
    candidate.width = Some(competitor.prior_width);
    if let Change::CorrectLoad { mass, .. } = &mut candidate.change {
        *mass = (*mass + competitor.likelihood.coefficients[0]).max(0.0);
    }
    candidate
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn links_are_no_paper_and_springs_do_not_push_back() {
        let policy = Policy::default();
        assert!(is_physical(Family::LinkCompliance, 20.0, (20.0, 1.0), &policy));
        assert!(!is_physical(Family::LinkCompliance, 600.0, (600.0, 5.0), &policy));
        // What a joint's expected size is worth depends on the robot.
        assert!(is_physical(Family::JointCompliance, 600.0, (600.0, 5.0), &policy));
        assert!(!is_physical(Family::JointCompliance, 3.0, (-3.0, 1.0), &policy));
        assert!(is_physical(Family::JointCompliance, 3.0, (-1.0, 1.0), &policy));
        assert!(is_physical(Family::Coupling, 3.0, (-3.0, 1.0), &policy));
    }
}
