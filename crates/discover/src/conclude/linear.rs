//! The final model, linearised over all rows: what would be left with some of its effects missing, or with others in their place.
//!
//! ```text
//! β = argmin ‖V^{-1/2} (y − A_s β)‖² + ‖W_s β‖²  over the rows that fits may use;   e = y − A_s β  everywhere
//! ```
//!
//! A_s are the columns of the effects that stay, and those that come in their place. The real robot and the noise stay those of the
//! final fit: what an effect does to either is of second order.

use crate::error::DiscoverError;
use crate::hypotheses::candidate::Candidate;
use crate::problem::likelihood::{distances, solved};
use crate::problem::linearisation::Scene;
use crate::problem::whitening::Whitener;
use crate::statistics::product::cross;
use nalgebra::{DMatrix, DVector};
use std::ops::Range;

/// Expected sizes within which coefficients of what comes in lie.
const WIDE: f64 = 100.0;

/// The model with its Gram matrix over the rows that fits may use.
pub(crate) struct Linear<'s> {
    scene: &'s Scene<'s>,
    /// Whitened `[A | y]`, of the rows that fits may use.
    white: DMatrix<f64>,
    whitener: Whitener,
    used: Vec<usize>,
    gram: DMatrix<f64>,
    prior: DMatrix<f64>,
}

impl<'s> Linear<'s> {
    /// `usable` tells which rows of the data fits may use.
    pub fn new(scene: &'s Scene<'s>, usable: &[bool]) -> Self {
        let r = scene.base.ncols();
        let whitener = scene.whitener(scene.noise);
        let used: Vec<usize> = (0..scene.len()).filter(|&at| usable[scene.observations[at].row]).collect();
        let mut all = scene.base.clone().resize_horizontally(r + 1, 0.0);
        all.column_mut(r).copy_from(&scene.y);
        whitener.apply(&mut all);
        let white = all.select_rows(&used);
        let gram = cross(&white, &white);
        let prior = scene.prior.as_ref().map_or_else(|| DMatrix::zeros(r, r), |rows| cross(rows, rows));
        Linear { scene, white, whitener, used, gram, prior }
    }

    /// Squared 3-D distance that is left of every row of the data, without these effects of the model and with this candidate.
    pub fn left(
        &self,
        without: &[Range<usize>],
        with: Option<&Candidate>,
    ) -> Result<Vec<f64>, DiscoverError> {
        let model = self.scene.fit.fitted.model();
        let missing =
            |column: usize| without.iter().any(|effects| effects.contains(&model.effect_of(column)));
        let r = self.scene.base.ncols();
        let stay: Vec<usize> = (0..r).filter(|&k| !missing(self.scene.fit.reduction.kept[k])).collect();
        let extra = match with {
            Some(candidate) => self.scene.columns_of(candidate)?,
            None => DMatrix::zeros(self.scene.len(), 0),
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
            prior[(s + j, s + j)] = 1.0 / (WIDE * WIDE);
        }
        gram.view_mut((s, s), (k, k)).copy_from(&cross(&white, &white));
        let (solution, _) = solved(&gram, &prior)?;
        let mut coefficients = DVector::zeros(r);
        stay.iter().zip(solution.iter()).for_each(|(&at, &value)| coefficients[at] = value);
        let left = &self.scene.y - &self.scene.base * coefficients - extra * solution.rows(s, k);
        Ok(distances(self.scene, left.as_slice()))
    }
}
