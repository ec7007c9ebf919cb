//! Revision: earlier findings are tested again after a new one has changed the model.

pub(crate) mod merge;
pub(crate) mod naming;
pub(crate) mod reconsider;
pub(crate) mod revision;
pub(crate) mod split;

#[cfg(test)]
mod synthetic;
