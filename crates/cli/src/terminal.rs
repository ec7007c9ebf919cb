//! The only place that writes to the terminal.

use std::borrow::Cow;
use std::cell::Cell;
use std::io::{IsTerminal, Write};
use std::sync::atomic::{AtomicBool, Ordering};

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

/// Bytes that the program makes itself, to stdout.
#[cfg(feature = "completions")]
pub fn print_bytes(bytes: &[u8]) {
    let mut out = std::io::stdout().lock();
    let _ = out.write_all(bytes).and_then(|()| out.flush());
}

/// Whether remarks are left out (`--quiet`).
static QUIET: AtomicBool = AtomicBool::new(false);

/// Leaves out remarks from now on, or not.
pub fn quiet(yes: bool) {
    QUIET.store(yes, Ordering::Relaxed);
}

/// Whether remarks are left out.
pub fn is_quiet() -> bool {
    SILENT.get() || QUIET.load(Ordering::Relaxed)
}

/// A remark, to stderr.
pub fn log(text: &str) {
    if !is_quiet() {
        let _ = writeln!(std::io::stderr().lock(), "{}", coloured(&shown(text)));
    }
}

/// Why the run failed or was ended, to stderr, in any case.
pub fn error(text: &str) {
    if !SILENT.get() {
        let _ = writeln!(std::io::stderr().lock(), "{}", coloured(&shown(text)));
    }
}

/// The first word of an error or a warning in its colour, where a person looks on: stderr is a terminal, `NO_COLOR` is not set
/// (no-color.org), and the terminal is not `dumb`.
fn coloured(text: &str) -> Cow<'_, str> {
    let set = |name: &str| std::env::var_os(name).is_some_and(|value| !value.is_empty());
    let dumb = std::env::var_os("TERM").is_some_and(|term| term == "dumb");
    if !std::io::stderr().is_terminal() || set("NO_COLOR") || dumb {
        return text.into();
    }
    marked(text)
}

/// With the codes of the terminal.
fn marked(text: &str) -> Cow<'_, str> {
    for (word, code) in [("error:", "1;31"), ("not met:", "1;31"), ("warning:", "1;33")] {
        if let Some(rest) = text.strip_prefix(word) {
            return format!("\u{1b}[{code}m{word}\u{1b}[0m{rest}").into();
        }
    }
    text.into()
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn first_words_have_colours() {
        assert_eq!(marked("error: a"), "\u{1b}[1;31merror:\u{1b}[0m a");
        assert_eq!(marked("warning: a: error: b"), "\u{1b}[1;33mwarning:\u{1b}[0m a: error: b");
        assert_eq!(marked("wrote a"), "wrote a");
        // Tests have no terminal.
        assert_eq!(coloured("error: a"), "error: a");
    }
}
