//! Ends a run that was interrupted or went beyond its limits: within a tenth of a second, with what was found so far, without
//! a half-written file.

use crate::args::Args;
use crate::failure::Failure;
use crate::terminal;
use std::path::PathBuf;
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};
use truepose_io::discard_unfinished;

/// How often limits are looked at.
const STEP: Duration = Duration::from_millis(40);
/// As shells have it for a program that was interrupted.
const INTERRUPTED: i32 = 130;
/// A limit that the caller set was reached.
const LIMIT: i32 = 3;

#[derive(Debug, Default)]
struct SoFar {
    doing: String,
    found: Vec<String>,
}

/// What was kept of a run that ended before its end.
#[derive(Debug, Default)]
pub struct Kept {
    /// Files that were written.
    pub files: Vec<PathBuf>,
    /// What a person is shown of it; empty where the line about what was found says it all.
    pub text: String,
}

/// Writes what there is, given why the run ends.
type Keep = Box<dyn FnOnce(&str) -> Kept + Send>;

static KEEP: Mutex<Option<Keep>> = Mutex::new(None);

static SO_FAR: Mutex<SoFar> = Mutex::new(SoFar { doing: String::new(), found: Vec::new() });

/// What is going on now.
pub fn doing(words: &str) {
    SO_FAR.lock().unwrap_or_else(PoisonError::into_inner).doing = words.to_owned();
}

/// Something was found.
pub fn found(words: &str) {
    SO_FAR.lock().unwrap_or_else(PoisonError::into_inner).found.push(words.to_owned());
}

/// What to do with what there is, should the run end here.
pub fn keep(write: impl FnOnce(&str) -> Kept + Send + 'static) {
    *KEEP.lock().unwrap_or_else(PoisonError::into_inner) = Some(Box::new(write));
}

/// The whole result is about to be written: what there was before it is not kept any more.
pub fn whole() {
    *KEEP.lock().unwrap_or_else(PoisonError::into_inner) = None;
}

/// Begins to watch.
///
/// # Errors
/// When signals or the memory in use cannot be watched here.
pub fn begin(args: &Args) -> Result<(), Failure> {
    if args.memory_limit.is_some() && resident().is_none() {
        return Err(Failure::Input(
            "--memory-limit: this system does not say how much memory a program uses".into(),
        ));
    }
    let (sender, receiver) = channel();
    ctrlc::set_handler(move || {
        let _ = sender.send(());
    })?;
    let (time, memory) = (args.time_limit, args.memory_limit);
    let json = std::env::args_os().any(|argument| argument == "--json");
    let began = Instant::now();
    std::thread::Builder::new().name("watch".into()).spawn(move || {
        loop {
            match receiver.recv_timeout(STEP) {
                Ok(()) => end("interrupted", began, json, INTERRUPTED),
                Err(RecvTimeoutError::Disconnected) => return,
                Err(RecvTimeoutError::Timeout) => (),
            }
            if time.is_some_and(|limit| began.elapsed() > limit) {
                end("the time limit was reached", began, json, LIMIT);
            }
            if let (Some(limit), Some(used)) = (memory, memory.and_then(|_| resident()))
                && used > limit
            {
                let words = format!("the memory limit was reached ({} MB in use)", used / 1_000_000);
                end(&words, began, json, LIMIT);
            }
        }
    })?;
    Ok(())
}

/// Says what was found so far and ends the program.
fn end(why: &str, began: Instant, json: bool, code: i32) -> ! {
    // Held to the end, so that nobody writes the whole result over it meanwhile.
    let mut keep = KEEP.lock().unwrap_or_else(PoisonError::into_inner);
    let kept = keep.take().map_or_else(Kept::default, |write| write(why));
    discard_unfinished();
    let so_far = SO_FAR.lock().unwrap_or_else(PoisonError::into_inner);
    let seconds = began.elapsed().as_secs_f64();
    let doing = if so_far.doing.is_empty() { "reading" } else { &so_far.doing };
    let files: Vec<String> = kept.files.iter().map(|file| file.display().to_string()).collect();
    if json {
        let value = serde_json::json!({
            "incomplete": true, "why": why, "seconds": seconds, "while": doing, "found_so_far": so_far.found,
            "files": files,
        });
        terminal::print(&format!("{value:#}\n"));
    } else {
        let found = match so_far.found.as_slice() {
            [] => "nothing yet".to_owned(),
            found => format!("{} (not yet judged on held-out rows)", found.join(", ")),
        };
        terminal::print(&format!(
            "INCOMPLETE: {why} after {seconds:.1} s, while {doing}. Found so far: {found}.\n{}",
            kept.text
        ));
    }
    let files = match files.is_empty() {
        true => "no file was written".to_owned(),
        false => format!("what was found so far is in {}, marked as incomplete", files.join(" and ")),
    };
    terminal::log(&format!("error: {why}; {files}"));
    std::process::exit(code)
}

/// Memory in use, bytes.
fn resident() -> Option<u64> {
    let status = std::fs::read_to_string(PathBuf::from("/proc/self/status")).ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix("VmRSS:"))?;
    line.trim().strip_suffix("kB")?.trim().parse::<u64>().ok().map(|kilobytes| 1024 * kilobytes)
}
