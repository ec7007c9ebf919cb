//! One step of the joints: Newton where it can be trusted, damped where not, within the limits.
//!
//! ```text
//! Newton   J x = e                                            six free joints, six rows
//! damped   x = Jᵀ (J Jᵀ + μ I)⁻¹ e = (Jᵀ J + μ I)⁻¹ Jᵀ e         any numbers: the smallest step that does the most
//! ```
//!
//! | symbol | here | shape | unit |
//! | --- | --- | --- | --- |
//! | x | result | joints | rad, or characteristic lengths of travel |
//! | μ | `damping` | 1 | 1 |
//!
//! A joint that a step would carry beyond its limit stops there; the others do what it leaves undone (active set).
//! Source: Wampler 1986, Nakamura and Hanafusa 1986 for the damped step; the smaller of the two systems is solved.

// Indices name rows and columns of the equations above.
#![allow(clippy::needless_range_loop)]

use crate::command::MOST;

/// Limits of the joints in units of x.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Limits {
    pub lower: [f64; MOST],
    pub upper: [f64; MOST],
}

impl Limits {
    pub const NONE: Limits = Limits { lower: [f64::NEG_INFINITY; MOST], upper: [f64::INFINITY; MOST] };
}

/// The linear problem of one iteration.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Linear<'a> {
    pub columns: &'a [[f64; 6]],
    pub error: &'a [f64; 6],
    pub rows: usize,
}

/// Largest step of one joint, rad or characteristic lengths.
pub(crate) const LARGEST: f64 = 0.7;

impl Linear<'_> {
    /// J of Newton's step, when the problem is square and regular.
    pub fn factors(&self) -> Option<Factors> {
        if self.columns.len() != 6 || self.rows != 6 {
            return None;
        }
        Factors::of(self.columns)
    }

    /// The damped step within the limits.
    pub fn damped(&self, x: &[f64; MOST], limits: &Limits, damping: f64) -> [f64; MOST] {
        let n = self.columns.len();
        let mut free = [true; MOST];
        let mut taken = [0.0; MOST];
        let mut error = *self.error;
        for _ in 0..=n {
            let mut step = self.free_step(&free, &error, damping);
            let longest = step[..n].iter().fold(0.0, |m: f64, s| m.max(s.abs()));
            if longest > LARGEST {
                step.iter_mut().for_each(|s| *s *= LARGEST / longest);
            }
            let mut stopped = false;
            for k in 0..n {
                if !free[k] {
                    continue;
                }
                let next = x[k] + step[k];
                if next < limits.lower[k] || next > limits.upper[k] {
                    taken[k] = next.clamp(limits.lower[k], limits.upper[k]) - x[k];
                    stopped = true;
                    free[k] = false;
                    error.iter_mut().zip(&self.columns[k]).for_each(|(e, j)| *e -= j * taken[k]);
                }
            }
            if !stopped {
                for k in (0..n).filter(|&k| free[k]) {
                    taken[k] = step[k];
                }
                break;
            }
        }
        taken
    }

    /// The damped step of the free joints.
    fn free_step(&self, free: &[bool; MOST], error: &[f64; 6], damping: f64) -> [f64; MOST] {
        let n = self.columns.len();
        let mut list = [0; MOST];
        let mut count = 0;
        for k in (0..n).filter(|&k| free[k]) {
            list[count] = k;
            count += 1;
        }
        let list = &list[..count];
        let mut step = [0.0; MOST];
        let mut matrix = [[0.0; 6]; 6];
        if count >= self.rows {
            for &k in list {
                let column = &self.columns[k];
                for a in 0..self.rows {
                    for b in 0..=a {
                        matrix[a][b] += column[a] * column[b];
                    }
                }
            }
            (0..self.rows).for_each(|a| matrix[a][a] += damping);
            let mut y = *error;
            cholesky_solve(&mut matrix, &mut y, self.rows);
            for &k in list {
                step[k] = (0..self.rows).map(|a| self.columns[k][a] * y[a]).sum();
            }
        } else {
            let mut y = [0.0; 6];
            for (a, &k) in list.iter().enumerate() {
                for (b, &l) in list[..=a].iter().enumerate() {
                    matrix[a][b] = (0..self.rows).map(|r| self.columns[k][r] * self.columns[l][r]).sum();
                }
                matrix[a][a] += damping;
                y[a] = (0..self.rows).map(|r| self.columns[k][r] * error[r]).sum();
            }
            cholesky_solve(&mut matrix, &mut y, count);
            for (a, &k) in list.iter().enumerate() {
                step[k] = y[a];
            }
        }
        step
    }
}

