//! Outliers as a finding, with what they have in common.

use crate::conclude::diagnosis::Finding;
use crate::data::payload;
use crate::hypotheses::candidate::Candidate;
use crate::hypotheses::change::Change;
use crate::hypotheses::outlier::Outlying;
use crate::hypotheses::place::Place;
use crate::hypotheses::variant::Variant;
use crate::problem::outliers::Outliers;
use crate::problem::shared::{InCommon, Shared};
use std::sync::Arc;
use truepose_errormodel::Visits;

/// Rows that are kept out, with what they have in common; `rms` with and without them, m.
pub(crate) fn outlier_finding(
    (outside, together): (&Outliers, Option<&Shared>),
    visits: &Visits,
    rms: (f64, f64),
    holdout: (f64, f64),
) -> Finding {
    let change = Change::Exclude { rows: outside.certain.clone() };
    let place = match together.map(|shared| &shared.what) {
        Some(InCommon::Level(level)) => Place { level: Some(payload::rounded(*level)), ..Place::default() },
        Some(InCommon::Stretch) => Place { mode: Some("stretch".into()), ..Place::default() },
        None => Place::default(),
    };
    let variant = Variant { place, change };
    Finding {
        candidate: Candidate::new(Arc::new(Outlying), variant),
        p_value: outside.p_value,
        name_probability: 1.0,
        unnamed_probability: 0.0,
        evidence: None,
        holdout,
        train: rms,
        parameters: Vec::new(),
        shape: Vec::new(),
        alternatives: Vec::new(),
        rows: outside.certain.clone(),
        poses: outside.poses.iter().map(|&visit| visits.rows[visit].clone()).collect(),
        trace: None,
    }
}
