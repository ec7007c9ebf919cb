//! The pose measurements with the largest errors, the same in terminal, page and JSON.

use crate::significant;
use serde::{Deserialize, Serialize};
use truepose_errormodel::Dataset;
use truepose_identify::{Identification, Residuals};

/// The largest error of a pose measurement.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct LargestError {
    /// Label of the pose measurement in the file; without labels its number, from 1.
    pub pose: String,
    /// Number of the row in the data, from 1.
    pub row: usize,
    /// Line of the file; null where the data came from no file.
    pub line: Option<u64>,
    /// Distance over the components that were measured, mm.
    pub error_mm: f64,
    /// Whether the row took no part in the fit that predicts it.
    pub held_out: bool,
}

impl LargestError {
    /// `line 304: 0.284 mm`, or `row 303: 0.284 mm` of data from no file.
    pub fn text(&self) -> String {
        let place = self.line.map_or_else(|| format!("row {}", self.row), |line| format!("line {line}"));
        format!("{place}: {} mm", significant(self.error_mm, 3))
    }
}

/// Label of the pose measurement of a row.
pub(crate) fn label(data: &Dataset, labels: &[i64], row: usize) -> String {
    let pose = data.visit[row];
    labels.get(pose).map_or_else(|| (pose + 1).to_string(), ToString::to_string)
}

/// The largest of an identification: each row with the error of a fit without it, where there is one.
pub(crate) fn largest_errors(
    found: &Identification,
    data: &Dataset,
    labels: &[i64],
    count: usize,
) -> Vec<LargestError> {
    let declared = &found.declared;
    let (first, held) = match &declared.held_out {
        Some(folds) => (&folds.residuals, true),
        None => (&declared.train, false),
    };
    let mut all: Vec<(usize, f64, bool)> = Vec::new();
    let mut add = |rows: &mut dyn Iterator<Item = usize>, residuals: &Residuals, held: bool| {
        let each = rows.enumerate();
        all.extend(each.filter_map(|(k, row)| Some((row, 1e3 * residuals.distance(k)?, held))));
    };
    match &found.test_set {
        Some(test) => {
            let train = (0..data.len()).filter(|row| !test.rows.contains(row)).collect::<Vec<_>>();
            add(&mut train.into_iter(), first, held);
            add(&mut test.rows.iter().copied(), &test.declared, true);
        }
        None => add(&mut (0..data.len()), first, held),
    }
    all.sort_by(|a, b| b.1.total_cmp(&a.1).then(a.0.cmp(&b.0)));
    let mut largest: Vec<(usize, LargestError)> = Vec::new();
    for (row, error_mm, held_out) in all {
        if largest.len() == count {
            break;
        }
        let pose = data.visit[row];
        if largest.iter().all(|(other, _)| *other != pose) {
            let (line, row_number) = (data.line.get(row).copied(), row + 1);
            let pose_label = label(data, labels, row);
            largest
                .push((pose, LargestError { pose: pose_label, row: row_number, line, error_mm, held_out }));
        }
    }
    largest.into_iter().map(|(_, error)| error).collect()
}
