//! `truepose transfer`: the arm as identified, in another installation.

use super::sessions::{chosen, one};
use super::told;
use crate::args::Transfer;
use crate::extensions::effects;
use crate::failure::Failure;
use crate::terminal;
use crate::verdict::{FitVerdict, usable};
use crate::watch::Watch;
use truepose_errormodel::FittedModel;
use truepose_io::{check_writable, read_fit, read_measurements, write_fit};
use truepose_report::TransferSummary;
use truepose_upkeep::{Installation, TransferOptions, transfer};

/// Runs the verb.
pub fn run(args: &Transfer, watch: &Watch) -> Result<(), Failure> {
    check_writable(&args.out)?;
    let fitted = chosen(usable(&args.fit, read_fit(&args.fit, effects())?, args.accept.accept)?, None, true)?;
    let (data, info, warnings) =
        read_measurements(&args.data, fitted.chain(), &args.grouped.measured_for(&fitted))?;
    terminal::warn(&warnings);
    one(&info, &args.data)?;
    watch.doing("finding the installation");
    let installation = Installation { base: true, tool: args.tool, targets: args.targets };
    let options = TransferOptions { installation, update: args.update };
    let mut made = transfer(&fitted, &data, options)
        .map_err(|error| Failure::Input(format!("{}: {error}", args.data.display())))?;
    let summary = TransferSummary::new(&made, &data);
    record(&mut made.fitted, &summary, args.update, data.len());
    write_fit(&args.out, &made.fitted)?;
    told(&summary, args.json, &args.out)?;
    match summary.arm.fits {
        Some(false) if !args.accept.accept => Err(Failure::Criterion(format!(
            "the arm as identified does not fit in this installation; {} says so, and verbs refuse it without --accept",
            args.out.display()
        ))),
        _ => Ok(()),
    }
}

/// Records in a transferred fit where it comes from, and whether the arm fits there.
pub(crate) fn record(made: &mut FittedModel, summary: &TransferSummary, update: bool, rows: usize) {
    FitVerdict { fits: summary.arm.fits, ..FitVerdict::converged(true) }.record(made);
    let provenance = &mut made.provenance;
    provenance.insert("transferred".into(), true.into());
    provenance.insert("transfer_updated_the_arm".into(), update.into());
    provenance.insert("transfer_rows".into(), rows.into());
}
