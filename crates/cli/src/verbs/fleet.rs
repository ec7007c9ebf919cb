//! `truepose fleet`: fits of robots of one type as prior for the next.

use super::sessions::chosen;
use super::told;
use crate::args::Fleet;
use crate::extensions::effects;
use crate::failure::Failure;
use crate::verdict::usable;
use truepose_io::{check_writable, read_fit, write_fit};
use truepose_report::FleetSummary;
use truepose_upkeep::fleet;

/// Runs the verb.
pub fn run(args: &Fleet) -> Result<(), Failure> {
    check_writable(&args.out)?;
    let mut fits = Vec::new();
    for file in &args.fits {
        fits.push(chosen(usable(file, read_fit(file, effects())?, false)?, None, true)?);
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
