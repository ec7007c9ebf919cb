//! Watches a run from the main thread: ends it within a tenth of a second when it was interrupted or went beyond its limits, keeping
//! the findings so far, without a half-written file.

use crate::failure::Failure;
use crate::space::in_use;
use crate::terminal;
use std::path::PathBuf;
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};
use truepose_io::stop_writing;

/// Interval at which limits are checked.
const STEP: Duration = Duration::from_millis(40);
/// As shells have it for a program that was interrupted.
const INTERRUPTED: u8 = 130;
/// A limit that the caller set was reached.
const LIMIT: u8 = 3;
/// As Rust has it for a program that panicked.
const PANICKED: u8 = 101;
/// Stack of the working thread, bytes: as much as Linux gives to a main thread.
const STACK: usize = 8 << 20;

/// What is kept of a run that was ended early.
#[derive(Debug, Default)]
pub struct Kept {
    /// Files that were written.
    pub files: Vec<PathBuf>,
    /// Text for the terminal, besides the line about the findings; may be empty.
    pub text: String,
}

/// Writes what there is, given why the run ends.
type Keep = Box<dyn FnOnce(&str) -> Kept + Send>;

#[derive(Default)]
struct Status {
    doing: String,
    found: Vec<String>,
    keep: Option<Keep>,
    ended: bool,
}

/// Status of a run: written by the working thread, read by the main thread.
#[derive(Clone, Default)]
pub struct Watch(Arc<Mutex<Status>>);

impl Watch {
    /// Records the current step.
    pub fn doing(&self, words: &str) {
        self.status().doing = words.to_owned();
    }

    /// Records a finding.
    pub fn found(&self, names: Vec<String>) {
        self.status().found = names;
    }

    /// Sets how the findings so far are written if the run is ended now.
    pub fn keep(&self, write: impl FnOnce(&str) -> Kept + Send + 'static) {
        self.status().keep = Some(Box::new(write));
    }

    /// The complete result is about to be written: findings so far are not kept any more.
    pub fn whole(&self) {
        self.status().keep = None;
    }

    /// For the working thread, which stops here once the run was ended.
    fn status(&self) -> MutexGuard<'_, Status> {
        let status = self.locked();
        if status.ended {
            drop(status);
            loop {
                std::thread::park();
            }
        }
        status
    }

    fn locked(&self) -> MutexGuard<'_, Status> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// Limits of a run.
#[derive(Debug, Clone, Copy)]
pub struct Limits {
    /// Wall-clock time.
    pub time: Option<Duration>,
    /// Memory in use, bytes.
    pub memory: Option<u64>,
    /// Address space, bytes: what the system grants.
    pub space: Option<u64>,
}

/// Events that the main thread receives.
enum Event {
    Interrupted,
    Done(Result<(), Failure>),
}

/// Runs `work` on a thread of its own until it is done or the run is ended; the exit code of the program.
///
/// # Errors
/// Those of the work; and when signals or the memory in use cannot be watched here.
pub fn watched(
    limits: Limits,
    work: impl FnOnce(&Watch) -> Result<(), Failure> + Send + 'static,
) -> Result<u8, Failure> {
    if limits.memory.is_some() && in_use("VmRSS").is_none() {
        return Err(Failure::Input(
            "--memory-limit: this system does not report the memory that a program uses".into(),
        ));
    }
    let (sender, receiver) = channel();
    let interrupt = sender.clone();
    ctrlc::set_handler(move || {
        let _ = interrupt.send(Event::Interrupted);
    })?;
    let watch = Watch::default();
    let working = watch.clone();
    let began = Instant::now();
    // Not joined where the run ends early: it ends with the program.
    let worker = std::thread::Builder::new().name("work".into()).stack_size(STACK).spawn(move || {
        let _ = sender.send(Event::Done(work(&working)));
    })?;
    loop {
        match receiver.recv_timeout(STEP) {
            Ok(Event::Done(done)) => return done.map(|()| 0),
            Ok(Event::Interrupted) => return Ok(ended(&watch, "interrupted", began, INTERRUPTED)),
            // The handler of signals holds a sender for ever: a thread that panicked sends nothing.
            Err(RecvTimeoutError::Disconnected) => return Ok(PANICKED),
            Err(RecvTimeoutError::Timeout) if worker.is_finished() => {
                // What it sent in its last moment is there by now.
                return match receiver.try_recv() {
                    Ok(Event::Done(done)) => done.map(|()| 0),
                    _ => Ok(PANICKED),
                };
            }
            Err(RecvTimeoutError::Timeout) => (),
        }
        if limits.time.is_some_and(|limit| began.elapsed() > limit) {
            return Ok(ended(&watch, "the time limit was reached", began, LIMIT));
        }
        if let (Some(limit), Some(used)) = (limits.memory, limits.memory.and_then(|_| in_use("VmRSS")))
            && used > limit
        {
            let words = format!("the memory limit was reached ({} MB in use)", used / 1_000_000);
            return Ok(ended(&watch, &words, began, LIMIT));
        }
        if limits.space.is_some_and(|limit| in_use("VmSize").is_some_and(|used| used > limit)) {
            let words = "the address space that the system grants was used up (ulimit -v)";
            return Ok(ended(&watch, words, began, LIMIT));
        }
    }
}

/// Shows and writes the findings so far. The program has to end now: the working thread stops at its next report, and cannot write any
/// file.
fn ended(watch: &Watch, why: &str, began: Instant, code: u8) -> u8 {
    let json = crate::typed::arguments().into_iter().any(|argument| argument == "--json");
    let mut status = watch.locked();
    let kept = status.keep.take().map_or_else(Kept::default, |write| write(why));
    let written = stop_writing();
    status.ended = true;
    let seconds = began.elapsed().as_secs_f64();
    let doing = if status.doing.is_empty() { "reading" } else { &status.doing };
    let files: Vec<String> = kept.files.iter().map(|file| file.display().to_string()).collect();
    if json {
        let value = serde_json::json!({
            "incomplete": true, "why": why, "seconds": seconds, "while": doing, "found_so_far": status.found,
            "files": files,
        });
        terminal::print(&format!("{value:#}\n"));
    } else {
        let found = match status.found.as_slice() {
            // The result itself follows.
            _ if !kept.text.is_empty() => String::new(),
            [] => " Findings so far: none.".to_owned(),
            found => {
                format!(" Findings so far: {} (not yet evaluated on held-out rows).", found.join(", "))
            }
        };
        terminal::print(&format!(
            "INCOMPLETE: {why} after {seconds:.1} s, while {doing}.{found}\n{}",
            kept.text
        ));
    }
    // What was finished before, if the end came between the last file and the end of the run.
    let written: Vec<String> = written.iter().map(|file| file.display().to_string()).collect();
    let files = match (files.is_empty(), written.is_empty()) {
        (true, true) => "no file was written".to_owned(),
        (true, false) => format!("complete, and written before: {}", written.join(", ")),
        (false, _) => format!("the findings so far are in {}, marked as incomplete", files.join(" and ")),
    };
    terminal::error(&format!("error: {why}; {files}"));
    code
}
