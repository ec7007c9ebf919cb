//! The only place that writes to the terminal.

use std::io::Write;

/// A result, to stdout. A reader that has gone away (`| head`) is no error.
pub fn print(text: &str) {
    let mut out = std::io::stdout().lock();
    let _ = out.write_all(text.as_bytes()).and_then(|()| out.flush());
}

/// A remark, to stderr.
pub fn log(text: &str) {
    let _ = writeln!(std::io::stderr().lock(), "{text}");
}

/// Warnings of a reader, to stderr.
pub fn warn<W: std::fmt::Display>(warnings: &[W]) {
    for warning in warnings {
        log(&format!("warning: {warning}"));
    }
}
