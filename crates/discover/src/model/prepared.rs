//! The data as a fit sees it: with corrected payloads, without excluded rows.

use crate::data::payload::corrected;
use crate::hypotheses::candidate::Candidate;
use crate::hypotheses::change::Change;
use truepose_errormodel::Dataset;

/// The data with the corrected payloads of these findings.
pub(crate) fn with_loads(data: &Dataset, found: &[Candidate]) -> Dataset {
    found.iter().fold(data.clone(), |data, candidate| match candidate.change {
        Change::CorrectLoad { level, mass, during, .. } => corrected(&data, (level, during), mass),
        Change::Add(_) | Change::Exclude { .. } => data,
    })
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
