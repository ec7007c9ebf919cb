//! The score of two candidates together.
//!
//! ```text
//! score(a + b) = −2 ln L(a + b) + C_a + C_b + π_a + π_b
//! ```
//!
//! C and π: [`crate::contest::competitor`].

use crate::contest::competitor::{cost, log_prior_odds};
use crate::error::DiscoverError;
use crate::hypotheses::candidate::Candidate;
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

/// score(a + b).
pub(crate) fn pair_score(
    linearisation: &Linearisation<'_>,
    screen: &Screen,
    visits: &Visits,
    [a, b]: [Side<'_>; 2],
) -> Result<f64, DiscoverError> {
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
    Ok(likelihood.deviance + pays(&a, 0..own) + pays(&b, own..width))
}
