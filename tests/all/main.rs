//! Tests that cross crates: one topic a module, one binary.

#![allow(
    clippy::unwrap_used,
    clippy::print_stdout,
    reason = "a test says what it saw, and fails by panicking"
)]

mod beams;
mod compensation;
mod cross_validation;
mod exact;
mod excitation;
mod placement;
mod plants;
mod reduction;
mod shared_data;
mod solvers_agree;
