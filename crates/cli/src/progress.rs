//! What is going on, on stderr: a bar where a person looks on, else a line now and then.

use crate::terminal;
use crate::watch::Watch;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use std::io::IsTerminal;
use std::ops::ControlFlow;
use std::sync::Mutex;
use std::time::{Duration, Instant};
use truepose_workflow::{Interim, Observer};

/// Seconds between two lines where stderr is no terminal: a short run writes none.
const LINES: f64 = 30.0;

/// A bar with a word; lines when stderr is no terminal; nothing with `--quiet`.
pub struct Progress {
    bar: ProgressBar,
    watch: Watch,
    /// When the run began, and after how many seconds the next line is due.
    lines: Mutex<(Instant, f64)>,
}

impl Progress {
    /// With this many steps.
    pub fn steps(count: usize, watch: &Watch) -> Self {
        let bar = ProgressBar::with_draw_target(Some(count as u64), target());
        if let Ok(style) = ProgressStyle::with_template("{spinner} [{bar:24}] {msg} {elapsed}") {
            bar.set_style(style.progress_chars("━╸ "));
        }
        bar.enable_steady_tick(Duration::from_millis(120));
        Progress { bar, watch: watch.clone(), lines: lines() }
    }

    /// Through so many bytes.
    pub fn bytes(count: u64, watch: &Watch) -> Self {
        let bar = ProgressBar::with_draw_target(Some(count), target());
        let template = "{spinner} [{bar:24}] {msg} {bytes} of {total_bytes}, {bytes_per_sec}, {eta} left";
        if let Ok(style) = ProgressStyle::with_template(template) {
            bar.set_style(style.progress_chars("━╸ "));
        }
        bar.enable_steady_tick(Duration::from_millis(120));
        Progress { bar, watch: watch.clone(), lines: lines() }
    }

    /// So many of them have been read.
    pub fn at(&self, bytes: u64) {
        self.bar.set_position(bytes);
    }

    /// Of which nobody knows how many steps there are.
    pub fn spinner(watch: &Watch) -> Self {
        let bar = ProgressBar::with_draw_target(None, target());
        if let Ok(style) = ProgressStyle::with_template("{spinner} {msg} {elapsed}") {
            bar.set_style(style);
        }
        bar.enable_steady_tick(Duration::from_millis(120));
        Progress { bar, watch: watch.clone(), lines: lines() }
    }

    /// Shows the current step.
    pub fn show(&self, word: &str) {
        self.line(word);
        self.watch.doing(word);
        self.bar.set_message(word.to_string());
    }

    /// The next step begins.
    pub fn begin(&self, word: &str) {
        self.line(word);
        self.watch.doing(word);
        self.bar.set_message(word.to_string());
        self.bar.inc(1);
    }
}

/// Shows steps and remarks of a run at the terminal.
pub struct Shown<'a> {
    progress: Progress,
    interim: Option<&'a (dyn Fn(Interim) + Sync)>,
}

impl<'a> Shown<'a> {
    /// With this bar.
    pub fn new(progress: Progress) -> Self {
        Shown { progress, interim: None }
    }

    /// With this for what a search has found so far.
    pub fn with_interim(self, interim: &'a (dyn Fn(Interim) + Sync)) -> Self {
        Shown { interim: Some(interim), ..self }
    }
}

impl Observer for Shown<'_> {
    fn step(&self, words: &str) -> ControlFlow<()> {
        self.progress.begin(words);
        ControlFlow::Continue(())
    }

    fn remark(&self, words: &str) {
        self.progress.bar.suspend(|| terminal::warn(&[words]));
    }

    fn interim(&self, so_far: Interim) -> ControlFlow<()> {
        if let Some(keep) = self.interim {
            keep(so_far);
        }
        ControlFlow::Continue(())
    }
}

impl Progress {
    /// Writes a line if one is due.
    fn line(&self, word: &str) {
        if std::io::stderr().is_terminal() {
            return;
        }
        let Ok(mut lines) = self.lines.lock() else { return };
        let elapsed = lines.0.elapsed().as_secs_f64();
        if elapsed >= lines.1 {
            lines.1 = elapsed + LINES;
            terminal::log(&format!("[{elapsed:.0} s] {word}"));
        }
    }
}

fn lines() -> Mutex<(Instant, f64)> {
    Mutex::new((Instant::now(), LINES))
}

fn target() -> ProgressDrawTarget {
    if terminal::is_quiet() { ProgressDrawTarget::hidden() } else { ProgressDrawTarget::stderr() }
}

impl Drop for Progress {
    fn drop(&mut self) {
        self.bar.finish_and_clear();
    }
}
