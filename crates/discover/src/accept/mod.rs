//! What a finding has to pass before it becomes part of the model.

pub(crate) mod accepted;
pub(crate) mod admit;
pub(crate) mod evidence;
pub(crate) mod model;
pub(crate) mod outcome;
pub(crate) mod polish;
pub(crate) mod winner;
