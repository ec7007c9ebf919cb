//! Acceptance tests of a finding, and the model of the search as a value.

pub(crate) mod accepted;
pub(crate) mod admit;
pub(crate) mod evidence;
pub(crate) mod model;
pub(crate) mod outcome;
pub(crate) mod refine;
pub(crate) mod surrogates;
#[cfg(test)]
mod tests;
pub(crate) mod winner;
