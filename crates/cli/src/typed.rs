//! What was typed: the arguments of the process, or those that a host of another language hands over.

use std::ffi::OsString;
use std::sync::OnceLock;

static GIVEN: OnceLock<Vec<OsString>> = OnceLock::new();

/// Takes these in place of the arguments of the process, once; the first is the name of the program.
pub(crate) fn give(arguments: Vec<OsString>) {
    let _ = GIVEN.set(arguments);
}

/// The name of the program and what was typed behind it.
pub(crate) fn arguments() -> Vec<OsString> {
    GIVEN.get().cloned().unwrap_or_else(|| std::env::args_os().collect())
}
