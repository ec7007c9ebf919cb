//! The simulated real robot beside independent references: one binary, a topic a module.

#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

mod digits;
mod disturbances;
mod independence;
mod kinds;
mod reciprocity;
