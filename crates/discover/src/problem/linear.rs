//! The final model, linearised over all rows, without some of its effects or with another candidate in their
//! place.
//!
//! ```text
//! β = argmin ‖V^{-1/2} (y − A_s β)‖² + ‖W_s β‖²  over the rows of the fit;   e = y − A_s β  in all rows
//! ```
//!
//! A_s are the columns of the remaining effects and of the candidate. The point of linearisation and the
//! noise are those of the final fit: the influence of an effect on either is of second order.

use crate::error::DiscoverError;
use crate::hypotheses::candidate::Candidate;
use crate::problem::equations::{Equations, bordered, precision, solved};
use crate::problem::linearisation::Linearisation;
use crate::problem::residuals::distances;
use crate::problem::whitening::Whitener;
use crate::statistics::product::{cross, gram_matrix};
use nalgebra::{DMatrix, DVector};
use std::ops::Range;

/// The linearised model with its normal equations over the rows of the fit.
pub(crate) struct Linear<'s> {
    linearisation: &'s Linearisation<'s>,
    whitener: Whitener,
    /// The observations of the fit, and [A | y] over them.
    used: Vec<usize>,
    equations: Equations,
}

impl<'s> Linear<'s> {
    /// `usable`: rows of the data that are part of the fit.
    pub fn new(linearisation: &'s Linearisation<'s>, usable: &[bool]) -> Self {
        let r = linearisation.base.ncols();
        let whitener = linearisation.whitener(linearisation.noise);
        let used: Vec<usize> =
            (0..linearisation.len()).filter(|&at| usable[linearisation.observations[at].row]).collect();
        let mut all = linearisation.base.clone().resize_horizontally(r + 1, 0.0);
        all.column_mut(r).copy_from(&linearisation.y);
        whitener.apply(&mut all);
        Linear { linearisation, whitener, equations: Equations::new(all.select_rows(&used)), used }
    }

    /// Squared 3-D residual of every row of the data, m², without these effects of the model and with this
    /// candidate.
    pub fn left(
        &self,
        without: &[Range<usize>],
        with: Option<&Candidate>,
    ) -> Result<Vec<f64>, DiscoverError> {
        let linearisation = self.linearisation;
        let model = linearisation.fit.fitted.model();
        let missing =
            |column: usize| without.iter().any(|effects| effects.contains(&model.effect_of(column)));
        let r = linearisation.base.ncols();
        let stay: Vec<usize> = (0..r)
            .filter(|&k| linearisation.fit.reduction.kept.get(k).is_none_or(|&c| !missing(c)))
            .collect();
        let extra = match with {
            Some(candidate) => linearisation.columns_of(candidate)?,
            None => DMatrix::zeros(linearisation.len(), 0),
        };
        let (s, k) = (stay.len(), extra.ncols());
        let white = self.whitener.of(&extra).select_rows(&self.used);
        let along = cross(self.equations.white(), &white);
        let gram = bordered(self.equations.all(), &stay, &along, &gram_matrix(&white));
        let held = precision(linearisation.prior_precision(), &stay, k, linearisation.policy.wide);
        let (solution, _) = solved(&gram, &held)?;
        let mut coefficients = DVector::zeros(r);
        stay.iter().zip(solution.iter()).for_each(|(&at, &value)| coefficients[at] = value);
        let left = &linearisation.y - &linearisation.base * coefficients - extra * solution.rows(s, k);
        Ok(distances(linearisation, left.as_slice()))
    }
}
