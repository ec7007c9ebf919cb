//! What every run of `identify` does with its result, whether its file was read whole or block by block.

use crate::args::Identify;
use crate::failure::Failure;
use crate::verdict::FitVerdict;
use truepose_errormodel::{FittedModel, ModelError};
use truepose_identify::IdentifyError;
use truepose_report::{IdentificationSummary, SpecificationLines, StreamedSummary, Verdict, millimetres};

/// Records in a fit that `identify` made it with this seed, and what is to be known of it; `held_out` where a test set was drawn first.
pub(crate) fn whole(fitted: &mut FittedModel, summary: &IdentificationSummary, seed: u64, held_out: bool) {
    FitVerdict::identified(summary).record(fitted);
    origin(&mut fitted.provenance, &summary.solver, summary.rows);
    fitted.provenance.insert("seed".into(), seed.into());
    fitted.provenance.insert("structure_frozen_then_all_rows".into(), held_out.into());
}

/// Records in a fit that `identify --stream` made it, and what is to be known of it.
pub(crate) fn streamed(fitted: &mut FittedModel, summary: &StreamedSummary, converged: bool) {
    FitVerdict::converged(converged).record(fitted);
    origin(&mut fitted.provenance, &summary.solver, summary.rows);
    fitted.provenance.insert("structure_from_rows".into(), summary.sampled.into());
}

/// Where a fit comes from.
fn origin(provenance: &mut serde_json::Map<String, serde_json::Value>, solver: &str, rows: usize) {
    provenance.insert("program".into(), concat!("truepose ", env!("CARGO_PKG_VERSION")).into());
    provenance.insert("verb".into(), "identify".into());
    provenance.insert("solver".into(), solver.into());
    provenance.insert("rows".into(), rows.into());
}

/// An error with the file that it is about, where it is about the data.
pub(super) fn refused(args: &Identify, error: IdentifyError) -> Failure {
    match error {
        IdentifyError::NothingMeasured { .. }
        | IdentifyError::Placement { .. }
        | IdentifyError::Model(ModelError::MissingSignal { .. }) => {
            Failure::Input(format!("{}: {error}", args.measured.data.display()))
        }
        _ => error.into(),
    }
}

/// Fails where the held-out poses fail the specification of `--spec`.
pub(super) fn conforms(specification: Option<&SpecificationLines>) -> Result<(), Failure> {
    match specification.map(|of| &of.judged) {
        Some(of) if of.verdict == Verdict::Fail => Err(Failure::Criterion(of.sentence())),
        Some(of) if of.poses == 0 => Err(Failure::Criterion(
            "no held-out pose has a measured position, so that none can be compared with the specification"
                .into(),
        )),
        _ => Ok(()),
    }
}

/// Compares the RMS (m) of so many rows with `--require`; of none nothing is known.
pub(super) fn require(args: &Identify, rms: f64, rows: usize) -> Result<(), Failure> {
    let Some(required) = args.require else { return Ok(()) };
    if rows == 0 {
        return Err(Failure::Criterion(format!(
            "no row has a measured position, so that there is no RMS to compare with the required {}",
            millimetres(required)
        )));
    }
    if rms <= required {
        return Ok(());
    }
    Err(Failure::Criterion(format!(
        "RMS {} is above the required {}",
        millimetres(rms),
        millimetres(required)
    )))
}
