//! The C interface: one binary, a topic a module.

#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

mod calls;
#[cfg(unix)]
mod examples;
mod fits;
