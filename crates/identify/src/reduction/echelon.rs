//! From a basis of the null space to its reduced row echelon form, in a fixed order of columns (Eq. 10–13).
//!
//! | symbol | here | shape |
//! | --- | --- | --- |
//! | N | orthonormal rows, `J N^T = 0` in scaled columns | k × p |
//! | C | relations, 1 at their own dropped column, 0 at the others | k × p |
//!
//! Columns are visited from the least preferred on. A column is dropped when what is left of the null space reaches
//! it (those that it hardly reaches only when no others are left); the rows are then turned (by a Householder reflection) so that a single row reaches it, and that row is set
//! aside. The others stay orthonormal, so that no pivot is ever judged after a division: round-off cannot make a group.

use nalgebra::DMatrix;
use truepose_solvers::kernels::solve_upper_many;

/// Columns that depend on the others, and how.
#[derive(Debug, Clone, PartialEq)]
pub struct Echelon {
    /// Dropped columns, from the least preferred on.
    pub dropped: Vec<usize>,
    /// One row a dropped column: `Σ_j C_ij · column_j = 0`, with C = 1 at the dropped column itself and 0 at the
    /// other dropped ones.
    pub relations: DMatrix<f64>,
}

/// A direction of the null space that reaches a column with less than this does not need it.
const REACHES: f64 = 1e-3;
/// Columns that are reached with less than this are dropped only where nothing else is left to drop. What is kept in the place of a
/// dropped column moves by one over its reach, in expected sizes, and the robot is no longer linear in a thousand of these: five
/// targets within a hand's width, whose places say how the tool is turned, made a tool turn by radians in the place of millimetres.
/// Thirty expected sizes of a milliradian at the metre of an arm bend by half a millimetre, what rounds can follow.
const WELL: f64 = 0.03;
/// The same where relations among several dropped columns, each well reached, multiply to more than one over [`WELL`]. Convention: a third.
const BETTER: f64 = 0.3;

/// Reduced row echelon form of `null` (p × k, orthonormal columns), with columns preferred in this order. Where a relation exceeds one over
/// 0.03 the preference yields: columns are dropped that the null space reaches better, if that makes the largest relation smaller (Eq. 10–13).
pub fn echelon(null: &DMatrix<f64>, preference: &[usize]) -> Echelon {
    let form = with_reach(null, preference, WELL);
    if form.relations.amax() <= 1.0 / WELL {
        return form;
    }
    let other = with_reach(null, preference, BETTER);
    if other.relations.amax() < form.relations.amax() { other } else { form }
}

/// The form whose columns are reached with at least `well`, as long as there are any.
fn with_reach(null: &DMatrix<f64>, preference: &[usize], well: f64) -> Echelon {
    let (p, k) = null.shape();
    if k == 0 {
        return Echelon { dropped: Vec::new(), relations: DMatrix::zeros(0, p) };
    }
    let mut rows = null.transpose();
    let mut dropped = Vec::with_capacity(k);
    let mut left = k;
    for least in [well, REACHES] {
        for &column in preference.iter().rev() {
            if left == 0 {
                break;
            }
            if dropped.contains(&column) {
                continue;
            }
            let reach = rows.view((0, column), (left, 1)).norm();
            if reach < least {
                continue;
            }
            reflect_to_last(&mut rows, left, column, reach);
            left -= 1;
            dropped.push(column);
        }
    }
    // Set aside from the last row upwards: row k−1 is the first pivot. Later pivots have a zero in earlier pivots' columns: the system is
    // triangular and well away from singular.
    let set_aside = |i: usize, j: usize| rows[(k - 1 - i, j)];
    let pivots = DMatrix::from_fn(dropped.len(), dropped.len(), |i, j| set_aside(i, dropped[j]));
    let mut is_dropped = vec![false; p];
    dropped.iter().for_each(|&column| is_dropped[column] = true);
    let kept: Vec<usize> = (0..p).filter(|&column| !is_dropped[column]).collect();
    let mut shares = DMatrix::from_fn(dropped.len(), kept.len(), |i, j| set_aside(i, kept[j]));
    solve_upper_many(&pivots, &mut shares);
    let mut relations = DMatrix::zeros(dropped.len(), p);
    kept.iter().enumerate().for_each(|(from, &to)| relations.set_column(to, &shares.column(from)));
    dropped.iter().enumerate().for_each(|(row, &column)| relations[(row, column)] = 1.0);
    Echelon { dropped, relations }
}

