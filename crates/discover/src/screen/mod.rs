//! The score test of every candidate in one pass.

pub(crate) mod candidates;
pub(crate) mod functions;
pub(crate) mod multiplicity;
#[cfg(test)]
mod oracle;
pub(crate) mod periodogram;
pub(crate) mod refine;
pub(crate) mod screened;
pub(crate) mod untestable;
