//! `truepose fleet`: fits of robots of one type as prior for the next.

use super::{told, usable_fit};
use crate::args::{Accept, Fleet};
use crate::failure::Failure;
use truepose_io::{check_writable, write_fit};
use truepose_report::FleetSummary;
use truepose_upkeep::fleet;
use truepose_workflow::in_session;

/// Runs the verb.
pub fn run(args: &Fleet) -> Result<(), Failure> {
    check_writable(&args.out)?;
    let mut fits = Vec::new();
    for file in &args.fits {
        fits.push(in_session(usable_fit(file, &Accept::default())?, None, true)?);
    }
    let mut made = fleet(&fits).map_err(|error| {
        let files: Vec<String> = args.fits.iter().map(|file| file.display().to_string()).collect();
        Failure::Input(format!("{}: {error}", files.join(", ")))
    })?;
    made.prior.provenance.insert("fleet_of".into(), made.robots.into());
    write_fit(&args.out, &made.prior)?;
    let summary = FleetSummary::new(&made);
    told(&summary, args.json, &args.out)
}
