//! Standstills of a robot in two streams, each with a time of its own.
//!
//! A standstill is where no joint moves by more than `still` within a fifth of `dwell`, and none by more than five times that in all; it
//! lasts `dwell` at least. Samples may be missing: a gap of ten sampling intervals is no standstill.

use super::lag::lag;
use super::streams::{Streams, median_step};

/// Standstills, and the lag of the positions.
#[derive(Debug, Clone, PartialEq)]
pub struct Standstills {
    /// First and last joint sample of each.
    pub samples: Vec<[usize; 2]>,
    /// By how much the clock of the positions is late, s, and the correlation of the two speeds at that lag.
    pub lag: (f64, f64),
}

/// Part of the dwell within which no joint moves by more than the tolerance, on each side of a sample.
const WINDOW: f64 = 0.1;
/// Times the tolerance by which a joint may creep in a whole standstill.
const CREEP: f64 = 5.0;
/// Sampling intervals that are a gap.
const GAP: f64 = 10.0;

impl Streams<'_> {
    /// Standstills of `dwell` seconds or longer; `still`: tolerance of each joint, rad or m.
    pub fn standstills(&self, still: &[f64], dwell: f64) -> Standstills {
        Standstills { samples: self.still(still, dwell), lag: lag(self) }
    }

    fn still(&self, still: &[f64], dwell: f64) -> Vec<[usize; 2]> {
        let t = self.joint_times;
        if t.len() < 3 {
            return Vec::new();
        }
        let step = median_step(t);
        let half = ((WINDOW * dwell / step.max(1e-9)).round() as usize).clamp(1, t.len());
        let mut calm = vec![true; t.len()];
        for (column, &tolerance) in self.joints.iter().zip(still) {
            for (k, calm) in calm.iter_mut().enumerate().filter(|(_, calm)| **calm) {
                let window = &column[k.saturating_sub(half)..(k + half + 1).min(t.len())];
                let ends = window
                    .iter()
                    .fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], &v| [low.min(v), high.max(v)]);
                *calm = ends[1] - ends[0] <= tolerance;
            }
        }
        let near = |k: usize, first: usize| {
            let creeps = |(column, tolerance): (&Vec<f64>, &f64)| {
                (column[k] - column[first]).abs() > CREEP * tolerance
            };
            t[k] - t[k - 1] <= GAP * step && !self.joints.iter().zip(still).any(creeps)
        };
        let mut found = Vec::new();
        let mut first = None;
        for k in 0..=t.len() {
            let begun = first.filter(|&first| !(k < t.len() && calm[k] && near(k, first)));
            if let Some(begun) = begun {
                if t[k - 1] - t[begun] >= dwell {
                    found.push([begun, k - 1]);
                }
                first = None;
            }
            if first.is_none() && k < t.len() && calm[k] {
                first = Some(k);
            }
        }
        found
    }
}