/// J of six joints by elimination with row exchanges.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Factors {
    /// U above the diagonal, factors of the elimination below it, in the order of the pivots.
    rows: [[f64; 6]; 6],
    /// One over each pivot.
    inverse: [f64; 6],
    /// Which row of e each pivot's row was.
    order: [usize; 6],
}

impl Factors {
    /// Newton's step, when it is short and stays within the limits.
    pub fn step(&self, error: &[f64; 6], x: &[f64; MOST], limits: &Limits) -> Option<[f64; MOST]> {
        let step = self.solve(error);
        let inside = (0..6).all(|k| {
            let next = x[k] + step[k];
            step[k].abs() <= LARGEST && next >= limits.lower[k] && next <= limits.upper[k]
        });
        inside.then_some(step)
    }

    /// None when J is singular to working precision.
    fn of(columns: &[[f64; 6]]) -> Option<Self> {
        let mut a = [[0.0; 6]; 6];
        for (k, column) in columns.iter().enumerate().take(6) {
            for row in 0..6 {
                a[row][k] = column[row];
            }
        }
        let mut order = [0, 1, 2, 3, 4, 5];
        let mut inverse = [0.0; 6];
        for k in 0..6 {
            let mut pivot = k;
            for row in k + 1..6 {
                if a[row][k].abs() > a[pivot][k].abs() {
                    pivot = row;
                }
            }
            if a[pivot][k].abs() < 1e-9 || a[pivot][k].is_nan() {
                return None;
            }
            a.swap(k, pivot);
            order.swap(k, pivot);
            let line = a[k];
            inverse[k] = 1.0 / line[k];
            for row in a.iter_mut().skip(k + 1) {
                let factor = row[k] * inverse[k];
                row[k] = factor;
                for c in k + 1..6 {
                    row[c] -= factor * line[c];
                }
            }
        }
        Some(Factors { rows: a, inverse, order })
    }

    /// J x = e.
    fn solve(&self, error: &[f64; 6]) -> [f64; MOST] {
        let mut x = [0.0; MOST];
        for k in 0..6 {
            let mut sum = error[self.order[k]];
            for c in 0..k {
                sum -= self.rows[k][c] * x[c];
            }
            x[k] = sum;
        }
        for k in (0..6).rev() {
            let mut sum = x[k];
            for c in k + 1..6 {
                sum -= self.rows[k][c] * x[c];
            }
            x[k] = sum * self.inverse[k];
        }
        x
    }
}

