//! A specification case by case: the robot as it is, with corrected constants, and with corrected commands.
//!
//! The model's error at unseen poses is the robot's only where each command is corrected by the model. What is done with a fit is the user's
//! decision; the verdict is of that alone.

use crate::document::{Block, Document, Only};
use crate::layout::Alignment::{Left, Right};
use crate::{Correction, SpecificationSummary, count, significant};
use serde::{Deserialize, Serialize};

/// The largest error of each held-out pose and its standard uncertainty (m), under each [`Correction`].
pub type WorstByPose = [Vec<(f64, f64)>; 3];

/// Held-out poses against a limit: as the robot is, with constants, and if compensated. A verdict is of one of them alone.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct SpecificationLines {
    /// The case of what will be done, with its verdict.
    #[serde(flatten)]
    pub judged: SpecificationSummary,
    /// Every case, without a verdict.
    #[serde(default)]
    pub cases: Vec<SpecificationCase>,
}

/// A case of a specification, without a verdict.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct SpecificationCase {
    /// What is done.
    pub correction: Correction,
    /// Of the robot as it is: base and tool are as described, and not fitted.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub installation_as_described: bool,
    /// Held-out poses.
    pub poses: usize,
    /// Of them inside.
    pub inside: usize,
    /// RMS of the largest error of each pose, mm.
    pub rms_mm: f64,
    /// With 95 % confidence, 95 % of all poses are within this, mm; none with fewer than 59 poses.
    pub tolerance_mm: Option<f64>,
}

impl SpecificationLines {
    /// Of a limit (m) and what will be done. `described`: base and tool of the robot as it is are as described.
    pub fn new(limit: f64, correction: Correction, worst: &WorstByPose, described: bool) -> Self {
        let of = |poses: &[(f64, f64)]| {
            let errors: Vec<f64> = poses.iter().map(|pose| pose.0).collect();
            SpecificationSummary::new(limit, &errors).with_guard_band(poses)
        };
        let cases = Correction::ALL.into_iter().zip(worst).map(|(correction, poses)| {
            let figures = of(poses);
            let square: f64 = poses.iter().map(|pose| pose.0 * pose.0).sum();
            SpecificationCase {
                correction,
                installation_as_described: described && correction == Correction::None,
                poses: figures.poses,
                inside: figures.inside,
                rms_mm: 1e3 * (square / poses.len().max(1) as f64).sqrt(),
                tolerance_mm: figures.tolerance_mm,
            }
        });
        let cases = cases.collect();
        let judged = SpecificationSummary { correction, ..of(&worst[correction as usize]) };
        SpecificationLines { judged, cases }
    }

    /// The verdict, and each case: a line of the terminal, a row of the page.
    pub(crate) fn show(of: Option<&Self>, document: &mut Document) {
        let Some(of) = of else {
            let none =
                "No specification was given. With --spec 0.5mm, the held-out poses are compared with one.";
            return document.push(Only::Page, Block::Note(none.into()));
        };
        let word = of.judged.verdict.name();
        document.push(Only::Both, Block::Judged { word, sentence: of.judged.sentence() });
        for [name, figures] in of.lines() {
            document.push(Only::Terminal, Block::Item(format!("{name}: {figures}")));
        }
        let row = |case: &SpecificationCase| {
            let verdict = if case.correction == of.judged.correction { word } else { "–" };
            vec![
                case.correction.name().to_owned(),
                format!("{} of {}", case.inside, case.poses),
                significant(case.rms_mm, 3),
                case.tolerance_mm.map_or_else(|| "–".into(), |mm| significant(mm, 3)),
                verdict.to_owned(),
            ]
        };
        let table = Block::Table {
            caption: "the specification, case by case".into(),
            head: ["robot", "inside", "RMS, mm", "95 % within, mm", "verdict"].map(String::from).into(),
            sides: vec![Left, Right, Right, Right, Right],
            rows: of.cases.iter().map(row).collect(),
        };
        document.push(Only::Page, table);
        document.push(Only::Page, Block::Note(of.meaning()));
    }

    /// What the cases are.
    fn meaning(&self) -> String {
        let names: Vec<String> = self.cases.iter().map(SpecificationCase::name).collect();
        format!("{}. The verdict is of what will be done (--correction) alone.", names.join("; "))
    }

    /// One line a case: its name and its figures.
    pub fn lines(&self) -> Vec<[String; 2]> {
        self.cases.iter().map(|case| [case.name(), case.figures()]).collect()
    }
}

impl SpecificationCase {
    fn name(&self) -> String {
        let name = self.correction.name();
        match self.correction {
            Correction::None if self.installation_as_described => {
                format!("{name} (arm, base and tool as described)")
            }
            Correction::None => format!("{name} (arm as described; base and tool fitted)"),
            Correction::Constants => format!("{name} (geometry corrected in the controller)"),
            Correction::Commands => format!("{name} (each command corrected by the model)"),
        }
    }

    fn figures(&self) -> String {
        let within = self.tolerance_mm.map_or_else(String::new, |mm| {
            format!("; 95 % of all poses within {} mm, with 95 % confidence", significant(mm, 3))
        });
        let poses = count(self.poses, "held-out pose");
        format!(
            "{} of {poses} inside, RMS of each pose's largest error {} mm{within}",
            self.inside,
            significant(self.rms_mm, 3)
        )
    }
}
