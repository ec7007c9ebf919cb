//! Errors before and after, on the training part and on the held-out test set.

use truepose_identify::{Residuals, Spread};

/// Errors on the training part and on the rows that took part in nothing.
#[derive(Debug, Clone, Default)]
pub struct Errors {
    /// Training rows.
    pub train: Residuals,
    /// Held-out rows.
    pub holdout: Residuals,
    /// Rows, counted within each of the two parts, that are reported as outliers.
    pub outliers: [Vec<usize>; 2],
}

impl Errors {
    /// Statistics of both parts, m.
    pub fn spreads(&self) -> (Spread, Spread) {
        (self.train.positions(), self.holdout.positions())
    }

    /// Statistics of both parts without the rows that are reported as outliers, m.
    pub fn spreads_without_outliers(&self) -> (Spread, Spread) {
        let of = |part: &Residuals, out: &[usize]| {
            let rows: Vec<usize> = (0..part.position.len()).filter(|row| !out.contains(row)).collect();
            part.positions_of(&rows)
        };
        (of(&self.train, &self.outliers[0]), of(&self.holdout, &self.outliers[1]))
    }

    /// 3-D RMS of both parts, m.
    pub(crate) fn rms(&self) -> (f64, f64) {
        let (train, holdout) = self.spreads();
        (train.rms, holdout.rms)
    }
}
