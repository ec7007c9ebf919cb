//! The only place that writes to the terminal.

use std::borrow::Cow;
use std::cell::Cell;
use std::io::Write;

thread_local! {
    /// Whether this thread writes nothing.
    static SILENT: Cell<bool> = const { Cell::new(false) };
}

/// Runs `work` while this thread writes nothing to the terminal.
pub fn silently<T>(work: impl FnOnce() -> T) -> T {
    let before = SILENT.replace(true);
    let done = work();
    SILENT.set(before);
    done
}

/// A result, to stdout. A reader that has gone away (`| head`) is no error.
pub fn print(text: &str) {
    if SILENT.get() {
        return;
    }
    let mut out = std::io::stdout().lock();
    let _ = out.write_all(shown(text).as_bytes()).and_then(|()| out.flush());
}

/// A remark, to stderr.
pub fn log(text: &str) {
    if SILENT.get() {
        return;
    }
    let _ = writeln!(std::io::stderr().lock(), "{}", shown(text));
}

/// Escapes control characters: names come from files and arguments.
fn shown(text: &str) -> Cow<'_, str> {
    let steers = |c: char| c.is_control() && c != '\n' && c != '\t';
    if !text.contains(steers) {
        return text.into();
    }
    let one = |c: char| if steers(c) { c.escape_default().to_string() } else { c.to_string() };
    text.chars().map(one).collect::<String>().into()
}

/// Warnings of a reader, to stderr.
pub fn warn<W: std::fmt::Display>(warnings: &[W]) {
    for warning in warnings {
        log(&format!("warning: {warning}"));
    }
}
