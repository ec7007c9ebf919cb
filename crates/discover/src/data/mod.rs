//! Changes of the data before anything is fitted: derived channels, corrected payloads, a sample of the poses.

pub(crate) mod derived;
pub(crate) mod payload;
pub(crate) mod sample;
