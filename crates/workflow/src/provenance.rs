//! Where a fit comes from.

use truepose_errormodel::FittedModel;

/// The program with its version, as results name it.
pub const PROGRAM: &str = concat!("truepose ", env!("CARGO_PKG_VERSION"));

/// Records which run made a fit.
pub(crate) fn origin(fitted: &mut FittedModel, verb: &str, solver: &str, rows: usize) {
    let provenance = &mut fitted.provenance;
    provenance.insert("program".into(), PROGRAM.into());
    provenance.insert("verb".into(), verb.into());
    provenance.insert("solver".into(), solver.into());
    provenance.insert("rows".into(), rows.into());
}

/// Records that a search made a fit with this seed; `all_rows` where its coefficients are those of all rows.
pub(crate) fn searched(fitted: &mut FittedModel, solver: &str, rows: usize, seed: u64, all_rows: bool) {
    origin(fitted, "discover", solver, rows);
    fitted.provenance.insert("seed".into(), seed.into());
    fitted.provenance.insert("structure_frozen_then_all_rows".into(), all_rows.into());
}
