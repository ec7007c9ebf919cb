//! What a model leaves of the measurements, as one number.

use super::sums::left_over;
use crate::noise::{rays_of, whiten};
use crate::{IdentifyError, NoiseModel, Residuals};
use truepose_errormodel::{Dataset, ErrorModel, Visits};

/// What is left at these coefficients: the residuals, and the sum of their whitened squares.
///
/// # Errors
/// When the model and the data do not fit.
pub(crate) fn misfit(
    model: &ErrorModel,
    data: &Dataset,
    visits: &Visits,
    noise: NoiseModel,
    coefficients: &[f64],
) -> Result<(Residuals, f64), IdentifyError> {
    let residuals = left_over(model, data, coefficients, &vec![0.0; coefficients.len()])?;
    let mut squares = 0.0;
    let (mut numbers, mut sd, mut seen) = (Vec::new(), Vec::new(), Vec::new());
    for rows in &visits.rows {
        for component in 0..6 {
            numbers.clear();
            sd.clear();
            seen.clear();
            for &row in rows {
                let (value, deviation) = match (component, residuals.orientation[row]) {
                    (0..3, _) => match data.number(row, &residuals.position[row], component) {
                        Some(value) => (value, noise.position(data.position_sd[row][component])),
                        None => continue,
                    },
                    (_, Some(turn)) => {
                        (turn[component - 3], noise.orientation(data.orientation_sd[row][component - 3]))
                    }
                    _ => continue,
                };
                // A step that leads nowhere is the worst one.
                if value.is_nan() {
                    return Ok((residuals, f64::INFINITY));
                }
                numbers.push(value);
                sd.push(deviation);
                seen.push(row);
            }
            let shared = if component < 3 { noise.visit_sd } else { 0.0 };
            let places: Vec<usize> = (0..numbers.len()).collect();
            let rays = rays_of(data, component, seen.iter().copied());
            whiten((&mut numbers, 1), &places, &sd, &rays, shared, &mut [0.0]);
            squares += numbers.iter().map(|v| v * v).sum::<f64>();
        }
    }
    Ok((residuals, squares))
}
