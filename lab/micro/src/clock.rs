//! Time of a process and of a thread, memory, load; what the system does not report is NaN or zero.

use rustix::time::{ClockId, clock_gettime};
use std::time::Instant;

/// How long this process has run on all of its threads, s.
pub fn process() -> f64 {
    let now = clock_gettime(ClockId::ProcessCPUTime);
    now.tv_sec as f64 + 1e-9 * now.tv_nsec as f64
}

/// Seconds of this process and on the wall that some work takes, and what comes of it.
pub fn timed<T>(work: impl FnOnce() -> T) -> (f64, f64, T) {
    let (start, began) = (process(), Instant::now());
    let made = work();
    (process() - start, began.elapsed().as_secs_f64(), made)
}

/// Seconds of this thread where the system reports them, else on the wall, that some work takes, and what comes of it.
pub fn timed_on_thread<T>(work: impl FnOnce() -> T) -> (f64, T) {
    let (ran, began) = (thread(), Instant::now());
    let made = work();
    let wall = began.elapsed().as_secs_f64();
    (ran.zip(thread()).map_or(wall, |(then, now)| now - then), made)
}

/// For how long this thread has run, s; none where the system does not report it.
fn thread() -> Option<f64> {
    let text = std::fs::read_to_string("/proc/thread-self/schedstat").ok()?;
    let nanoseconds: f64 = text.split_whitespace().next()?.parse().ok()?;
    Some(1e-9 * nanoseconds)
}

/// A line of /proc/self/status in MB; zero where the system does not tell.
pub fn memory_mb(line: &str) -> f64 {
    let text = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let found =
        text.lines().find_map(|l| l.strip_prefix(line)?.split_whitespace().next()?.parse::<f64>().ok());
    found.unwrap_or(0.0) / 1024.0
}

/// The system's load over the last minute.
pub fn load() -> f64 {
    let text = std::fs::read_to_string("/proc/loadavg").unwrap_or_default();
    text.split_whitespace().next().and_then(|w| w.parse().ok()).unwrap_or(f64::NAN)
}

/// The processor's name.
pub fn processor() -> String {
    let text = std::fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let line = text.lines().find_map(|l| l.strip_prefix("model name")?.split_once(':'));
    line.map_or_else(|| "unknown".into(), |(_, name)| name.trim().to_string())
}
