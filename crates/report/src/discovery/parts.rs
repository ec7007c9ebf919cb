//! Position errors on the training part and on held-out rows.

use crate::PositionStatistics;
use serde::{Deserialize, Serialize};
use truepose_discover::Errors;

/// Position errors on the training part and on held-out rows.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct TrainAndHoldout {
    /// Training rows.
    pub train: PositionStatistics,
    /// Held-out rows.
    pub holdout: PositionStatistics,
    /// Training rows without those that no fit uses, where there are any.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub train_without_outliers: Option<PositionStatistics>,
    /// Held-out rows without those that no fit uses, where there are any.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub holdout_without_outliers: Option<PositionStatistics>,
}

impl TrainAndHoldout {
    /// Held-out rows without those that no fit uses: the ones that figures and verdict use.
    pub fn holdout_used(&self) -> PositionStatistics {
        self.holdout_without_outliers.unwrap_or(self.holdout)
    }

    /// Training rows without those that no fit uses.
    pub fn train_used(&self) -> PositionStatistics {
        self.train_without_outliers.unwrap_or(self.train)
    }
}

impl TrainAndHoldout {
    /// With the intervals of the held-out RMS without and with the rows that no fit uses, m.
    pub(super) fn with_intervals(mut self, used: [f64; 2], all: [f64; 2]) -> Self {
        self.holdout = self.holdout.with_interval(Some(all));
        self.holdout_without_outliers =
            self.holdout_without_outliers.map(|part| part.with_interval(Some(used)));
        self
    }
}

impl From<&Errors> for TrainAndHoldout {
    fn from(errors: &Errors) -> Self {
        let (train, holdout) = errors.spreads();
        let (good_train, good_holdout) = errors.spreads_without_outliers();
        let [out_train, out_holdout] = &errors.outliers;
        TrainAndHoldout {
            train: train.into(),
            holdout: holdout.into(),
            train_without_outliers: (!out_train.is_empty()).then(|| good_train.into()),
            holdout_without_outliers: (!out_holdout.is_empty()).then(|| good_holdout.into()),
        }
    }
}
