//! Down to a pose from one start: Levenberg and Marquardt far away, Newton near the end.
//!
//! ```text
//! x ← x + J⁻¹ e                     |e|² below `NEAR`, regular, and while each round takes off a factor of four
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
//! is in e, so that on the exact model this is a quasi-Newton iteration that gains two to three digits a round.
//! Source: Sugihara 2011 (damping by |e|², which needs no knowledge of whether the pose can be reached).

use crate::arm::Reached;
use crate::command::MOST;
use crate::step::{Limits, Linear};
use crate::task::{Gap, Task};
use nalgebra::Vector3;

/// Something with joints that can be sent to x.
pub(crate) trait Robot {
    /// Evaluates it there; fills e and, when wanted, J.
    fn send(&mut self, x: &[f64; MOST], task: &Task, gap: &mut Gap);
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
    /// Rounds ran out, or the model made no number.
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
const NEAR: f64 = 2e-3;
const BIAS: f64 = 1e-8;
/// A walk whose |e|² fell by less than a hundredth in so many rounds is at the edge of what can be reached.
const CHECK: usize = 10;

/// Walks from x until the gap closes, nothing helps, or the rounds run out.
pub(crate) fn walk(
    robot: &mut impl Robot,
    task: &Task,
    start: &[f64; MOST],
    limits: &Limits,
    most: usize,
) -> Walk {
    let n = robot.joints();
    let mut here = Walk { x: *start, gap: Gap::nowhere(), ending: Ending::GaveUp, rounds: 1 };
    robot.send(&here.x, task, &mut here.gap);
    let mut next = here.gap;
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
        let linear = Linear { columns: &here.gap.columns[..n], error: &here.gap.error, rows: task.rows() };
        let near = here.gap.cost < NEAR && newton;
        let quick = if near { linear.newton(&here.x, limits) } else { None };
        let step = quick.unwrap_or_else(|| {
            let damping = if near { 1e-13 } else { trust * (0.5 * here.gap.cost + BIAS) };
            linear.damped(&here.x, limits, damping)
        });
        let mut x = here.x;
        for k in 0..n {
            x[k] = (x[k] + step[k]).clamp(limits.lower[k], limits.upper[k]);
        }
        robot.send(&x, task, &mut next);
        here.rounds += 1;
        let (before, after) = (here.gap.cost, next.cost);
        if after < before {
            here.x = x;
            here.gap = next;
            if near {
                newton = after < 0.25 * before;
            } else {
                trust = f64::max(trust * if after < 0.5 * before { 0.2 } else { 0.6 }, 1e-9);
                newton = newton || after < 0.01 * before;
            }
            idle = if after > before * (1.0 - 1e-7) { idle + 1 } else { 0 };
        } else if near {
            newton = false;
        } else {
            trust *= 8.0;
        }
    }
    here
}

impl Gap {
    pub fn nowhere() -> Self {
        Gap { error: [0.0; 6], columns: [[0.0; 6]; MOST], cost: f64::INFINITY }
    }
}

/// The nominal robot, for starts.
pub(crate) struct NominalArm<'a> {
    pub arm: &'a crate::arm::Arm,
    pub point: Vector3<f64>,
    pub scale: &'a [f64; MOST],
    pub at: &'a mut Reached,
}

impl Robot for NominalArm<'_> {
    fn send(&mut self, x: &[f64; MOST], task: &Task, gap: &mut Gap) {
        let mut q = [0.0; MOST];
        q.iter_mut().zip(x).zip(self.scale).for_each(|((q, x), scale)| *q = x * scale);
        self.arm.reach(&q, &[], self.at);
        let point = task.gap(self.at, &self.point, gap);
        task.columns(self.arm, self.at, &point, gap);
    }

    fn joints(&self) -> usize {
        self.arm.joints()
    }
}
