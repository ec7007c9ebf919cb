//! Joints and positions over time, each with a time of its own.

/// Joints and positions over time, s.
#[derive(Debug, Clone, Copy)]
pub struct Streams<'a> {
    /// When the joints were sampled, ascending.
    pub joint_times: &'a [f64],
    /// One column for each joint, rad or m.
    pub joints: &'a [Vec<f64>],
    /// When the positions were sampled, ascending.
    pub position_times: &'a [f64],
    /// m.
    pub positions: &'a [[f64; 3]],
}

/// The middle sampling interval, s; 0 of fewer than two samples.
pub(super) fn median_step(times: &[f64]) -> f64 {
    let mut steps: Vec<f64> = times.windows(2).map(|pair| pair[1] - pair[0]).collect();
    if steps.is_empty() {
        return 0.0;
    }
    let middle = steps.len() / 2;
    *steps.select_nth_unstable_by(middle, f64::total_cmp).1
}
