//! What a candidate pays in a contest beside its deviance.
//!
//! ```text
//! score = −2 ln L + C + π
//! ```

use crate::hypotheses::candidate::Candidate;
use crate::policy::penalty_per_coefficient;
use crate::problem::linearisation::Linearisation;
use crate::screen::candidates::Screen;
use crate::statistics::coefficients::CoefficientDistribution;

/// C: penalty of a candidate's coefficients, in units of −2 ln L. `freedom` ln m; for curves over time or
/// travel, moving frames and unnamed functions of load the marginal likelihood, where that is smaller.
pub(crate) fn cost(
    candidate: &Candidate,
    distribution: &CoefficientDistribution,
    freedom: usize,
    linearisation: &Linearisation<'_>,
) -> f64 {
    let counted = penalty_per_coefficient(linearisation.len()) * freedom as f64;
    if candidate.by_evidence() { distribution.penalty.min(counted) } else { counted }
}

/// π: −2 × log prior odds of a candidate. A nonlinear parameter on a fine grid is penalised by the tests of
/// the grid; one that was optimised continuously from a coarse grid counts as a coefficient, ln m.
pub(crate) fn log_prior_odds(
    linearisation: &Linearisation<'_>,
    screen: &Screen,
    candidate: &Candidate,
) -> f64 {
    let order =
        if candidate.is_of_order(linearisation.data) { linearisation.policy.order_penalty } else { 0.0 };
    prior_penalty(linearisation, screen, candidate)
        + order
        + penalty_per_coefficient(linearisation.len()) * candidate.scales() as f64
}

/// The part of π that does not depend on the data: 2 ln(tests of the family) for each period, and the prior
/// against unnamed structures.
pub(crate) fn prior_penalty(
    linearisation: &Linearisation<'_>,
    screen: &Screen,
    candidate: &Candidate,
) -> f64 {
    let unnamed = if candidate.family.is_named() { 0.0 } else { linearisation.policy.unnamed_penalty };
    2.0 * candidate.periods().max(1) as f64 * (screen.tests_of(candidate.family) as f64).ln() + unnamed
}