/// Solves a symmetric positive definite system of size n, given by its lower triangle; y becomes the solution.
/// A pivot that round-off annihilated leaves its unknown at zero.
pub(crate) fn cholesky_solve(matrix: &mut [[f64; 6]; 6], y: &mut [f64; 6], n: usize) {
    for k in 0..n {
        let mut pivot = matrix[k][k];
        for c in 0..k {
            pivot -= matrix[k][c] * matrix[k][c];
        }
        let inverse = if pivot > f64::MIN_POSITIVE { 1.0 / pivot.sqrt() } else { 0.0 };
        matrix[k][k] = inverse;
        for row in k + 1..n {
            let mut sum = matrix[row][k];
            for c in 0..k {
                sum -= matrix[row][c] * matrix[k][c];
            }
            matrix[row][k] = sum * inverse;
        }
    }
    for k in 0..n {
        let mut sum = y[k];
        for c in 0..k {
            sum -= matrix[k][c] * y[c];
        }
        y[k] = sum * matrix[k][k];
    }
    for k in (0..n).rev() {
        let mut sum = y[k];
        for row in k + 1..n {
            sum -= matrix[row][k] * y[row];
        }
        y[k] = sum * matrix[k][k];
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn product(columns: &[[f64; 6]], x: &[f64; MOST]) -> [f64; 6] {
        std::array::from_fn(|r| columns.iter().zip(x).map(|(c, x)| c[r] * x).sum())
    }

    proptest! {
        #[test]
        fn newton_and_a_hardly_damped_step_agree(
            columns in prop::collection::vec(prop::array::uniform6(-1.0..1.0f64), 6),
            error in prop::array::uniform6(-0.01..0.01f64),
        ) {
            let linear = Linear { columns: &columns, error: &error, rows: 6 };
            if let Some(step) = linear.factors().and_then(|f| f.step(&error, &[0.0; MOST], &Limits::NONE)) {
                let back = product(&columns, &step);
                for r in 0..6 {
                    prop_assert!((back[r] - error[r]).abs() < 1e-9);
                }
            }
        }

        #[test]
        fn the_step_of_a_redundant_robot_is_the_shortest(
            columns in prop::collection::vec(prop::array::uniform6(-1.0..1.0f64), 9),
            error in prop::array::uniform6(-0.01..0.01f64),
            other in prop::collection::vec(-0.01..0.01f64, 9),
        ) {
            let linear = Linear { columns: &columns, error: &error, rows: 6 };
            let step = linear.damped(&[0.0; MOST], &Limits::NONE, 1e-12);
            let back = product(&columns, &step);
            prop_assume!((0..6).all(|r| (back[r] - error[r]).abs() < 1e-7));
            // Shortest: at right angles to every motion that leaves the tool where it is.
            let mut wander = [0.0; MOST];
            wander[..9].copy_from_slice(&other);
            let moved = product(&columns, &wander);
            let undo = Linear { columns: &columns, error: &moved, rows: 6 }.damped(&[0.0; MOST], &Limits::NONE, 1e-12);
            let overlap: f64 = (0..9).map(|k| step[k] * (wander[k] - undo[k])).sum();
            prop_assert!(overlap.abs() < 1e-6, "{overlap}");
        }

        #[test]
        fn limits_hold_and_the_others_help(
            columns in prop::collection::vec(prop::array::uniform6(-1.0..1.0f64), 8),
            error in prop::array::uniform6(-0.1..0.1f64),
            stop in 0.0..0.01f64,
        ) {
            let mut limits = Limits::NONE;
            limits.lower[2] = -stop;
            limits.upper[2] = stop;
            let linear = Linear { columns: &columns, error: &error, rows: 6 };
            let step = linear.damped(&[0.0; MOST], &limits, 1e-12);
            prop_assert!(step[2].abs() <= stop);
            let longest = step.iter().fold(0.0f64, |m, s| m.max(s.abs()));
            let back = product(&columns, &step);
            prop_assume!(longest < 0.5 * LARGEST);
            prop_assert!((0..6).all(|r| (back[r] - error[r]).abs() < 1e-5), "{back:?} {error:?}");
        }
    }

    #[test]
    fn nothing_comes_of_nothing() {
        let columns = [[0.0; 6]; 4];
        let linear = Linear { columns: &columns, error: &[1.0; 6], rows: 6 };
        assert!(linear.damped(&[0.0; MOST], &Limits::NONE, 0.0).iter().all(|s| s.abs() < f64::MIN_POSITIVE));
        let nan = Linear { columns: &[[f64::NAN; 6]; 6], error: &[1.0; 6], rows: 6 };
        assert!(nan.factors().is_none());
    }
}
