//! Down to a pose from one start: Levenberg and Marquardt far away, Newton near the end.
//!
//! ```text
//! x ← x + J⁻¹ e                     |e|² below `NEAR`, regular, and while each round reduces it by a factor of four
//! x ← x + J_s⁻¹ e                   after a step s of Newton's after which its J_s is expected to suffice once more
//! x ← x + Jᵀ(J Jᵀ + μ I)⁻¹ e         else, with μ = s (|e|²/2 + w); s adapts to whether the step helped
//! ```
//!
//! | symbol | here | unit |
//! | --- | --- | --- |
//! | x | `Walk::x` | rad, characteristic lengths of travel |
//! | e | [`Gap::error`] | 1 |
//! | w | `BIAS` | 1 |
//!
//! J are the joints' own axes on the robot that is evaluated; how its errors change with the joints is left out of J and
//! is in e, so that on the exact model this is a quasi-Newton iteration that gains two to three digits per iteration.
//! Source: Sugihara 2011 (damping by |e|², which needs no knowledge of whether the pose can be reached).

use crate::arm::Reached;
use crate::command::MOST;
use crate::step::{Factors, Limits, Linear};
use crate::task::{Columns, Gap, Task};
use nalgebra::Vector3;
use truepose_kinematics::{Chain, sin_cos};

/// Something with joints that can be sent to x.
pub(crate) trait Robot {
    /// Evaluates it there: e.
    fn send(&mut self, x: &[f64; MOST], task: &Task) -> Gap;
    /// J where it was evaluated last.
    fn columns(&self, task: &Task, columns: &mut Columns);
    /// How many joints.
    fn joints(&self) -> usize;
}

/// How a walk ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Ending {
    /// Within the tolerances.
    There,
    /// No step brings it nearer.
    Stuck,
    /// The iterations are exhausted, or the model gave a value that is not finite.
    GaveUp,
}

/// Where a walk ended.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Walk {
    pub x: [f64; MOST],
    pub gap: Gap,
    pub ending: Ending,
    pub rounds: usize,
}

impl Walk {
    pub fn nowhere() -> Self {
        Walk { x: [0.0; MOST], gap: Gap::nowhere(), ending: Ending::GaveUp, rounds: 0 }
    }
}

/// |e|² from which Newton's step is tried.
pub(crate) const NEAR: f64 = 2e-3;
const BIAS: f64 = 1e-8;
/// A walk whose |e|² fell by less than a hundredth in so many iterations is at the edge of what can be reached.
const CHECK: usize = 10;

