//! Where to begin when the caller does not say: configurations spread over the joints' ranges, the nearest first.
//!
//! ```text
//! q_k = lower + (upper − lower) · Halton_k(i)          i = 1 … , base the k-th prime
//! distance² = |p − p_d|²/L² + |R − R_d|²_F / 2
//! ```
//!
//! The table is made once, for the nominal robot; the same model always has the same starts. Source: Halton 1960.

use crate::arm::{Arm, Reached};
use crate::command::MOST;
use crate::step::Limits;
use crate::task::Task;
use nalgebra::Vector3;
use std::f64::consts::PI;
use truepose_kinematics::{Chain, Pose, sin_cos};

/// Configurations in the table.
const COUNT: usize = 384;
/// Most starts that are handed out.
pub(crate) const MOST_STARTS: usize = 256;

const PRIMES: [u64; MOST] = [2, 3, 5, 7, 11, 13, 17, 19, 23, 29, 31, 37, 41, 43, 47, 53];

/// The table.
#[derive(Debug, Clone)]
pub(crate) struct Starts {
    configurations: Vec<([f64; MOST], Pose)>,
}

/// The nearest starts to a task, in order.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Nearest {
    list: [(f64, usize); MOST_STARTS],
    len: usize,
}

impl Starts {
    /// For this robot; x in units of the search.
    pub fn new(chain: &Chain, arm: &Arm, limits: &Limits, scale: &[f64; MOST]) -> Self {
        let mut at = Reached::nowhere();
        let n = arm.joints();
        // Joints without limits: a turn either way, a characteristic length either way; no more of those with many.
        let range = |k: usize| {
            let widest = if arm.slides(k) { 1.0 } else { PI };
            let (lower, upper) = (limits.lower[k], limits.upper[k]);
            let middle = match (lower.is_finite(), upper.is_finite()) {
                (true, true) => 0.5 * (lower + upper),
                (true, false) => lower + widest,
                (false, true) => upper - widest,
                (false, false) => 0.0,
            };
            let turn = if arm.slides(k) { f64::INFINITY } else { widest };
            let reach =
                (0.5 * (upper - lower)).min(if upper - lower < f64::INFINITY { turn } else { widest });
            (middle - reach, middle + reach)
        };
        let configurations = (0..COUNT as u64)
            .map(|i| {
                let mut x = [0.0; MOST];
                for (k, value) in x.iter_mut().enumerate().take(n) {
                    let (lower, upper) = range(k);
                    // The first one is the middle of every range.
                    let share = if i == 0 { 0.5 } else { halton(i + 20, PRIMES[k]) };
                    *value = lower + (upper - lower) * share;
                }
                let mut q = [0.0; MOST];
                (0..n).for_each(|k| q[k] = x[k] * scale[k]);
                chain.follow(&mut q);
                chain.followers().iter().for_each(|f| x[f.joint] = q[f.joint] / scale[f.joint]);
                arm.reach(&q, &q.map(sin_cos), &[], &mut at);
                (x, at.tool)
            })
            .collect();
        Starts { configurations }
    }

    /// The nearest to a task, for a point of the tool.
    pub fn nearest(&self, task: &Task, point: &Vector3<f64>, count: usize) -> Nearest {
        let count = count.min(MOST_STARTS).min(self.configurations.len());
        let mut nearest = Nearest { list: [(f64::INFINITY, 0); MOST_STARTS], len: count };
        let per_length = 1.0 / (task.length * task.length);
        for (index, (_, tool)) in self.configurations.iter().enumerate() {
            let mut distance = (tool.apply(point) - task.position).norm_squared() * per_length;
            if let Some(wanted) = &task.rotation {
                distance += 0.5 * (tool.rotation - wanted).norm_squared();
            }
            // Insertion into the few best so far.
            let mut place = count;
            while place > 0 && distance < nearest.list[place - 1].0 {
                place -= 1;
            }
            if place < count {
                nearest.list.copy_within(place..count - 1, place + 1);
                nearest.list[place] = (distance, index);
            }
        }
        nearest
    }

    /// The middle of every range.
    pub fn middle(&self) -> [f64; MOST] {
        self.configurations.first().map_or([0.0; MOST], |(x, _)| *x)
    }

    /// The k-th start: in turn one of the nearest and one from anywhere, so that no posture is left out.
    pub fn start(&self, nearest: &Nearest, k: usize) -> Option<&[f64; MOST]> {
        if k >= nearest.len {
            return None;
        }
        let index = if k.is_multiple_of(2) { nearest.list[k / 2].1 } else { 1 + k / 2 };
        self.configurations.get(index).map(|(x, _)| x)
    }
}

fn halton(mut i: u64, base: u64) -> f64 {
    let (mut share, mut digit) = (0.0, 1.0);
    while i > 0 {
        digit /= base as f64;
        share += digit * (i % base) as f64;
        i /= base;
    }
    share
}
