//! The first sheet of a page: head of the certificate, verdict, and the chain from the robot as found to the verified one.

use super::Page;
use crate::figure::escape;
use crate::{PositionStatistics, RunRecord, significant};
use std::fmt::Write;

/// A stage of the chain.
pub(crate) struct SheetStage {
    pub name: String,
    /// On the rows of the fit.
    pub fitted: Option<PositionStatistics>,
    /// On poses that the fit has not seen.
    pub verified: Option<PositionStatistics>,
}

/// The last part of a path, however its folders are separated.
fn name_of(path: &str) -> &str {
    path.rsplit(['/', '\\']).next().unwrap_or(path)
}

impl Page {
    /// Robot, instrument, operator and date as the certificate has them, then these facts, the files that were read with the beginning of their
    /// SHA-256, and the program.
    pub(crate) fn head(&mut self, run: &RunRecord, facts: &[(&str, String)]) {
        let stated = run.certificate.iter().flatten().map(|(name, text)| (name.as_str(), text.clone()));
        let facts = facts.iter().map(|(name, text)| (*name, text.clone()));
        self.body += "<dl class=\"head\">";
        let read = run.inputs.iter().map(|input| {
            format!("{} ({})", name_of(&input.file), input.sha256.get(..8).unwrap_or(&input.sha256))
        });
        let read =
            Some(("files read", read.collect::<Vec<_>>().join(", "))).filter(|_| !run.inputs.is_empty());
        for (name, text) in stated.chain(facts).chain(read).chain([("software", run.program.clone())]) {
            let _ = write!(self.body, "<div><dt>{}</dt><dd>{}</dd></div>", escape(name), escape(&text));
        }
        self.body += "</dl>";
    }

    /// The chain of stages; `seen` is where the errors of unseen poses come from.
    pub(crate) fn stages(&mut self, stages: &[SheetStage], seen: &str) {
        let cells = |of: Option<PositionStatistics>| {
            of.map_or(["–", "–", "–"].map(String::from), |s| {
                [s.rms_mm, s.p95_mm, s.max_mm].map(|v| significant(v, 3))
            })
        };
        let row = |stage: &SheetStage| {
            let mut row = vec![stage.name.clone()];
            row.extend(cells(stage.fitted));
            row.extend(cells(stage.verified));
            row
        };
        let rows: Vec<Vec<String>> = stages.iter().map(row).collect();
        self.table(
            &format!("3-D position error, mm: on the rows of the fit, and verified {seen}"),
            &["stage", "RMS", "95 %", "largest", "verified: RMS", "95 %", "largest"],
            &rows,
            true,
        );
    }

    /// Ends the first sheet: what follows is printed on others.
    pub(crate) fn end_of_sheet(&mut self) {
        self.sheet = Some(self.body.len());
    }
}
