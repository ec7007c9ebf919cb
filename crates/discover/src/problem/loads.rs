//! What a heavier payload would do, kept with a linearised problem.

use crate::error::DiscoverError;
use nalgebra::DVector;
use std::sync::{Arc, Mutex, PoisonError};

/// The columns of declared levels (kg, by their bits), once they are needed: m or rad per kg of each of m observations.
#[derive(Debug, Default)]
pub(crate) struct Loads {
    known: Mutex<Vec<(u64, Arc<DVector<f64>>)>>,
}

impl Loads {
    /// The column of a level; `column` computes it the first time.
    pub fn at(
        &self,
        level: f64,
        column: impl FnOnce() -> Result<DVector<f64>, DiscoverError>,
    ) -> Result<Arc<DVector<f64>>, DiscoverError> {
        let known = || self.known.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some((_, column)) = known().iter().find(|(bits, _)| *bits == level.to_bits()) {
            return Ok(Arc::clone(column));
        }
        let column = Arc::new(column()?);
        known().push((level.to_bits(), Arc::clone(&column)));
        Ok(column)
    }
}
