//! CPU time of this process.

use rustix::time::{ClockId, clock_gettime};
use std::time::Instant;
pub use truepose_micro::clock::{load, memory_mb, processor};

/// How long this process has run on all of its threads, s.
fn cpu() -> f64 {
    let now = clock_gettime(ClockId::ProcessCPUTime);
    now.tv_sec as f64 + 1e-9 * now.tv_nsec as f64
}

/// Seconds of CPU and of wall that some work takes, and what comes of it.
pub fn timed<T>(work: impl FnOnce() -> T) -> (f64, f64, T) {
    let (start, began) = (cpu(), Instant::now());
    let made = work();
    (cpu() - start, began.elapsed().as_secs_f64(), made)
}
