//! Ends a run that was interrupted or went beyond its limits: within a tenth of a second, keeping the findings so far, without
//! a half-written file.

use crate::args::Args;
use crate::failure::Failure;
use crate::terminal;
use std::path::PathBuf;
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};
use truepose_io::discard_unfinished;

/// Interval at which limits are checked.
const STEP: Duration = Duration::from_millis(40);
/// As shells have it for a program that was interrupted.
const INTERRUPTED: i32 = 130;
/// A limit that the caller set was reached.
const LIMIT: i32 = 3;

#[derive(Debug, Default)]
struct Progress {
    doing: String,
    found: Vec<String>,
}

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

static KEEP: Mutex<Option<Keep>> = Mutex::new(None);

static SO_FAR: Mutex<Progress> = Mutex::new(Progress { doing: String::new(), found: Vec::new() });

/// Records the current step.
pub fn doing(words: &str) {
    SO_FAR.lock().unwrap_or_else(PoisonError::into_inner).doing = words.to_owned();
}

/// Records a finding.
pub fn found(words: &str) {
    SO_FAR.lock().unwrap_or_else(PoisonError::into_inner).found.push(words.to_owned());
}

/// Sets how the findings so far are written if the run is ended now.
pub fn keep(write: impl FnOnce(&str) -> Kept + Send + 'static) {
    *KEEP.lock().unwrap_or_else(PoisonError::into_inner) = Some(Box::new(write));
}

/// The complete result is about to be written: findings so far are not kept any more.
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
            "--memory-limit: this system does not report the memory that a program uses".into(),
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

/// Shows and writes the findings so far, and ends the program.
fn end(why: &str, began: Instant, json: bool, code: i32) -> ! {
    // Locked until the end, so that the complete result is not written over it meanwhile.
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
            [] => "none".to_owned(),
            found => format!("{} (not yet evaluated on held-out rows)", found.join(", ")),
        };
        terminal::print(&format!(
            "INCOMPLETE: {why} after {seconds:.1} s, while {doing}. Findings so far: {found}.\n{}",
            kept.text
        ));
    }
    let files = match files.is_empty() {
        true => "no file was written".to_owned(),
        false => format!("the findings so far are in {}, marked as incomplete", files.join(" and ")),
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

/// `90s`, `10min`, `2h`.
pub fn parse_time(text: &str) -> Result<Duration, String> {
    let split = text.find(|c: char| c.is_ascii_alphabetic()).unwrap_or(text.len());
    let (number, unit) = text.split_at(split);
    let factor = match unit {
        "s" => 1.0,
        "min" => 60.0,
        "h" => 3600.0,
        _ => return Err("a time needs a unit: s, min or h, as in 10min".into()),
    };
    match number.trim().parse::<f64>() {
        Ok(value) if value > 0.0 && value * factor < 1e9 => Ok(Duration::from_secs_f64(value * factor)),
        _ => Err(format!("`{number}` is no time above 0")),
    }
}

/// `500MB`, `2GB`; bytes.
pub fn parse_memory(text: &str) -> Result<u64, String> {
    let split = text.find(|c: char| c.is_ascii_alphabetic()).unwrap_or(text.len());
    let (number, unit) = text.split_at(split);
    let factor = match unit {
        "MB" => 1e6,
        "GB" => 1e9,
        _ => return Err("a size needs a unit: MB or GB, as in 2GB".into()),
    };
    match number.trim().parse::<f64>() {
        Ok(value) if value > 0.0 && value * factor < 1e18 => Ok((value * factor) as u64),
        _ => Err(format!("`{number}` is no size above 0")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn limits_are_read_with_their_units() {
        assert_eq!(parse_time("1.5min"), Ok(Duration::from_secs(90)));
        assert_eq!(parse_memory("0.5GB"), Ok(500_000_000));
        for bad in ["", "3", "s", "-1s", "nans", "1e30h", "3 weeks"] {
            assert!(parse_time(bad).is_err(), "{bad}");
        }
        for bad in ["", "3", "GB", "-1GB", "1e300MB", "3 bytes"] {
            assert!(parse_memory(bad).is_err(), "{bad}");
        }
    }
}
