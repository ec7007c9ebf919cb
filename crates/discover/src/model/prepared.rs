//! The data as a fit sees it: with corrected payloads and first sides, without excluded rows.

use crate::data::payload::corrected;
use crate::hypotheses::candidate::Candidate;
use crate::hypotheses::change::Change;
use std::borrow::Cow;
use truepose_errormodel::Dataset;

/// The data with the corrected payloads of these findings, and with the sides of their joints before the first move.
pub(crate) fn with_found(data: &Dataset, found: &[Candidate]) -> Dataset {
    found_in(Cow::Borrowed(data), found).into_owned()
}

/// The same; the data itself where no finding changes it.
pub(crate) fn found_in<'d>(data: Cow<'d, Dataset>, found: &[Candidate]) -> Cow<'d, Dataset> {
    let changes = |candidate: &Candidate| {
        matches!(candidate.change, Change::CorrectLoad { .. }) || candidate.first_side.is_some()
    };
    if !found.iter().any(changes) {
        return data;
    }
    let mut data = found.iter().fold(data.into_owned(), |data, candidate| match candidate.change {
        Change::CorrectLoad { level, mass, during, .. } => corrected(&data, (level, during), mass),
        Change::Add(_) | Change::Exclude { .. } => data,
    });
    for first in found.iter().filter_map(|candidate| candidate.first_side) {
        for row in without_side(&data, first.column) {
            data.approach[first.column][row] = first.side;
        }
    }
    Cow::Owned(data)
}

/// Rows (0-based) in which it is not known from where a joint, by its column, came.
pub(crate) fn without_side(data: &Dataset, column: usize) -> Vec<usize> {
    (0..data.len()).filter(|&row| data.approach[column][row].abs() < 0.5).collect()
}

/// The data without the measurements of these rows (0-based); the rows stay, so that indices do.
pub(crate) fn without(data: &Dataset, rows: &[usize]) -> Dataset {
    emptied(data.clone(), rows)
}

/// The same of data that nobody else needs.
pub(crate) fn emptied(mut data: Dataset, rows: &[usize]) -> Dataset {
    for &row in rows {
        data.position[row] = [f64::NAN; 3];
        data.orientation[row] = None;
    }
    data
}
