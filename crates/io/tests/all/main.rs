//! Files as people and programs write them: one binary, a topic a module.

#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

mod dialects;
mod dwell;
#[cfg(feature = "xlsx")]
mod hostile_workbooks;
mod logs;
mod never_panics;
#[cfg(feature = "parquet")]
mod parquet;
mod proposals;
mod shared_files;
