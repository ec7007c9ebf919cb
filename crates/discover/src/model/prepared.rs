//! The data as a fit sees it: with corrected payloads and first sides, without excluded rows.

use crate::data::payload::corrected;
use crate::hypotheses::candidate::Candidate;
use crate::hypotheses::change::Change;
use truepose_errormodel::Dataset;

/// The data with the corrected payloads of these findings, and with the sides of their joints before the first move.
pub(crate) fn with_found(data: &Dataset, found: &[Candidate]) -> Dataset {
    let mut data = found.iter().fold(data.clone(), |data, candidate| match candidate.change {
        Change::CorrectLoad { level, mass, during, .. } => corrected(&data, (level, during), mass),
        Change::Add(_) | Change::Exclude { .. } => data,
    });
    for first in found.iter().filter_map(|candidate| candidate.first_side) {
        for row in without_side(&data, first.column) {
            data.approach[first.column][row] = first.side;
        }
    }
    data
}

/// Rows (0-based) in which it is not known from where a joint, by its column, came.
pub(crate) fn without_side(data: &Dataset, column: usize) -> Vec<usize> {
    (0..data.len()).filter(|&row| data.approach[column][row].abs() < 0.5).collect()
}

/// The data without the measurements of these rows (0-based); the rows stay, so that indices do.
pub(crate) fn without(data: &Dataset, rows: &[usize]) -> Dataset {
    let mut data = data.clone();
    for &row in rows {
        data.position[row] = [f64::NAN; 3];
        data.orientation[row] = None;
    }
    data
}
