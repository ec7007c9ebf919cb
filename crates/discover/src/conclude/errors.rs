//! Residuals of a model on the training rows and on held-out rows.

use truepose_identify::{Residuals, Spread};

/// Residuals of a model on the training rows and on held-out rows, m and rad.
#[derive(Debug, Clone, Default)]
pub struct Errors {
    /// Training rows.
    pub train: Residuals,
    /// Held-out rows: the test set, or all rows by nested folds ([`HeldOut`](crate::HeldOut)).
    pub holdout: Residuals,
    /// Rows that no fit uses, reported as outliers or suspect, as indices into `train` and into `holdout`.
    pub outliers: [Vec<usize>; 2],
}

impl Errors {
    /// Statistics of the 3-D position error of (training rows, test set), m.
    pub fn spreads(&self) -> (Spread, Spread) {
        (self.train.positions(), self.holdout.positions())
    }

    /// The same without the rows that no fit uses, m.
    pub fn spreads_without_outliers(&self) -> (Spread, Spread) {
        let of = |part: &Residuals, out: &[usize]| {
            let rows: Vec<usize> = (0..part.position.len()).filter(|row| !out.contains(row)).collect();
            part.positions_of(&rows)
        };
        (of(&self.train, &self.outliers[0]), of(&self.holdout, &self.outliers[1]))
    }

    /// 3-D RMS of (training rows, test set), m.
    pub(crate) fn rms(&self) -> (f64, f64) {
        let (train, holdout) = self.spreads();
        (train.rms, holdout.rms)
    }
}

/// The residuals with those of another model in these rows, where they are not known.
pub(crate) fn with_missing(mut residuals: Residuals, other: &Residuals, rows: &[usize]) -> Residuals {
    for &row in rows {
        if residuals.distance(row).is_none() {
            residuals.position[row] = other.position[row];
            residuals.orientation[row] = other.orientation[row];
        }
    }
    residuals
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Vector3;

    #[test]
    fn only_what_is_missing_is_filled_in() {
        let of = |values: [f64; 3]| Residuals {
            position: values.map(|v| Vector3::x() * v).to_vec(),
            orientation: vec![None; 3],
        };
        let filled = with_missing(of([1.0, f64::NAN, f64::NAN]), &of([5.0, 6.0, 7.0]), &[0, 1]);
        assert_eq!(filled.distance(0), Some(1.0));
        assert_eq!(filled.distance(1), Some(6.0));
        assert_eq!(filled.distance(2), None);
    }
}
