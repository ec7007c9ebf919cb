//! A fitted model with the coefficients of other rows.

use crate::{FittedModel, ModelError};
use nalgebra::DMatrix;

impl FittedModel {
    /// The same with other coefficients and their covariance; everything else stays.
    ///
    /// # Errors
    /// When the sizes do not fit.
    pub fn with_coefficients(
        &self,
        coefficients: Vec<f64>,
        covariance: DMatrix<f64>,
    ) -> Result<Self, ModelError> {
        let mut made = FittedModel::new(self.model().clone(), coefficients, covariance)?.like(self);
        made.sessions.clone_from(&self.sessions);
        Ok(made)
    }
}
