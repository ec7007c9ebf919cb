//! Earlier findings tested again when a new one has changed the model.

pub(crate) mod merge;
pub(crate) mod reconsider;
pub(crate) mod revision;
