//! What each session of a campaign leaves.

use crate::document::Document;
use crate::layout::Alignment;
use crate::{PositionStatistics, significant};
use serde::{Deserialize, Serialize};
use truepose_errormodel::{Dataset, Visits};
use truepose_identify::Residuals;

/// One installation of several.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct SessionSummary {
    /// Its name.
    pub name: String,
    /// Its rows.
    pub rows: usize,
    /// Its pose measurements.
    pub visits: usize,
    /// RMS of the 3-D position error of its placement with the nominal arm, mm; null where nothing was placed.
    pub placed_rms_mm: Option<f64>,
    /// Position errors with the fit, on its rows.
    pub train: PositionStatistics,
    /// Cross-validated; null without.
    pub held_out: Option<PositionStatistics>,
}

/// Of rows that know their session.
pub fn session_summaries(
    names: &[&str],
    placed: &[Option<f64>],
    data: &Dataset,
    residuals: &Residuals,
    held_out: Option<&Residuals>,
) -> Vec<SessionSummary> {
    let one = |(number, &name): (usize, &&str)| {
        let rows: Vec<usize> = (0..data.len()).filter(|&row| data.session(row) == number).collect();
        SessionSummary {
            name: name.into(),
            rows: rows.len(),
            visits: Visits::of(&data.select(&rows)).len(),
            placed_rms_mm: placed.get(number).copied().flatten().map(|rms| 1e3 * rms),
            train: residuals.positions_of(&rows).into(),
            held_out: held_out.map(|residuals| residuals.positions_of(&rows).into()),
        }
    };
    names.iter().enumerate().map(one).collect()
}

const HEAD: [&str; 5] = ["session", "poses", "nominal arm, mm", "with the fit, mm", "held out, mm"];

/// A row a session, under [`HEAD`].
fn cells(sessions: &[SessionSummary]) -> Vec<Vec<String>> {
    let number = |value: Option<f64>| value.map_or_else(|| "-".into(), |mm| significant(mm, 3));
    sessions
        .iter()
        .map(|session| {
            vec![
                session.name.clone(),
                session.visits.to_string(),
                number(session.placed_rms_mm),
                number(Some(session.train.rms_mm)),
                number(session.held_out.map(|spread| spread.rms_mm)),
            ]
        })
        .collect()
}

/// A table with a row a session; nothing without sessions.
pub(crate) fn show(sessions: &[SessionSummary], document: &mut Document) {
    use Alignment::{Left, Right};
    if !sessions.is_empty() {
        let sides = [Left, Right, Right, Right, Right];
        document.table("sessions, RMS of the 3-D position error", &HEAD, &sides, cells(sessions));
    }
}