/// Walks from x until the error vanishes, no step improves it, or the iterations are exhausted.
pub(crate) fn walk(
    robot: &mut impl Robot,
    task: &Task,
    start: &[f64; MOST],
    limits: &Limits,
    most: usize,
) -> Walk {
    let n = robot.joints();
    let mut here = Walk { x: *start, gap: robot.send(start, task), ending: Ending::GaveUp, rounds: 1 };
    let mut columns: Columns = [[0.0; 6]; MOST];
    // Whether the robot stands at `here`, and whether J is that of `here`.
    let (mut stands, mut fresh) = (true, false);
    // The factors of the last step, if it was Newton's, and its length.
    let mut last: Option<(Factors, f64)> = None;
    let (mut trust, mut newton, mut idle) = (1.0, true, 0);
    let (mut checked, mut crawls) = (f64::INFINITY, false);
    while here.gap.cost.is_finite() {
        if task.reached(&here.gap) {
            here.ending = Ending::There;
            break;
        }
        if idle >= 6 || trust > 1e12 {
            here.ending = Ending::Stuck;
            break;
        }
        if here.rounds >= most {
            here.ending = if crawls { Ending::Stuck } else { Ending::GaveUp };
            break;
        }
        if here.rounds.is_multiple_of(CHECK) {
            crawls = here.gap.cost > 0.99 * checked;
            checked = here.gap.cost;
        }
        let near = here.gap.cost < NEAR && newton;
        let chord = last.take().filter(|(_, length)| task.foretells(&here.gap, *length));
        let repeated = chord.and_then(|(factors, _)| factors.step(&here.gap.error, &here.x, limits));
        let step = repeated.unwrap_or_else(|| {
            if !fresh {
                if !stands {
                    robot.send(&here.x, task);
                    here.rounds += 1;
                }
                robot.columns(task, &mut columns);
                fresh = true;
            }
            let linear = Linear { columns: &columns[..n], error: &here.gap.error, rows: task.rows() };
            let factors = if near { linear.factors() } else { None };
            let quick = factors.and_then(|factors| factors.step(&here.gap.error, &here.x, limits));
            if let (Some(factors), Some(step)) = (factors, quick) {
                last = Some((factors, step[..n].iter().fold(0.0, |m: f64, s| m.max(s.abs()))));
            }
            quick.unwrap_or_else(|| {
                let damping = if near { 1e-13 } else { trust * (0.5 * here.gap.cost + BIAS) };
                linear.damped(&here.x, limits, damping)
            })
        });
        let mut x = here.x;
        for k in 0..n {
            x[k] = (x[k] + step[k]).clamp(limits.lower[k], limits.upper[k]);
        }
        let next = robot.send(&x, task);
        here.rounds += 1;
        let (before, after) = (here.gap.cost, next.cost);
        stands = after < before;
        if stands {
            here.x = x;
            here.gap = next;
            fresh = false;
            if near {
                newton = after < 0.25 * before;
            } else {
                trust = f64::max(trust * if after < 0.5 * before { 0.2 } else { 0.6 }, 1e-9);
                newton = newton || after < 0.01 * before;
            }
            idle = if after > before * (1.0 - 1e-7) { idle + 1 } else { 0 };
        } else {
            last = None;
            if repeated.is_some() {
                // Another step from here takes the J from here.
            } else if near {
                newton = false;
            } else {
                trust *= 8.0;
            }
        }
    }
    here
}

impl Gap {
    pub fn nowhere() -> Self {
        Gap { error: [0.0; 6], cost: f64::INFINITY }
    }
}

/// Columns of joints that follow others become part of those of their drivers: they have no step of their own.
pub(crate) fn with_followers(chain: &Chain, scale: &[f64; MOST], columns: &mut Columns) {
    for follower in chain.followers() {
        let own = std::mem::take(&mut columns[follower.joint]);
        let factor = follower.ratio * scale[follower.driver] / scale[follower.joint];
        columns[follower.driver].iter_mut().zip(own).for_each(|(j, own)| *j += factor * own);
    }
}

/// Joints that stay move nothing.
pub(crate) fn held(stays: &[bool; MOST], columns: &mut Columns) {
    columns.iter_mut().zip(stays).filter(|(_, stays)| **stays).for_each(|(column, _)| *column = [0.0; 6]);
}

/// The nominal robot, for starts.
pub(crate) struct NominalArm<'a> {
    pub arm: &'a crate::arm::Arm,
    pub point: Vector3<f64>,
    pub scale: &'a [f64; MOST],
    pub chain: &'a Chain,
    pub at: &'a mut Reached,
    pub stays: &'a [bool; MOST],
}

impl Robot for NominalArm<'_> {
    fn send(&mut self, x: &[f64; MOST], task: &Task) -> Gap {
        let mut q = [0.0; MOST];
        q.iter_mut().zip(x).zip(self.scale).for_each(|((q, x), scale)| *q = x * scale);
        self.chain.follow(&mut q);
        let n = self.arm.joints();
        let mut turns = [(0.0, 1.0); MOST];
        turns[..n].iter_mut().zip(&q).for_each(|(turn, &q)| *turn = sin_cos(q));
        self.arm.reach(&q, &turns, &[], self.at);
        task.gap(self.at, &self.point)
    }

    fn columns(&self, task: &Task, columns: &mut Columns) {
        task.columns(self.arm, self.at, columns);
        with_followers(self.chain, self.scale, columns);
        held(self.stays, columns);
    }

    fn joints(&self) -> usize {
        self.arm.joints()
    }
}