/// Turns the first `count` rows so that only the last of them reaches the column.
fn reflect_to_last(rows: &mut DMatrix<f64>, count: usize, column: usize, reach: f64) {
    let height = rows.nrows();
    let mut v = rows.as_slice()[column * height..][..count].to_vec();
    let last = count - 1;
    v[last] += if v[last] < 0.0 { -reach } else { reach };
    let square = dot(&v, &v);
    for column in rows.as_mut_slice().chunks_exact_mut(height) {
        let part = &mut column[..count];
        let by = 2.0 * dot(part, &v) / square;
        part.iter_mut().zip(&v).for_each(|(part, v)| *part -= by * v);
    }
}

/// Eight sums side by side, so that none waits for the one before.
fn dot(a: &[f64], b: &[f64]) -> f64 {
    let ((a, a_rest), (b, b_rest)) = (a.as_chunks::<8>(), b.as_chunks::<8>());
    let mut sums = [0.0; 8];
    for (a, b) in a.iter().zip(b) {
        (0..8).for_each(|k| sums[k] += a[k] * b[k]);
    }
    sums.iter().sum::<f64>() + a_rest.iter().zip(b_rest).map(|(a, b)| a * b).sum::<f64>()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keeps_the_preferred_and_says_how_the_others_depend() {
        // Columns a, b, c = a + 2 b, d: null space (1, 2, −1, 0).
        let null = DMatrix::from_column_slice(4, 1, &[1.0, 2.0, -1.0, 0.0]) / 6f64.sqrt();
        let first = echelon(&null, &[0, 1, 2, 3]);
        assert_eq!(first.dropped, [2]);
        let expected = [-1.0, -2.0, 1.0, 0.0];
        for (value, expect) in first.relations.row(0).iter().zip(expected) {
            assert!((value - expect).abs() < 1e-14);
        }
        assert_eq!(echelon(&null, &[2, 3, 1, 0]).dropped, [0]);
    }

    #[test]
    fn a_column_that_is_hardly_reached_does_not_stand_for_the_others() {
        // The least preferred column takes part with a five-hundredth: dropped, it would stand for five hundred of the others.
        let null = DMatrix::from_column_slice(3, 1, &[1.0, -1.0, 0.002]).normalize();
        let form = echelon(&null, &[0, 1, 2]);
        assert_eq!(form.dropped, [1]);
        assert!(form.relations.amax() < 1.0 + 1e-12);
        // Where it is all there is, it has to go.
        let both = DMatrix::from_columns(&[
            nalgebra::DVector::from_column_slice(&[1.0, -1.0, 0.0]).normalize(),
            nalgebra::DVector::from_column_slice(&[0.0, 0.01, 1.0]).normalize(),
        ]);
        let form = echelon(&both.clone().qr().q(), &[2, 1, 0]);
        assert_eq!(form.dropped.len(), 2);
    }

    #[test]
    fn relations_of_several_dropped_columns_do_not_multiply() {
        // Each of the least preferred columns is reached with a twentieth: together they would stand for four hundred.
        let first = nalgebra::DVector::from_column_slice(&[1.0, 0.0, -1.0, 0.0, 0.05]).normalize();
        let second = nalgebra::DVector::from_column_slice(&[0.0, 1.0, 0.0, 0.05, 1.0]).normalize();
        let null = DMatrix::from_columns(&[first, second]).qr().q();
        let plain = with_reach(&null, &[0, 1, 2, 4, 3], WELL);
        assert!(plain.relations.amax() > 100.0, "{}", plain.relations);
        let form = echelon(&null, &[0, 1, 2, 4, 3]);
        assert!(form.relations.amax() < 5.0, "{}", form.relations);
        // One that is reached with a twentieth alone stays: what is kept moves by twenty.
        let single = DMatrix::from_column_slice(3, 1, &[1.0, -1.0, 0.07]).normalize();
        assert_eq!(echelon(&single, &[0, 1, 2]), with_reach(&single, &[0, 1, 2], WELL));
    }

    #[test]
    fn does_not_depend_on_the_basis_of_the_null_space() {
        let raw = DMatrix::from_fn(9, 3, |i, j| ((7 * i + 3 * j * j + i * j) % 11) as f64 - 5.0);
        let basis = raw.clone().qr().q();
        let turn = DMatrix::from_fn(3, 3, |i, j| ((i * 5 + j * 3) % 7) as f64).qr().q();
        let order: Vec<usize> = (0..9).rev().collect();
        let (a, b) = (echelon(&basis, &order), echelon(&(basis * turn), &order));
        assert_eq!(a.dropped, b.dropped);
        assert!((a.relations - b.relations).amax() < 1e-12);
    }
}
