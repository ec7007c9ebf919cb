//! Newton's step of six joints for several commands at once, by orthogonalisation: no row is exchanged, so that all lanes do the same.
//!
//! ```text
//! J = Q R (modified Gram–Schmidt),   R x = Qᵀ e
//! ```
//!
//! J and e as in `task`. Where J is nearly singular the step is inaccurate, or no number: the walk measures what it does.

// Indices name rows and columns of the equations above.
#![allow(clippy::needless_range_loop)]

use super::arm::JOINTS;
use super::vector::Wide;
use pulp::Simd;

/// Q and R; the diagonal of R is inverted.
pub(super) struct Factors<S: Simd> {
    q: [[Wide<S>; 6]; JOINTS],
    r: [[Wide<S>; JOINTS]; JOINTS],
}

#[inline(always)]
fn dot<S: Simd>(a: &[Wide<S>; 6], b: &[Wide<S>; 6]) -> Wide<S> {
    // Two sums, which do not wait for one another.
    let even = a[0].times_plus(b[0], a[2].times_plus(b[2], a[4] * b[4]));
    a[1].times_plus(b[1], a[3].times_plus(b[3], a[5].times_plus(b[5], even)))
}

impl<S: Simd> Factors<S> {
    /// Of J by columns.
    #[inline(always)]
    pub fn of(simd: S, mut q: [[Wide<S>; 6]; JOINTS]) -> Self {
        let one = Wide::all(simd, 1.0);
        let mut r = [[one; JOINTS]; JOINTS];
        for k in 0..JOINTS {
            let inverse = one.over(dot(&q[k], &q[k]).sqrt());
            r[k][k] = inverse;
            for row in 0..6 {
                q[k][row] = q[k][row] * inverse;
            }
            for j in k + 1..JOINTS {
                let along = dot(&q[k], &q[j]);
                r[k][j] = along;
                for row in 0..6 {
                    q[j][row] = q[k][row].times_from(along, q[j][row]);
                }
            }
        }
        Factors { q, r }
    }

    /// J x = e.
    #[inline(always)]
    pub fn solve(&self, mut e: [Wide<S>; 6]) -> [Wide<S>; JOINTS] {
        let mut x = e;
        for k in 0..JOINTS {
            x[k] = dot(&self.q[k], &e);
            for row in 0..6 {
                e[row] = self.q[k][row].times_from(x[k], e[row]);
            }
        }
        for k in (0..JOINTS).rev() {
            x[k] = x[k] * self.r[k][k];
            for j in 0..k {
                x[j] = self.r[j][k].times_from(x[k], x[j]);
            }
        }
        x
    }
}
