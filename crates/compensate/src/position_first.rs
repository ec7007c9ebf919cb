//! Position exactly, orientation as nearly as it goes: for robots that cannot have both.
//!
//! ```text
//! x_1 = J_p⁺ e_p                       J_p⁺ = J_pᵀ (J_p J_pᵀ + μ_1 I)⁻¹
//! P   = J_r (I − J_p⁺ J_p)             joint motion that leaves the point at rest
//! x   = x_1 + Pᵀ (P Pᵀ + μ_2 I)⁻¹ (e_r − J_r x_1)
//! ```
//!
//! | symbol | here | shape | unit |
//! | --- | --- | --- | --- |
//! | J_p, J_r | rows 0…2 and 3…5 of `columns` | 3 × joints | 1 |
//! | e_p, e_r | of [`Gap::error`] | 3 | 1 |
//!
//! Source: Nakamura, Hanafusa and Yoshikawa 1987 (task priority). A joint at its limit that would leave it stands still.

// Indices name rows and columns of the equations above.
#![allow(clippy::needless_range_loop)]

use crate::command::MOST;
use crate::search::{Ending, Robot, Walk};
use crate::step::{Limits, cholesky_solve};
use crate::task::{Columns, Gap, Task};

const HARD: f64 = 1e-15;
const SOFT: f64 = 1e-6;
/// A turn of the joints, rad, below which the orientation no longer disturbs the position.
const FINE: f64 = 1e-9;
/// A turn of the joints, rad, below which nothing more is to be had.
const STILL: f64 = 1e-11;
const LARGEST: f64 = 0.3;

/// Walks from x; `There` means that the position is reached and the orientation as near as it comes.
pub(crate) fn walk_position_first(
    robot: &mut impl Robot,
    task: &Task,
    start: &[f64; MOST],
    limits: &Limits,
    most: usize,
) -> Walk {
    let n = robot.joints();
    let mut here = Walk { x: *start, gap: Gap::nowhere(), ending: Ending::GaveUp, rounds: 0 };
    let mut columns: Columns = [[0.0; 6]; MOST];
    let mut last_turn = f64::INFINITY;
    while here.rounds < most {
        here.gap = robot.send(&here.x, task);
        here.rounds += 1;
        if !here.gap.cost.is_finite() {
            break;
        }
        robot.columns(task, &mut columns);
        let step = within(&here.x, columns, &here.gap, n, limits);
        let longest = step[..n].iter().fold(0.0, |m: f64, s| m.max(s.abs()));
        let turn = here.gap.orientation();
        let there = here.gap.position(task.length) <= task.position_tolerance;
        if there && (longest <= STILL || (turn - last_turn).abs() <= 1e-13 + 1e-12 * turn) {
            here.ending = Ending::There;
            break;
        }
        last_turn = turn;
        if longest <= 1e-15 {
            here.ending = Ending::Stuck;
            break;
        }
        let share = if longest > LARGEST { LARGEST / longest } else { 1.0 };
        for k in 0..n {
            here.x[k] = (here.x[k] + share * step[k]).clamp(limits.lower[k], limits.upper[k]);
        }
    }
    here
}

fn within(x: &[f64; MOST], mut columns: Columns, gap: &Gap, n: usize, limits: &Limits) -> [f64; MOST] {
    let mut step = [0.0; MOST];
    for _ in 0..=n {
        step = prioritised(&columns[..n], &gap.error);
        let mut stopped = false;
        for k in 0..n {
            let out =
                (x[k] <= limits.lower[k] && step[k] < 0.0) || (x[k] >= limits.upper[k] && step[k] > 0.0);
            if out {
                columns[k] = [0.0; 6];
                stopped = true;
            }
        }
        if !stopped {
            break;
        }
    }
    step
}

fn prioritised(columns: &[[f64; 6]], e: &[f64; 6]) -> [f64; MOST] {
    let mut step = [0.0; MOST];
    // J_p J_pᵀ, and its inverse times anything by columns.
    let mut gram = [[0.0; 6]; 6];
    for column in columns {
        for a in 0..3 {
            (0..=a).for_each(|b| gram[a][b] += column[a] * column[b]);
        }
    }
    (0..3).for_each(|a| gram[a][a] += HARD);
    let solve = |right: [f64; 3]| {
        let mut y = [right[0], right[1], right[2], 0.0, 0.0, 0.0];
        cholesky_solve(&mut gram.clone(), &mut y, 3);
        [y[0], y[1], y[2]]
    };
    let y = solve([e[0], e[1], e[2]]);
    for (s, column) in step.iter_mut().zip(columns) {
        *s = (0..3).map(|a| column[a] * y[a]).sum();
    }
    // P, row by row: J_r minus its part along the rows of J_p.
    let mut p = [[0.0; MOST]; 3];
    let mut left = [e[3], e[4], e[5]];
    for r in 0..3 {
        let mut along = [0.0; 3];
        for (column, s) in columns.iter().zip(&step) {
            (0..3).for_each(|a| along[a] += column[3 + r] * column[a]);
            left[r] -= column[3 + r] * s;
        }
        let y = solve(along);
        for (k, column) in columns.iter().enumerate() {
            p[r][k] = column[3 + r] - (0..3).map(|a| column[a] * y[a]).sum::<f64>();
        }
    }
    let mut gram = [[0.0; 6]; 6];
    for a in 0..3 {
        for b in 0..=a {
            gram[a][b] = p[a].iter().zip(&p[b]).map(|(u, v)| u * v).sum();
        }
        gram[a][a] += SOFT;
    }
    let mut z = [left[0], left[1], left[2], 0.0, 0.0, 0.0];
    cholesky_solve(&mut gram, &mut z, 3);
    let second: [f64; MOST] = std::array::from_fn(|k| (0..3).map(|r| p[r][k] * z[r]).sum());
    if second.iter().any(|s| s.abs() > FINE) {
        step.iter_mut().zip(&second).for_each(|(s, more)| *s += more);
    }
    step
}
