//! Fits beside independent programs, and what they do not depend on: one binary, a topic a module.

#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

mod invariances;
mod refinement;
mod streamed;
