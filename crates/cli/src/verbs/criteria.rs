//! Criteria of `--spec` and `--require`.

use crate::args::Identify;
use crate::failure::Failure;
use truepose_report::{SpecificationLines, Verdict, millimetres};

/// Fails where the held-out poses fail the specification of `--spec`.
pub fn conforms(specification: Option<&SpecificationLines>) -> Result<(), Failure> {
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
pub fn require(args: &Identify, rms: f64, rows: usize) -> Result<(), Failure> {
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
