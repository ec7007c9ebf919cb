//! Model comparison: the best candidates of a screen, each with its own noise estimate.

pub(crate) mod competition;
pub(crate) mod competitor;
pub(crate) mod look_ahead;
pub(crate) mod names;
pub(crate) mod pair;
pub(crate) mod payload;
pub(crate) mod penalty;
#[cfg(test)]
mod tests;
