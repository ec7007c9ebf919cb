//! What a model may lack: every family at every place where it can act, as ordinary effects.

pub(crate) mod candidate;
pub(crate) mod compliance;
pub(crate) mod components;
pub(crate) mod constant;
pub(crate) mod covariate;
pub(crate) mod family;
pub(crate) mod guideway;
pub(crate) mod library;
pub(crate) mod loaded;
pub(crate) mod motion;
pub(crate) mod nonlinear;
pub(crate) mod payload;
pub(crate) mod penalty;
pub(crate) mod place;
pub(crate) mod setting;
pub(crate) mod thermal;
pub(crate) mod time;
pub(crate) mod unmodelled;
