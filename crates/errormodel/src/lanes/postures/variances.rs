//! How well a pose is known at many postures, of the covariance of constant errors, without J_e in memory.
//!
//! | symbol | here | shape | unit |
//! | --- | --- | --- | --- |
//! | C = L Lᵀ | `covariance` of the generalized errors | 6n × 6n | m, rad |
//! | J_e | axes and levers of a block | 6 × 6n | |
//!
//! ```text
//! diag(J_e C J_eᵀ)_c = Σ_k ((J_e L)_ck)²          J_φ = [0 A_1 … 0 A_n] needs the Cholesky factor of C's block of rotations alone
//! ```

use super::{Blocks, fits};
use crate::ModelError;
use crate::lanes::{LANES, Store};
use nalgebra::DMatrix;
use truepose_kinematics::lanes::Lane;
use truepose_kinematics::pulp::{Simd, WithSimd};
use truepose_kinematics::{Chain, three};

/// A pivot below this share of its column's variance is rounding: the direction is known already. What is left of covariances with it is as
/// small.
const ROUNDING: f64 = 1e-12;

/// Variances of position (x, y, z, m²) and rotation (rx, ry, rz, rad²) of the tool at many postures of the nominal robot.
///
/// ```text
/// diag(J_e C J_eᵀ),    J_e of Eq. 7
/// ```
///
/// `joints` has a column a movable joint, values of its variable, rad or m. C is `covariance`, that of the constant errors of the n joints' frames,
/// each x, y, z, rx, ry, rz, in m and rad. `into` has six parts, one a component in the measurement frame, each with a number a posture.
///
/// # Errors
/// [`ModelError::Shape`] when sizes do not fit, [`ModelError::NotACovariance`] when `covariance` is not symmetric, not finite, or has a negative variance in
/// some direction.
pub fn error_variances(
    chain: &Chain,
    joints: &[&[f64]],
    covariance: &DMatrix<f64>,
    into: &mut [f64],
) -> Result<(), ModelError> {
    let mut blocks = Blocks::new(chain, joints)?;
    let (frames, postures) = (blocks.frames(), blocks.postures);
    fits("rows of the covariance", covariance.nrows(), 6 * frames)?;
    fits("columns of the covariance", covariance.ncols(), 6 * frames)?;
    fits("variances", into.len(), 6 * postures)?;
    let sites: Vec<usize> = (0..6 * frames).collect();
    let turns: Vec<usize> = sites.iter().copied().filter(|site| site % 6 > 2).collect();
    let axes = |store: &Store, site: usize| store.before(site / 6 + 1) + 3 * (site % 3);
    let moves = |store: &Store, site: usize| match site % 6 {
        0..3 => axes(store, site),
        _ => store.lever(site / 6 + 1) + 3 * (site % 3),
    };
    let factors = [factor(covariance, &sites)?, factor(covariance, &turns)?];
    let rows: [Vec<usize>; 2] = [
        sites.iter().map(|&site| moves(&blocks.store, site)).collect(),
        turns.iter().map(|&site| axes(&blocks.store, site)).collect(),
    ];
    let mut made = vec![0.0; 3 * LANES];
    for block in 0..blocks.count() {
        let (store, count) = blocks.at(block);
        for (part, (rows, factor)) in rows.iter().zip(&factors).enumerate() {
            let arch = store.arch;
            arch.dispatch(Squares { store, rows, factor, into: &mut made });
            for (component, made) in made.chunks_exact(LANES).enumerate() {
                let first = (3 * part + component) * postures + block * LANES;
                into[first..first + count].copy_from_slice(&made[..count]);
            }
        }
    }
    Ok(())
}

/// Columns of L that are worked on together.
const TOGETHER: usize = 4;

/// L of the covariance of these sites: for each group of columns the numbers of each site from the group's first on.
fn factor(covariance: &DMatrix<f64>, sites: &[usize]) -> Result<Vec<[f64; TOGETHER]>, ModelError> {
    let size = sites.len();
    let mut l = covariance.select_rows(sites).select_columns(sites);
    let wrong = || ModelError::NotACovariance;
    for k in 0..size {
        let variance = covariance[(sites[k], sites[k])];
        let least = ROUNDING * variance;
        let pivot = l[(k, k)];
        if !(variance.is_finite() && variance >= 0.0 && pivot >= -1e3 * least) {
            return Err(wrong());
        }
        let by = if pivot > least { pivot.sqrt() } else { 0.0 };
        for row in k..size {
            let (own, beside) = (covariance[(sites[row], sites[k])], covariance[(sites[k], sites[row])]);
            if (own - beside).powi(2) > ROUNDING * variance * covariance[(sites[row], sites[row])].abs() {
                return Err(wrong());
            }
            let most = 10.0 * least * covariance[(sites[row], sites[row])];
            let below = l[(row, k)];
            if !below.is_finite() || by == 0.0 && row > k && below.powi(2) > most {
                return Err(wrong());
            }
            l[(row, k)] = if by > 0.0 { below / by } else { 0.0 };
        }
        for column in k + 1..size {
            let by = l[(column, k)];
            for row in column..size {
                l[(row, column)] -= l[(row, k)] * by;
            }
        }
    }
    let number =
        |row: usize, column: usize| if row >= column && column < size { l[(row, column)] } else { 0.0 };
    let groups = (0..size).step_by(TOGETHER);
    Ok(groups
        .flat_map(|first| (first..size).map(move |row| (first, row)))
        .map(|(first, row)| std::array::from_fn(|k| number(row, first + k)))
        .collect())
}

/// Sums of squares of J L by components, of the columns of J that stand in these rows of the store.
struct Squares<'a> {
    store: &'a Store,
    rows: &'a [usize],
    factor: &'a [[f64; TOGETHER]],
    into: &'a mut [f64],
}

impl WithSimd for Squares<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Squares { store, rows, factor, into } = self;
        let width = LANES / S::F64_LANES;
        let numbers = S::as_simd_f64s(&store.numbers).0;
        let into = S::as_mut_simd_f64s(into).0;
        let zero = Lane::splat(simd, 0.0);
        for v in 0..width {
            let mut squares = [zero; 3];
            let mut rest = factor;
            for first in (0..rows.len()).step_by(TOGETHER) {
                let (group, after) = rest.split_at(rows.len() - first);
                rest = after;
                let [mut a, mut b, mut c, mut d] = [[zero; 3]; TOGETHER];
                for (&row, by) in rows[first..].iter().zip(group) {
                    let x = three!(k => Lane::read(simd, numbers, row + k, width, v));
                    let by = [
                        Lane::splat(simd, by[0]),
                        Lane::splat(simd, by[1]),
                        Lane::splat(simd, by[2]),
                        Lane::splat(simd, by[3]),
                    ];
                    a = three!(k => x[k].mul_add(by[0], a[k]));
                    b = three!(k => x[k].mul_add(by[1], b[k]));
                    c = three!(k => x[k].mul_add(by[2], c[k]));
                    d = three!(k => x[k].mul_add(by[3], d[k]));
                }
                squares = three!(k => a[k].mul_add(a[k], b[k].mul_add(b[k], c[k].mul_add(c[k], d[k].mul_add(d[k], squares[k])))));
            }
            for (k, squares) in squares.iter().enumerate() {
                into[k * width + v] = squares.value();
            }
        }
    }
}
