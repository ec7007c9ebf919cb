//! The innermost panel of [`super::fold`]: a few columns, reflected one by one.
//!
//! ```text
//! v_j = tail / (α − β),  τ_j = (β − α)/β,   S_jj = τ_j,   S_{1…j−1, j} = −τ_j S (Vᵀ v_j)
//! ```

use super::norm::norm;
use faer::MatMut;
use pulp::{Arch, Simd, WithSimd};

/// Most columns of a panel.
pub(super) const PANEL: usize = 48;

/// Reflects the columns of `block` into the triangle `top`; V replaces the block, S comes out upper triangular.
pub(super) fn leaf(top: MatMut<'_, f64>, block: MatMut<'_, f64>, s: MatMut<'_, f64>) {
    Arch::new().dispatch(Leaf { top, block, s });
}

struct Leaf<'a> {
    top: MatMut<'a, f64>,
    block: MatMut<'a, f64>,
    s: MatMut<'a, f64>,
}

impl WithSimd for Leaf<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Leaf { mut top, block, mut s } = self;
        let width = top.ncols();
        let mut columns: Vec<&mut [f64]> = Vec::with_capacity(width);
        for column in block.col_iter_mut() {
            let Some(column) = column.try_as_col_major_mut() else { return };
            columns.push(column.as_slice_mut());
        }
        for j in 0..width {
            let (before, own) = columns.split_at_mut(j);
            let Some((own, after)) = own.split_first_mut() else { return };
            let tau = reflect(&mut top[(j, j)], own);
            s[(j, j)] = tau;
            if tau == 0.0 {
                continue;
            }
            let v = &**own;
            for (c, some) in after.chunks_mut(FOUR).enumerate() {
                let along = dots(simd, v, some);
                for (k, column) in some.iter_mut().enumerate() {
                    let at = (j, j + 1 + FOUR * c + k);
                    let by = tau * (top[at] + along[k]);
                    top[at] -= by;
                    subtract(simd, column, v, by);
                }
            }
            // What the reflections in front make of this one.
            let mut along = [0.0; PANEL];
            for (along, some) in along.chunks_mut(FOUR).zip(before.chunks(FOUR)) {
                along[..some.len()].copy_from_slice(&dots(simd, v, some)[..some.len()]);
            }
            for i in 0..j {
                let sum: f64 = (i..j).map(|k| s[(i, k)] * along[k]).sum();
                s[(i, j)] = -tau * sum;
            }
        }
    }
}

/// Columns that are multiplied together.
const FOUR: usize = 4;

/// v · column of some columns, at most four.
#[inline(always)]
fn dots<S: Simd>(simd: S, v: &[f64], columns: &[&mut [f64]]) -> [f64; FOUR] {
    let zero = simd.splat_f64s(0.0);
    let (v, v_rest) = S::as_simd_f64s(v);
    if let [a, b, c, d] = columns {
        let (a, a_rest) = S::as_simd_f64s(a);
        let (b, b_rest) = S::as_simd_f64s(b);
        let (c, c_rest) = S::as_simd_f64s(c);
        let (d, d_rest) = S::as_simd_f64s(d);
        let (mut sa, mut sb, mut sc, mut sd) = (zero, zero, zero, zero);
        let n = v.len();
        let (a, b, c, d) = (&a[..n], &b[..n], &c[..n], &d[..n]);
        for i in 0..n {
            sa = simd.mul_add_e_f64s(v[i], a[i], sa);
            sb = simd.mul_add_e_f64s(v[i], b[i], sb);
            sc = simd.mul_add_e_f64s(v[i], c[i], sc);
            sd = simd.mul_add_e_f64s(v[i], d[i], sd);
        }
        let mut sums = [
            simd.reduce_sum_f64s(sa),
            simd.reduce_sum_f64s(sb),
            simd.reduce_sum_f64s(sc),
            simd.reduce_sum_f64s(sd),
        ];
        for (k, &v) in v_rest.iter().enumerate() {
            sums[0] += v * a_rest[k];
            sums[1] += v * b_rest[k];
            sums[2] += v * c_rest[k];
            sums[3] += v * d_rest[k];
        }
        return sums;
    }
    let mut sums = [0.0; FOUR];
    for (sum, column) in sums.iter_mut().zip(columns) {
        let (column, rest) = S::as_simd_f64s(column);
        let mut lanes = zero;
        let column = &column[..v.len()];
        for i in 0..v.len() {
            lanes = simd.mul_add_e_f64s(v[i], column[i], lanes);
        }
        *sum = simd.reduce_sum_f64s(lanes);
        for (v, c) in v_rest.iter().zip(rest) {
            *sum += v * c;
        }
    }
    sums
}

/// column ← column − by · v.
#[inline(always)]
fn subtract<S: Simd>(simd: S, column: &mut [f64], v: &[f64], by: f64) {
    let ((column, column_rest), (v, v_rest)) = (S::as_mut_simd_f64s(column), S::as_simd_f64s(v));
    let times = simd.splat_f64s(by);
    let column = &mut column[..v.len()];
    for i in 0..v.len() {
        column[i] = simd.negate_mul_add_e_f64s(times, v[i], column[i]);
    }
    for (c, v) in column_rest.iter_mut().zip(v_rest) {
        *c -= by * v;
    }
}

/// Turns [α; tail] into [β; 0]: β replaces `head`, v replaces `tail`; gives τ of I − τ v vᵀ.
#[inline(always)]
fn reflect(head: &mut f64, tail: &mut [f64]) -> f64 {
    let below = norm(tail);
    if below == 0.0 {
        return 0.0;
    }
    let alpha = *head;
    let beta = -alpha.hypot(below).copysign(alpha);
    let lead = alpha - beta;
    let inverse = 1.0 / lead;
    if inverse.is_finite() {
        tail.iter_mut().for_each(|v| *v *= inverse);
    } else {
        tail.iter_mut().for_each(|v| *v /= lead);
    }
    *head = beta;
    lead / -beta
}
