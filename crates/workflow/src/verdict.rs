//! What a fit's own run found of it, in the file of the fit (`provenance.verdict`), and what the verbs that use it make of that.

use crate::error::WorkflowError;
use serde_json::{Value, json};
use std::path::Path;
use truepose_errormodel::FittedModel;
use truepose_report::{
    Correction, DiscoverySummary, IdentificationSummary, SpecificationLines, StageSummary, TransferSummary,
    Verdict,
};

/// Where a fit has it.
const KEY: &str = "verdict";

/// A declared model whose error at unseen poses is more than this many times that of base and tool alone is contradicted; of an exact arm it is a few
/// per cent larger by chance. A convention.
const WORSE: f64 = 1.25;

/// Where a fleet's prior has the number of its robots.
pub(crate) const FLEET: &str = "fleet_of";

/// What a run found of its fit.
#[derive(Debug, Clone, Copy)]
pub(crate) struct FitVerdict {
    /// Whether the fit converged.
    pub converged: bool,
    /// Whether it fits the data that it was made from; none where nothing was left to test it with.
    pub fits: Option<bool>,
    /// Whether unseen poses are predicted much worse than by base and tool alone.
    pub contradicted: bool,
    /// Whether it failed a specification that was requested; none without one.
    pub failed: Option<bool>,
}

impl FitVerdict {
    /// Of a fit of which only this is known.
    pub fn converged(converged: bool) -> Self {
        FitVerdict { converged, fits: None, contradicted: false, failed: None }
    }

    /// Of an identification.
    pub fn identified(summary: &IdentificationSummary) -> Self {
        let unseen = |stage: &StageSummary| Some(stage.test_set.or(stage.held_out)?.rms_mm);
        // The declared model is the last stage, behind the installation alone. One that fits its own rows no better leaves base or tool out.
        let worse = match summary.stages.as_slice() {
            [.., alone, declared] if declared.train.rms_mm <= alone.train.rms_mm => {
                unseen(alone).zip(unseen(declared))
            }
            _ => None,
        };
        FitVerdict {
            contradicted: worse.is_some_and(|(alone, declared)| declared > WORSE * alone),
            failed: failed(summary.specification.as_ref()),
            ..FitVerdict::converged(summary.converged)
        }
    }

    /// Of a search.
    pub fn discovered(summary: &DiscoverySummary, converged: bool) -> Self {
        let failed = failed(summary.specification.as_ref());
        FitVerdict { failed, ..FitVerdict::converged(converged) }
    }

    /// Records it in a fit.
    pub fn record(self, fitted: &mut FittedModel) {
        let FitVerdict { converged, fits, contradicted, failed } = self;
        let words = json!({
            "converged": converged,
            "fits": fits,
            "contradicted": contradicted,
            "specification": failed.map(|failed| if failed { "fail" } else { "not failed" }),
        });
        fitted.provenance.insert(KEY.into(), words);
    }
}

/// Whether the robot fails its specification with the fit; none where nothing is done with the fit.
fn failed(specification: Option<&SpecificationLines>) -> Option<bool> {
    let of = &specification.filter(|of| of.judged.correction != Correction::None)?.judged;
    Some(of.verdict == Verdict::Fail)
}

/// Why a fit is not to be used, in words; nothing where nothing is known against it.
fn against(fitted: &FittedModel) -> Vec<&'static str> {
    let is = |key: &str, value: &Value| fitted.provenance.get(KEY).and_then(|of| of.get(key)) == Some(value);
    let mut all = Vec::new();
    if is("fits", &false.into()) {
        all.push("it does not fit the measurements that it was made from");
    }
    if is("contradicted", &true.into()) {
        all.push("it predicts unseen poses worse than base and tool alone");
    }
    all
}

