//! What a heavier payload would do: a difference of predictions through the compliances of the present model.

use crate::data::payload::{Stretch, changed, declares};
use crate::error::DiscoverError;
use crate::problem::linearisation::Linearisation;
use nalgebra::{DMatrix, DVector, Vector3};
use std::sync::{Arc, Mutex, PoisonError};
use truepose_kinematics::rotation_log;

/// The columns of declared levels (kg, by their bits), once they are needed: m or rad per kg of each of m observations. A level in a stretch
/// of time has the same column, with zeros outside of the stretch.
#[derive(Debug, Default)]
pub(crate) struct Loads {
    known: Mutex<Vec<(u64, Arc<DVector<f64>>)>>,
}

impl Loads {
    /// The column of another kilogram at one declared level in a stretch of time; m × 1.
    pub fn heavier(
        &self,
        linearisation: &Linearisation<'_>,
        level: f64,
        during: Stretch,
    ) -> Result<DMatrix<f64>, DiscoverError> {
        let whole = self.whole(linearisation, level)?;
        let mut column = DMatrix::from_column_slice(whole.len(), 1, whole.as_slice());
        for station in linearisation.stations() {
            if !declares(&station.conditions, (level, during)) {
                column.rows_mut(station.observations.start, station.observations.len()).fill(0.0);
            }
        }
        Ok(column)
    }

    fn whole(
        &self,
        linearisation: &Linearisation<'_>,
        level: f64,
    ) -> Result<Arc<DVector<f64>>, DiscoverError> {
        let known = || self.known.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some((_, column)) = known().iter().find(|(bits, _)| *bits == level.to_bits()) {
            return Ok(Arc::clone(column));
        }
        let column = Arc::new(column(linearisation, level)?);
        known().push((level.to_bits(), Arc::clone(&column)));
        Ok(column)
    }
}

fn column(linearisation: &Linearisation<'_>, level: f64) -> Result<DVector<f64>, DiscoverError> {
    const STEP: f64 = 1e-2;
    let fitted = linearisation.present()?;
    let data = linearisation.data;
    let mut predictor = fitted.bind(&linearisation.inputs().schema)?;
    let mut column = DVector::zeros(linearisation.len());
    for station in linearisation.stations() {
        let Some(heavier) = changed(&station.conditions, (level, None), level + STEP) else { continue };
        let mut at = station.observations.start;
        let rows = &linearisation.observations[station.observations.clone()];
        for row in rows.chunk_by(|a, b| a.row == b.row) {
            let aim = data.aim(row[0].row);
            let before = predictor.predict(&station.conditions, aim);
            let after = predictor.predict(&heavier, aim);
            let moved = (after.translation - before.translation) / STEP;
            let moved = data.ray(row[0].row).map_or(moved, |w| Vector3::new(w.dot(&moved), 0.0, 0.0));
            let turned = rotation_log(&(after.rotation * before.rotation.transpose())) / STEP;
            for o in row {
                column[at] = if o.component < 3 { moved[o.component] } else { turned[o.component - 3] };
                at += 1;
            }
        }
    }
    Ok(column)
}
