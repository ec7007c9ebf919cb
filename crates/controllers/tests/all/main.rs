//! Robot programs of all dialects: one binary, a topic a module.

#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

mod composed;
mod configurations;
mod corpus;
mod counted;
mod grammars;
mod loads;
mod programs;
mod registers;
mod statements;
mod understood;
mod units;
