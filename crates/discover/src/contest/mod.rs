//! The best candidates of a screen compared with each other, each with its own noise.

pub(crate) mod competition;
pub(crate) mod look_ahead;
pub(crate) mod payload;
pub(crate) mod rival;
