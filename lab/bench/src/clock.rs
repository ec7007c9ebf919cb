//! Process CPU time, wall time and peak memory.

use rustix::time::{ClockId, clock_gettime};
use std::time::Instant;

/// How long this process has run on all of its threads, s.
pub fn cpu() -> f64 {
    let now = clock_gettime(ClockId::ProcessCPUTime);
    now.tv_sec as f64 + 1e-9 * now.tv_nsec as f64
}

/// Seconds of CPU and of wall that some work takes, and what comes of it.
pub fn timed<T>(work: impl FnOnce() -> T) -> (f64, f64, T) {
    let (start, began) = (cpu(), Instant::now());
    let made = work();
    (cpu() - start, began.elapsed().as_secs_f64(), made)
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

/// Prints the processor, the threads, and the load then and now.
pub fn say_machine(threads: &str, before: f64) {
    let (processor, after) = (processor(), load());
    crate::say(&format!("{processor}, {threads}; load {before:.1} at the beginning, {after:.1} at the end"));
}
