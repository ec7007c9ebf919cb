//! What is left between data and a model, and its statistics by row, axis, target and visit.
//!
//! Every `rms`, `p95` and `max` of a position is of the distance between measured and predicted position, m, over the components that were
//! measured: 3-D where all three were.

use crate::IdentifyError;
use nalgebra::Vector3;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use truepose_errormodel::{Dataset, FittedModel};
use truepose_kinematics::{Conditions, rotation_log};
use truepose_solvers::order::{quantile, sorted};

/// Residuals of each row: measured − predicted, in the measurement frame; of a row that measured one number the part along its direction,
/// of one in which two points met that of their difference ([`truepose_errormodel::Aim`]).
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Residuals {
    /// m; NaN for a component that was not measured.
    pub position: Vec<Vector3<f64>>,
    /// Rotation vector, rad; none where no orientation was measured.
    pub orientation: Vec<Option<Vector3<f64>>>,
}

/// Mean, root mean square, 95 % quantile and maximum of a magnitude.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct Spread {
    /// How many values.
    pub count: usize,
    /// Mean.
    pub mean: f64,
    /// Root mean square.
    pub rms: f64,
    /// 95 % quantile.
    pub p95: f64,
    /// Largest.
    pub max: f64,
}

/// Rows that one thread predicts one after the other.
const PART: usize = 4096;

impl Residuals {
    /// Of a fitted model on data.
    ///
    /// # Errors
    /// When the data lacks a signal that the model needs, or does not fit the robot.
    pub fn of(fitted: &FittedModel, data: &Dataset) -> Result<Self, IdentifyError> {
        data.validate(fitted.chain())?;
        // The whole record of a fit in whose data the order stands for the time.
        let ordered = (fitted.domain.by_order && !data.schema.time).then(|| data.clone().ordered());
        let data = ordered.as_ref().unwrap_or(data);
        let data = &*data.derived_for(fitted.model())?;
        let part = |rows: std::ops::Range<usize>| -> Result<Self, IdentifyError> {
            let mut predictor = fitted.bind(&data.schema)?;
            let mut conditions = Conditions::default();
            let mut residuals = Residuals::default();
            for row in rows {
                data.conditions_into(row, &mut conditions);
                let pose = predictor.predict(&conditions, data.aim(row));
                residuals.position.push(data.away(row, &pose.translation));
                let turn = |measured| rotation_log(&(measured * pose.rotation.transpose()));
                residuals.orientation.push(data.measured_rotation(row).map(turn));
            }
            Ok(residuals)
        };
        if data.len() <= PART {
            return part(0..data.len());
        }
        // Parts depend on the number of rows alone, and so do their numbers.
        let parts = (0..data.len().div_ceil(PART)).into_par_iter();
        let parts: Vec<Self> =
            parts.map(|k| part(k * PART..((k + 1) * PART).min(data.len()))).collect::<Result<_, _>>()?;
        let mut residuals = Residuals::default();
        for part in parts {
            residuals.position.extend(part.position);
            residuals.orientation.extend(part.orientation);
        }
        Ok(residuals)
    }

    /// Distance of a row over the components of its position that were measured, m; `None` where none was.
    pub fn distance(&self, row: usize) -> Option<f64> {
        distance(&self.position[row])
    }

    /// Distances of all rows.
    pub fn positions(&self) -> Spread {
        Spread::of((0..self.position.len()).filter_map(|row| self.distance(row)))
    }

    /// Angles of all rows, rad.
    pub fn orientations(&self) -> Spread {
        Spread::of(self.orientation.iter().flatten().map(|v| v.norm()))
    }

    /// Distances of these rows.
    pub fn positions_of(&self, rows: &[usize]) -> Spread {
        Spread::of(rows.iter().filter_map(|&row| self.distance(row)))
    }

    /// One axis (0…2) of all rows: mean is signed, the rest is of the magnitude.
    pub fn axis(&self, axis: usize) -> Spread {
        let values: Vec<f64> = self.position.iter().map(|v| v[axis]).filter(|v| v.is_finite()).collect();
        let mean = values.iter().sum::<f64>() / values.len().max(1) as f64;
        Spread { mean, ..Spread::of(values.iter().map(|v| v.abs())) }
    }
}

/// Length of an error over its components that are not NaN; `None` where all are.
pub fn distance(error: &Vector3<f64>) -> Option<f64> {
    let length = measured(error).norm();
    (length.is_finite() && error.iter().any(|v| !v.is_nan())).then_some(length)
}

/// The error with zero in components that are NaN, as they were not measured.
pub fn measured(error: &Vector3<f64>) -> Vector3<f64> {
    error.map(|v| if v.is_nan() { 0.0 } else { v })
}

impl Spread {
    /// Of these magnitudes.
    pub fn of(values: impl Iterator<Item = f64>) -> Self {
        let sorted = sorted(values);
        let Some(p95) = quantile(&sorted, 0.95) else {
            return Spread::default();
        };
        let n = sorted.len() as f64;
        Spread {
            count: sorted.len(),
            mean: sorted.iter().sum::<f64>() / n,
            rms: (sorted.iter().map(|v| v * v).sum::<f64>() / n).sqrt(),
            p95,
            max: sorted[sorted.len() - 1],
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_distance_is_over_the_components_that_were_measured() {
        let nan = f64::NAN;
        for (error, wanted) in [
            ([3.0, 4.0, 12.0], Some(13.0)),
            ([3.0, nan, -4.0], Some(5.0)),
            ([nan, -2.0, nan], Some(2.0)),
            ([nan; 3], None),
            ([nan, f64::INFINITY, 1.0], None),
        ] {
            assert_eq!(distance(&error.into()), wanted, "{error:?}");
        }
    }

    #[test]
    fn quantiles_as_numpy_takes_them() {
        let spread = Spread::of((0..=100).map(f64::from));
        assert!((spread.p95 - 95.0).abs() < 1e-12);
        assert!((spread.rms - 3350.0f64.sqrt()).abs() < 1e-9);
        assert_eq!(Spread::of(std::iter::empty()).count, 0);
    }
}
