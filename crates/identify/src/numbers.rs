//! The measured numbers of rows, so that rows of one, two and three components scatter on one scale.

use crate::Residuals;
use crate::residuals::measured;
use nalgebra::Vector3;
use std::collections::BTreeMap;
use truepose_errormodel::{Aim, Dataset};

/// Cosine of the angle between directions below which two rows measured different numbers.
const SAME_DIRECTION: f64 = 0.99;

/// Residuals as the numbers that were measured.
pub(crate) struct Numbers<'a> {
    residuals: &'a Residuals,
    data: &'a Dataset,
    /// Of a number along a direction, per metre: typical ‖w‖; one where whole positions set the scale.
    unit: f64,
}

/// Residuals of one target in the same components or along the same direction.
pub(crate) struct Alike<T> {
    seen: [bool; 3],
    direction: Option<Vector3<f64>>,
    /// What is known of them.
    pub of: T,
}

/// Residuals by what they measured.
pub(crate) type ByAim<T> = BTreeMap<Aim, Vec<Alike<T>>>;

impl<'a> Numbers<'a> {
    /// Of these residuals.
    pub fn new(residuals: &'a Residuals, data: &'a Dataset) -> Self {
        let mut unit = 1.0;
        let positions = (0..data.len()).any(|row| data.ray(row).is_none() && data.seen(row).components() > 0);
        if data.rays().is_some() && !positions {
            let rays = || (0..data.len()).filter_map(|row| data.ray(row));
            let square = rays().map(|w| w.norm_squared()).sum::<f64>() / rays().count().max(1) as f64;
            unit = square.sqrt();
        }
        Numbers { residuals, data, unit }
    }

    /// The measured numbers of a row, m; NaN for others; `None` where none was measured or predicted.
    pub fn of(&self, row: usize) -> Option<Vector3<f64>> {
        self.residuals.distance(row)?;
        let number = |axis| self.data.number(row, &self.residuals.position[row], axis);
        let numbers = Vector3::from_fn(|axis, _| number(axis).map_or(f64::NAN, |v| v / self.unit));
        numbers.iter().any(|v| !v.is_nan()).then_some(numbers)
    }

    /// Mean count of numbers of a row that measured any: 3 of whole positions, 1 along directions.
    pub fn per_row(data: &Dataset) -> f64 {
        let each = (0..data.len()).map(|row| data.seen(row).components()).filter(|&n| n > 0);
        let (numbers, rows) = each.fold((0, 0), |(numbers, rows), n| (numbers + n, rows + 1));
        numbers as f64 / f64::from(rows.max(1))
    }

    /// The entry of what a row measured; a new one where there is none.
    pub fn entry<'m, T: Default>(&self, all: &'m mut ByAim<T>, row: usize) -> &'m mut T {
        let (seen, direction) = (self.data.seen(row).position, self.data.ray(row).map(|w| w.normalize()));
        let list = all.entry(self.data.aim(row)).or_default();
        let same = |one: &Alike<T>| match (one.direction, direction) {
            (Some(a), Some(b)) => a.dot(&b).abs() > SAME_DIRECTION,
            (None, None) => one.seen == seen,
            _ => false,
        };
        let at = list.iter().position(same).unwrap_or_else(|| {
            list.push(Alike { seen, direction, of: T::default() });
            list.len() - 1
        });
        &mut list[at].of
    }
}

/// How many components are no NaN.
pub(crate) fn count(numbers: &Vector3<f64>) -> usize {
    numbers.iter().filter(|v| !v.is_nan()).count()
}

/// Squared length over the components that are no NaN.
pub(crate) fn square(numbers: &Vector3<f64>) -> f64 {
    measured(numbers).norm_squared()
}
