//! A candidate in a contest, and its score.
//!
//! ```text
//! score = −2 ln L + C + π,     π = 2 n_θ ln(tests of the family) + n_s ln m [+ 25 for an unnamed structure] [+ 12 for the order of poses]
//! ```
//!
//! | symbol | here | |
//! | --- | --- | --- |
//! | C | [`cost`] | k ln m (Schwarz 1978); for curves and moving frames the marginal likelihood ([`crate::statistics::coefficients`]) where that is smaller |
//! | π | [`log_prior_odds`] | −2 × log prior odds: multiplicity, nonlinear parameters, prior against unnamed structures |
//! | n_θ | number of periods, at least one | each period is an answer of its own to all tests of the family |
//! | n_s | nonlinear parameters with a coarse grid, optimised continuously | each counts as a coefficient |
//! | m | number of observations | |

use crate::contest::names::name_prior;
use crate::contest::pair::Partner;
use crate::contest::penalty::{cost, log_prior_odds, prior_penalty};
use crate::error::DiscoverError;
use crate::hypotheses::candidate::Candidate;
use crate::hypotheses::change::Change;
use crate::hypotheses::limits::Limit;
use crate::policy::Policy;
use crate::problem::likelihood::Likelihood;
use crate::problem::linearisation::Linearisation;
use crate::screen::candidates::Screen;
use nalgebra::DMatrix;
use truepose_errormodel::Visits;

/// A candidate with optimised nonlinear parameters, and its likelihood.
#[derive(Clone)]
pub(crate) struct Competitor {
    pub candidate: Candidate,
    /// Raw columns, m × k.
    pub columns: DMatrix<f64>,
    /// Degrees of freedom: directions that the present model does not absorb.
    pub freedom: usize,
    /// Score statistic of the screen with these nonlinear parameters, and its surprisal.
    pub gain: f64,
    pub surprisal: f64,
    pub score: f64,
    /// The part of π that does not depend on the data: tests of the family, and the prior against unnamed
    /// structures.
    prior_penalty: f64,
    /// Of the distribution from which its coefficients look drawn, expected sizes.
    pub width: f64,
    /// Standard deviation of the prior on its coefficients once it is in the model, expected sizes.
    pub prior_width: f64,
    pub likelihood: Likelihood,
    /// Its best partner in the look-ahead.
    pub partner: Option<Partner>,
}

impl Competitor {
    /// Number of estimated parameters: degrees of freedom and nonlinear parameters.
    pub fn unknowns(&self) -> usize {
        self.freedom + self.candidate.nonlinear().count() + self.candidate.ends()
    }

    /// −2 ln of the probability of its name, but for what all competitors share: the score from the data alone, and the prior against causes
    /// that the library has no name for.
    pub fn name_score(&self, policy: &Policy) -> f64 {
        self.data_score() + name_prior(self.candidate.family, policy)
    }

    /// Score without the part that does not depend on the data.
    pub fn data_alone(&self) -> f64 {
        self.score - self.prior_penalty
    }

    /// The same, alone or beside its partner: two causes may explain what another one imitates.
    fn data_score(&self) -> f64 {
        let beside = self.partner.as_ref().filter(|partner| !partner.leads);
        self.data_alone().min(beside.map_or(f64::INFINITY, |partner| partner.score.data))
    }

    /// Difference of score from another competitor without the part that does not depend on the data;
    /// positive: less likely.
    fn deficit(&self, other: &Competitor) -> f64 {
        self.data_score() - other.data_score()
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
    let prior_penalty = prior_penalty(linearisation, screen, &candidate);
    let total = likelihood.deviance
        + cost(&candidate, &distribution, score.freedom, linearisation)
        + log_prior_odds(linearisation, screen, &candidate);
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
        prior_penalty,
        width,
        prior_width,
        likelihood,
        partner: None,
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
    let a_curve = winner.candidate.hypothesis().is_curve();
    let itself = |r: &Competitor| {
        let alike = (r.likelihood.deviance - winner.likelihood.deviance).abs() < policy.same_explanation;
        let unnamed = !r.candidate.family.is_named() && r.freedom == winner.freedom && alike;
        (unnamed && !a_curve) || r.candidate.same_cause(&winner.candidate)
    };
    let others = competitors.into_iter().filter(|r| !itself(r));
    let mut outcompeted: Vec<_> = others.map(|r| (with_estimates(r), r.deficit(winner))).collect();
    outcompeted.sort_by(|a, b| a.1.total_cmp(&b.1));
    outcompeted
}

/// Whether size and sign of the coefficients are physical.
pub(crate) fn plausible(competitor: &Competitor, policy: &Policy) -> bool {
    let first = (competitor.likelihood.coefficients[0], competitor.likelihood.deviation(0));
    is_physical(|limit| competitor.candidate.has_limit(limit), competitor.width, first, policy)
}

/// A link compliance is at most [`Policy::wide`] expected sizes (500 N would bend the link by a tenth of its length).
/// A compliance is positive: its first coefficient, `first` = (value, standard deviation), is above −2
/// standard deviations.
fn is_physical(has: impl Fn(Limit) -> bool, width: f64, first: (f64, f64), policy: &Policy) -> bool {
    let (value, deviation) = first;
    let paper = has(Limit::BoundedWidth) && width > policy.wide;
    let pushes_back = has(Limit::FirstNotNegative) && value <= -policy.negative_compliance * deviation;
    !paper && !pushes_back
}

/// The candidate with the estimates of the contest: prior width, and mass of a corrected payload.
pub(crate) fn with_estimates(competitor: &Competitor) -> Candidate {
    let mut candidate = with_mass(competitor);
    candidate.width = Some(competitor.prior_width);
    candidate
}

/// The candidate with the mass of a corrected payload, kg.
fn with_mass(competitor: &Competitor) -> Candidate {
    let mut candidate = competitor.candidate.clone();
    if let Change::CorrectLoad { mass, .. } = &mut candidate.change {
        *mass = (*mass + competitor.likelihood.coefficients[0]).max(0.0);
    }
    candidate
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::hypotheses::compliance::{OfJoints, OfLinks};
    use crate::hypotheses::coupling::Drag;
    use crate::hypotheses::hypothesis::Hypothesis;

    #[test]
    fn a_link_compliance_is_bounded_and_a_compliance_is_not_negative() {
        let is_physical = |hypothesis: &dyn Hypothesis, width, first| {
            is_physical(|limit| hypothesis.limits().contains(&limit), width, first, &Policy::default())
        };
        assert!(is_physical(&OfLinks, 20.0, (20.0, 1.0)));
        assert!(!is_physical(&OfLinks, 600.0, (600.0, 5.0)));
        // The expected size of a joint compliance depends on the robot: no upper bound.
        assert!(is_physical(&OfJoints, 600.0, (600.0, 5.0)));
        assert!(!is_physical(&OfJoints, 3.0, (-3.0, 1.0)));
        assert!(is_physical(&OfJoints, 3.0, (-1.0, 1.0)));
        assert!(is_physical(&Drag, 3.0, (-3.0, 1.0)));
    }
}
