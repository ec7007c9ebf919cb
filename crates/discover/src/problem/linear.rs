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
use crate::problem::likelihood::{distances, solved};
use crate::problem::linearisation::Linearisation;
use crate::problem::whitening::Whitener;
use crate::statistics::product::{cross, gram_matrix};
use nalgebra::{DMatrix, DVector};
use std::ops::Range;

/// The linearised model with its Gram matrix over the rows of the fit.
pub(crate) struct Linear<'s> {
    linearisation: &'s Linearisation<'s>,
    /// Whitened `[A | y]` of the rows of the fit.
    white: DMatrix<f64>,
    whitener: Whitener,
    used: Vec<usize>,
    gram: DMatrix<f64>,
    prior: DMatrix<f64>,
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
        let white = all.select_rows(&used);
        let gram = gram_matrix(&white);
        let prior = linearisation.prior.as_ref().map_or_else(|| DMatrix::zeros(r, r), gram_matrix);
        Linear { linearisation, white, whitener, used, gram, prior }
    }

    /// Squared 3-D residual of every row of the data, m², without these effects of the model and with this
    /// candidate.
    pub fn left(
        &self,
        without: &[Range<usize>],
        with: Option<&Candidate>,
    ) -> Result<Vec<f64>, DiscoverError> {
        let model = self.linearisation.fit.fitted.model();
        let missing =
            |column: usize| without.iter().any(|effects| effects.contains(&model.effect_of(column)));
        let r = self.linearisation.base.ncols();
        let stay: Vec<usize> = (0..r)
            .filter(|&k| self.linearisation.fit.reduction.kept.get(k).is_none_or(|&c| !missing(c)))
            .collect();
        let extra = match with {
            Some(candidate) => self.linearisation.columns_of(candidate)?,
            None => DMatrix::zeros(self.linearisation.len(), 0),
        };
        let (s, k) = (stay.len(), extra.ncols());
        let white = self.whitener.of(&extra).select_rows(&self.used);
        // [A_s | X | y].
        let mut gram = DMatrix::zeros(s + k + 1, s + k + 1);
        let mut prior = DMatrix::zeros(s + k, s + k);
        let place = |at: usize| if at < s { stay[at] } else { r };
        for i in (0..s).chain([s + k]) {
            for j in (0..s).chain([s + k]) {
                gram[(i, j)] = self.gram[(place(i), place(j))];
                if i < s && j < s {
                    prior[(i, j)] = self.prior[(place(i), place(j))];
                }
            }
        }
        let along = cross(&self.white, &white);
        for j in 0..k {
            for i in (0..s).chain([s + k]) {
                gram[(i, s + j)] = along[(place(i), j)];
                gram[(s + j, i)] = along[(place(i), j)];
            }
            prior[(s + j, s + j)] = 1.0 / (self.linearisation.policy.wide * self.linearisation.policy.wide);
        }
        gram.view_mut((s, s), (k, k)).copy_from(&gram_matrix(&white));
        let (solution, _) = solved(&gram, &prior)?;
        let mut coefficients = DVector::zeros(r);
        stay.iter().zip(solution.iter()).for_each(|(&at, &value)| coefficients[at] = value);
        let left =
            &self.linearisation.y - &self.linearisation.base * coefficients - extra * solution.rows(s, k);
        Ok(distances(self.linearisation, left.as_slice()))
    }
}
