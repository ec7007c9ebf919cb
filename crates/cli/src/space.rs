//! The address space that the system grants to the program (`ulimit -v`). An allocation beyond it ends a program at once, without a word:
//! too little is refused before the run, and a run that comes near it is ended as by `--memory-limit`.

use crate::failure::Failure;

/// Reserved by a run on one thread before its data, bytes. Measured on a small fit: 350 MB are too little, 450 MB are enough.
const BASE: u64 = 512 << 20;
/// Reserved by each thread: its stack, and the 64 MB of address space that the system's allocator takes for it. Measured: 16 threads need
/// between 1.0 and 1.4 GB.
const PER_THREAD: u64 = 72 << 20;
/// Left free: one reservation of the allocator and one work space of the matrix kernels, 64 MB each.
const MARGIN: u64 = 128 << 20;

/// Address space up to which a run may go, bytes; none where it is not limited.
///
/// # Errors
/// When it is too little for a run on so many threads.
pub fn granted(threads: usize) -> Result<Option<u64>, Failure> {
    let Some(limit) = limit() else { return Ok(None) };
    let needed = BASE + PER_THREAD * threads as u64;
    if limit < needed {
        let (limit, needed) = (limit / 1_000_000, needed.div_ceil(1_000_000));
        return Err(Failure::Input(format!(
            "the address space is limited to {limit} MB (ulimit -v), and {needed} MB are needed with {threads} threads: raise the limit, or use fewer --threads"
        )));
    }
    Ok(Some(limit - MARGIN))
}

/// Bytes; none where the system has no limit, or does not report it.
fn limit() -> Option<u64> {
    let limits = std::fs::read_to_string("/proc/self/limits").ok()?;
    let line = limits.lines().find_map(|line| line.strip_prefix("Max address space"))?;
    line.split_whitespace().next()?.parse().ok()
}

/// A figure of `/proc/self/status`, bytes.
pub fn in_use(name: &str) -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix(name)?.strip_prefix(':'))?;
    line.trim().strip_suffix("kB")?.trim().parse::<u64>().ok().map(|kilobytes| 1024 * kilobytes)
}
