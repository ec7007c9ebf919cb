//! What a heavier payload would do: a difference of predictions through the compliances of the present model.

use crate::data::payload::{Stretch, changed, declares};
use crate::error::DiscoverError;
use crate::problem::linearisation::Linearisation;
use nalgebra::{DMatrix, DVector, Vector3};
use truepose_kinematics::rotation_log;

impl Linearisation<'_> {
    /// What another kilogram at one declared level of payload, in a stretch of time, would do, m or rad per kg; m × 1. A level in a stretch has
    /// the column of the level, with zeros outside of the stretch.
    pub fn heavier(&self, level: f64, during: Stretch) -> Result<DMatrix<f64>, DiscoverError> {
        let whole = self.loads.at(level, || column(self, level))?;
        let mut column = DMatrix::from_column_slice(whole.len(), 1, whole.as_slice());
        for station in self.stations() {
            if !declares(&station.conditions, (level, during)) {
                column.rows_mut(station.observations.start, station.observations.len()).fill(0.0);
            }
        }
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
