//! Solvers beside references and on hard problems: one binary, a topic a module.

#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

#[cfg(feature = "clarabel")]
mod conditioning;
mod outliers;
mod reference;
mod streams;
mod third_party;