/// What is to be known of a fit that is used all the same.
fn doubts(fitted: &FittedModel) -> Vec<&'static str> {
    let of = |key: &str| fitted.provenance.get(KEY).and_then(|of| of.get(key));
    let mut all = Vec::new();
    if of("converged") == Some(&false.into()) {
        all.push("it has NOT CONVERGED: none of its figures is final");
    }
    if of("specification") == Some(&"fail".into()) {
        all.push("it failed the specification of its run");
    }
    if fitted.provenance.contains_key("incomplete") {
        all.push("its search was ended before it was complete");
    }
    all
}

/// Whether this is a fleet's prior and no robot.
pub(crate) fn of_fleet(fitted: &FittedModel) -> bool {
    fitted.provenance.contains_key(FLEET)
}

/// Warnings about a fit that is used.
///
/// # Errors
/// When it does not fit, and is not accepted all the same.
pub fn marks(fitted: &FittedModel, accepted: bool) -> Result<Vec<String>, String> {
    const RELY: &str = "this fit is not to be relied on";
    let against = against(fitted);
    if !against.is_empty() && !accepted {
        return Err(format!("{RELY}: {}. Measure again and identify", against.join("; ")));
    }
    Ok(against.into_iter().chain(doubts(fitted)).map(|words| format!("{RELY}: {words}")).collect())
}

/// Warnings about the fit of a file that is used as that of a robot; `accepted` where the user insists on one that does not fit.
///
/// # Errors
/// When it is no robot's, or does not fit.
pub fn usable(file: &Path, fitted: &FittedModel, accepted: bool) -> Result<Vec<String>, WorkflowError> {
    let refused = |words: String| WorkflowError::about(file, WorkflowError::Input(words));
    if of_fleet(fitted) {
        let words = "is a fleet's prior, and no robot; give it to `truepose identify --prior`";
        return Err(refused(words.into()));
    }
    let marks =
        marks(fitted, accepted).map_err(|words| refused(format!("{words}, or insist with --accept")))?;
    Ok(marks.iter().map(|words| format!("{}: {words}", file.display())).collect())
}

/// Records in a transferred fit where it comes from, and whether the arm fits there.
pub fn record_transferred(made: &mut FittedModel, summary: &TransferSummary, update: bool, rows: usize) {
    FitVerdict { fits: summary.arm.fits, ..FitVerdict::converged(true) }.record(made);
    let provenance = &mut made.provenance;
    provenance.insert("transferred".into(), true.into());
    provenance.insert("transfer_updated_the_arm".into(), update.into());
    provenance.insert("transfer_rows".into(), rows.into());
}

#[cfg(test)]
mod tests {
    use super::*;
    use truepose_errormodel::ErrorModel;
    use truepose_kinematics::nalgebra::DMatrix;
    use truepose_kinematics::samples;

    #[test]
    fn what_does_not_fit_is_refused_and_what_did_not_converge_is_marked() {
        let model = ErrorModel::new(samples::ur10(), Vec::new()).unwrap();
        let fitted = FittedModel::new(model, Vec::new(), DMatrix::zeros(0, 0)).unwrap();
        let of = |verdict: FitVerdict| {
            let mut fitted = fitted.clone();
            verdict.record(&mut fitted);
            fitted
        };
        let good = of(FitVerdict::converged(true));
        assert!(against(&good).is_empty() && doubts(&good).is_empty() && against(&fitted).is_empty());
        let bad = of(FitVerdict { fits: Some(false), ..FitVerdict::converged(true) });
        assert!(usable(Path::new("f"), &bad, false).is_err() && usable(Path::new("f"), &bad, true).is_ok());
        let open = of(FitVerdict { failed: Some(true), ..FitVerdict::converged(false) });
        assert_eq!(doubts(&open).len(), 2);
        let mut fleet = fitted.clone();
        fleet.provenance.insert(FLEET.into(), 4.into());
        assert!(of_fleet(&fleet) && usable(Path::new("f"), &fleet, true).is_err());
    }
}
