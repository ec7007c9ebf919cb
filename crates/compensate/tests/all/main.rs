//! Commands, predictions and exports of fitted robots: one binary, a topic a module.

#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

mod accuracy;
mod allocation;
mod export;
mod fits;
mod hands;
mod held;
mod lists;
mod parameters;
mod round_trip;
