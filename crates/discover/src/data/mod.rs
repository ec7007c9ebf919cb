//! Data before the fit: derived channels, corrected payloads, a sample of the poses.

pub(crate) mod derived;
pub(crate) mod independent;
pub(crate) mod payload;
pub(crate) mod sample;
