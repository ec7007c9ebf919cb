//! The program as a user runs it: one process a run, files in a folder of its own.

#![allow(
    clippy::unwrap_used,
    clippy::print_stdout,
    reason = "a test says what it saw, and fails by panicking"
)]
// What only slow tests use.
#![cfg_attr(not(feature = "slow"), allow(dead_code, unused_imports))]

mod acceptance;
mod backup;
mod columns;
mod contacts;
mod coupled;
mod determinism;
mod dwell;
mod example;
mod export;
mod exports;
mod external;
mod files;
mod fleet;
mod folder;
mod handover;
mod harm;
mod hostile;
mod init;
mod installed;
mod invariance;
mod landmarks;
mod limits;
mod looks;
mod mimic;
mod observations;
mod one_voice;
mod output;
mod page;
mod pages;
#[cfg(feature = "parquet")]
mod parquet;
mod plan_observed;
mod programs;
mod report;
mod round_trip;
mod same_bytes;
mod sessions;
mod side_by_side;
mod simulated;
mod stated;
mod stream;
mod surface;
mod taught;
mod unmoved;
mod upkeep;
mod wording;
