//! The score of two candidates together.
//!
//! ```text
//! score(a + b) = −2 ln L(a + b) + C_a + C_b + π_a + π_b
//! ```
//!
//! C and π: [`crate::contest::penalty`]. The drives of an arm yield together: where a is one of them, another one is no cause of its own, and
//! what does not depend on the data is left out of its π. Without that of π_a, too, the pair counts for the name of a.

use crate::contest::penalty::{cost, log_prior_odds, prior_penalty};
use crate::error::DiscoverError;
use crate::hypotheses::candidate::Candidate;
use crate::hypotheses::family::Family;
use crate::problem::likelihood::Likelihood;
use crate::problem::linearisation::Linearisation;
use crate::screen::candidates::Screen;
use nalgebra::DMatrix;
use std::ops::Range;
use truepose_errormodel::Visits;

/// A candidate of a pair: raw columns (m × k), and degrees of freedom that the present model does not absorb.
pub(crate) struct Side<'a> {
    pub candidate: &'a Candidate,
    pub columns: &'a DMatrix<f64>,
    pub freedom: usize,
}

/// score(a + b), and what of it counts for the name of a.
#[derive(Debug, Clone, Copy)]
pub(crate) struct PairScore {
    /// As two causes.
    pub total: f64,
    /// For the name of a: without the part of π that does not depend on the data, of both where both are drives, which count as one cause.
    pub data: f64,
}

/// A competitor's best partner.
#[derive(Debug, Clone)]
pub(crate) struct Partner {
    pub candidate: Candidate,
    pub score: PairScore,
    /// Whether the partner explains more of the present residual than the competitor does: then the pair says nothing of the competitor.
    pub leads: bool,
}

/// Whether both are drives of one arm that yield in proportion to their load.
pub(crate) fn yield_together(a: &Candidate, b: &Candidate) -> bool {
    [a, b].iter().all(|c| c.family == Family::JointCompliance && c.place.mode.is_none())
}

/// Scores of two candidates together.
pub(crate) fn pair_score(
    linearisation: &Linearisation<'_>,
    screen: &Screen,
    visits: &Visits,
    [a, b]: [Side<'_>; 2],
) -> Result<PairScore, DiscoverError> {
    let own = a.columns.ncols();
    let width = own + b.columns.ncols();
    let mut both = a.columns.clone().resize_horizontally(width, 0.0);
    both.columns_mut(own, b.columns.ncols()).copy_from(b.columns);
    let likelihood = Likelihood::new(linearisation, &both, visits)?;
    let pays = |side: &Side<'_>, columns: Range<usize>| {
        let distribution = likelihood.coefficient_distribution(columns);
        cost(side.candidate, &distribution, side.freedom, linearisation)
            + log_prior_odds(linearisation, screen, side.candidate)
    };
    let total = likelihood.deviance + pays(&a, 0..own) + pays(&b, own..width);
    let prior = |side: &Side<'_>| prior_penalty(linearisation, screen, side.candidate);
    let together = if yield_together(a.candidate, b.candidate) { total - prior(&b) } else { total };
    Ok(PairScore { total, data: together - prior(&a) })
}
