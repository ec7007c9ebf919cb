//! Time of a computation: CPU time of one thread, or wall time of all threads.

use crate::prelude::*;
use truepose_micro::clock::timed_on_thread;

/// Least of some runs of this work on one thread, in seconds of that thread; on the wall where the system does not report it.
pub fn least<T: Send>(runs: usize, work: impl Fn() -> Outcome<T> + Sync) -> Outcome<f64> {
    let one = rayon::ThreadPoolBuilder::new().num_threads(1).build()?;
    let timed = |_| {
        let (seconds, done) = timed_on_thread(&work);
        done.map(|_| seconds)
    };
    let times: Vec<f64> = one.install(|| (0..runs.max(1)).map(timed).collect::<Outcome<_>>())?;
    Ok(times.into_iter().fold(f64::INFINITY, f64::min))
}

/// Least of some runs of this work on all threads, in seconds on the wall.
pub fn least_on_the_wall<T>(runs: usize, work: impl Fn() -> Outcome<T>) -> Outcome<f64> {
    let timed = |_| {
        let begun = Instant::now();
        work().map(|_| begun.elapsed().as_secs_f64())
    };
    (0..runs.max(1)).map(timed).try_fold(f64::INFINITY, |least, time| Ok(least.min(time?)))
}
