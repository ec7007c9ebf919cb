//! Tests that cross crates: one topic a module, one binary.

#![allow(
    clippy::unwrap_used,
    clippy::print_stdout,
    reason = "a test says what it saw, and fails by panicking"
)]

mod beams;
mod branches;
mod cancelled;
mod census;
mod compensation;
mod constraints;
mod convergence;
mod cross_validation;
mod discovery;
mod exact;
mod excitation;
mod guard_bands;
mod invariances;
mod kinematics_files;
#[path = "../metamorphic/mod.rs"]
mod metamorphic;
mod odd_robots;
mod permuted;
mod placement;
mod plants;
mod programs;
mod readme;
mod reduction;
mod shapes;
mod shared_data;
mod solvers_agree;
mod suspicions;
mod unseen;
mod upkeep;
mod verdict;
mod vocabulary;
