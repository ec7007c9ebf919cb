//! Tests that cross crates: one topic a module, one binary.

#![allow(
    clippy::unwrap_used,
    clippy::print_stdout,
    reason = "a test says what it saw, and fails by panicking"
)]
// What only slow tests use.
#![cfg_attr(not(feature = "slow"), allow(dead_code, unused_imports))]

/// A number of draws, robots or steps: of the slow tests, and of their fast stand-in.
const fn of(slow: usize, fast: usize) -> usize {
    if cfg!(feature = "slow") { slow } else { fast }
}

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
mod external_axes;
mod few_poses;
mod guard_bands;
mod invariances;
mod kinematics_files;
mod leaning;
#[path = "../metamorphic/mod.rs"]
mod metamorphic;
mod odd_robots;
mod permuted;
mod placement;
mod plants;
mod positioner;
mod program_loads;
mod programs;
mod readme;
mod reduction;
mod shapes;
mod shared_data;
mod solvers_agree;
mod suspicions;
mod taught_frames;
mod unseen;
mod upkeep;
mod verdict;
mod vocabulary;
