//! Residuals of the measured numbers as rows of the data.

use crate::problem::linearisation::Linearisation;
use nalgebra::{DVector, Vector3};
use truepose_identify::Residuals;

/// Squared distance of each row of the data over the components that were measured, m²; NaN where none was.
pub(crate) fn distances(linearisation: &Linearisation<'_>, residual: &[f64]) -> Vec<f64> {
    let mut squares = vec![f64::NAN; linearisation.data.len()];
    let mut seen = vec![0; linearisation.data.len()];
    for (o, r) in linearisation.observations.iter().zip(residual) {
        if o.component < 3 {
            squares[o.row] = if seen[o.row] == 0 { r * r } else { squares[o.row] + r * r };
            seen[o.row] += 1;
        }
    }
    let of = |row: usize| match (linearisation.data.ray(row), seen[row]) {
        (Some(w), 1) => squares[row] / w.norm_squared(),
        (None, 1..) => squares[row],
        _ => f64::NAN,
    };
    (0..squares.len()).map(of).collect()
}

/// The measured numbers' residuals as rows.
pub(crate) fn as_residuals(linearisation: &Linearisation<'_>, residual: &DVector<f64>) -> Residuals {
    let mut rows = Residuals {
        position: vec![Vector3::repeat(f64::NAN); linearisation.data.len()],
        orientation: vec![None; linearisation.data.len()],
    };
    for (o, &r) in linearisation.observations.iter().zip(residual.iter()) {
        if let Some(w) = linearisation.data.ray(o.row).filter(|_| o.component == 0) {
            rows.position[o.row] = w * (r / w.norm_squared());
        } else if o.component < 3 {
            rows.position[o.row][o.component] = r;
        } else {
            rows.orientation[o.row].get_or_insert_with(Vector3::zeros)[o.component - 3] = r;
        }
    }
    rows
}
