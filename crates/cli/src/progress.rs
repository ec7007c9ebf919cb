//! What is going on, on stderr, when a person looks on.

use crate::watch::Watch;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use std::time::Duration;

/// A bar with a word; silent when stderr is no terminal.
pub struct Progress {
    bar: ProgressBar,
    watch: Watch,
}

impl Progress {
    /// With this many steps.
    pub fn steps(count: usize, watch: &Watch) -> Self {
        let bar = ProgressBar::with_draw_target(Some(count as u64), ProgressDrawTarget::stderr());
        if let Ok(style) = ProgressStyle::with_template("{spinner} [{bar:24}] {msg} {elapsed}") {
            bar.set_style(style.progress_chars("━╸ "));
        }
        bar.enable_steady_tick(Duration::from_millis(120));
        Progress { bar, watch: watch.clone() }
    }

    /// Through so many bytes.
    pub fn bytes(count: u64, watch: &Watch) -> Self {
        let bar = ProgressBar::with_draw_target(Some(count), ProgressDrawTarget::stderr());
        let template = "{spinner} [{bar:24}] {msg} {bytes} of {total_bytes}, {bytes_per_sec}, {eta} left";
        if let Ok(style) = ProgressStyle::with_template(template) {
            bar.set_style(style.progress_chars("━╸ "));
        }
        bar.enable_steady_tick(Duration::from_millis(120));
        Progress { bar, watch: watch.clone() }
    }

    /// So many of them have been read.
    pub fn at(&self, bytes: u64) {
        self.bar.set_position(bytes);
    }

    /// Of which nobody knows how many steps there are.
    pub fn spinner(watch: &Watch) -> Self {
        let bar = ProgressBar::with_draw_target(None, ProgressDrawTarget::stderr());
        if let Ok(style) = ProgressStyle::with_template("{spinner} {msg} {elapsed}") {
            bar.set_style(style);
        }
        bar.enable_steady_tick(Duration::from_millis(120));
        Progress { bar, watch: watch.clone() }
    }

    /// Shows the current step.
    pub fn show(&self, word: &str) {
        self.watch.doing(word);
        self.bar.set_message(word.to_string());
    }

    /// The next step begins.
    pub fn begin(&self, word: &str) {
        self.watch.doing(word);
        self.bar.set_message(word.to_string());
        self.bar.inc(1);
    }
}

impl Drop for Progress {
    fn drop(&mut self) {
        self.bar.finish_and_clear();
    }
}
