//! `truepose transfer`: the arm as identified, in another installation.

use super::{told, usable_fit};
use crate::args::Transfer;
use crate::failure::Failure;
use crate::terminal;
use crate::watch::Watch;
use truepose_io::{check_writable, read_measurements, write_fit};
use truepose_report::TransferSummary;
use truepose_upkeep::{Installation, TransferOptions, transfer};
use truepose_workflow::{in_session, one_installation, record_transferred};

/// Runs the verb.
pub fn run(args: &Transfer, watch: &Watch) -> Result<(), Failure> {
    check_writable(&args.out)?;
    let fitted = in_session(usable_fit(&args.fit, &args.accept)?, None, true)?;
    let (data, info, warnings) =
        read_measurements(&args.data, fitted.chain(), &args.grouped.measured_for(&fitted))?;
    terminal::warn(&warnings);
    one_installation(&info, &args.data)?;
    watch.doing("finding the installation");
    let installation = Installation { base: true, tool: args.tool, targets: args.targets };
    let options = TransferOptions { installation, update: args.update };
    let mut made = transfer(&fitted, &data, options)
        .map_err(|error| Failure::Input(format!("{}: {error}", args.data.display())))?;
    let summary = TransferSummary::new(&made, &data);
    record_transferred(&mut made.fitted, &summary, args.update, data.len());
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
