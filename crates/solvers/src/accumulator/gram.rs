//! The mergeable Gram matrix of [A | Y].
//!
//! G = AᵀA,  H = AᵀY,  q_k = ‖Y_k‖²
//!
//! | symbol | name | shape | unit |
//! | --- | --- | --- | --- |
//! | G | Gram matrix | p × p | that of A, squared |
//! | H | moments | p × k | A · Y |
//! | q | squares | k | that of Y, squared |
//!
//! It squares the condition number: singular values below √(p ε) of the largest are round-off, which the factor says
//! as its `resolution`. Take [`Triangular`](super::Triangular) wherever a rank is in question.

mod guarded;
mod refined;

use super::Factor;
use super::bytes::{Stored, read, write};
use super::pieces::Pieces;
use super::triangular::check_finite;
use crate::SolveError;
use crate::dense::{Reflectors, fold, gram_of, svd};
use crate::problem::check_len;
use faer::MatMut;
use nalgebra::DMatrix;
use std::borrow::Cow;

const MAGIC: [u8; 4] = *b"TPGR";

/// AᵀA, AᵀY and the squares of Y over a stream of rows.
#[derive(Debug, Clone)]
pub struct Gram {
    columns: usize,
    rhs: usize,
    /// Lower triangle of [A | Y]ᵀ [A | Y].
    whole: DMatrix<f64>,
    /// What has not come to the whole yet.
    pieces: Pieces,
    rows: usize,
}

impl Gram {
    /// An empty accumulator of `columns` unknowns and `rhs` right-hand sides.
    pub fn new(columns: usize, rhs: usize) -> Self {
        let size = columns + rhs;
        Self { columns, rhs, whole: DMatrix::zeros(size, size), pieces: Pieces::default(), rows: 0 }
    }

    /// Number of rows seen.
    pub fn rows(&self) -> usize {
        self.rows
    }

    /// Number of unknowns.
    pub fn columns(&self) -> usize {
        self.columns
    }

    /// Takes in rows of A and the same rows of Y.
    pub fn update(&mut self, a: &DMatrix<f64>, y: &DMatrix<f64>) -> Result<(), SolveError> {
        check_len("columns of the block", self.columns, a.ncols())?;
        check_len("right-hand sides of the block", self.rhs, y.ncols())?;
        check_len("rows of the right-hand sides", a.nrows(), y.nrows())?;
        check_finite("the block", a)?;
        check_finite("the right-hand side", y)?;
        let numbers = [a.as_slice(), y.as_slice()].concat();
        gram_of(&mut self.whole, a.nrows(), a.nrows(), &numbers);
        self.rows += a.nrows();
        Ok(())
    }

    /// Takes in rows given one after the other, each [a_1 … a_p, y_1 … y_k].
    pub fn update_rows(&mut self, rows: &[f64]) -> Result<(), SolveError> {
        let (p, k) = (self.columns, self.rhs);
        if p + k == 0 || !rows.len().is_multiple_of(p + k) {
            let expected = (p + k) * rows.len().div_ceil((p + k).max(1));
            return Err(SolveError::Shape { what: "the slice of rows", expected, found: rows.len() });
        }
        let all = DMatrix::from_row_slice(rows.len() / (p + k), p + k, rows);
        self.update(&all.columns(0, p).into_owned(), &all.columns(p, k).into_owned())
    }

    /// Takes in rows of which only these columns are not zero, column after column, `stride` numbers from one to the next, the
    /// right-hand sides last. A number that is not finite is found by [`Gram::finish`] and [`Gram::solve_guarded`].
    pub fn update_columns(
        &mut self,
        active: &[usize],
        rows: usize,
        stride: usize,
        numbers: &[f64],
    ) -> Result<(), SolveError> {
        super::fits(self.columns, active, self.rhs, (rows, stride), numbers)?;
        self.pieces.add(
            active,
            self.columns..self.columns + self.rhs,
            rows,
            stride,
            numbers,
            &mut self.whole,
        );
        self.rows += rows;
        Ok(())
    }

    /// Takes in what another has seen.
    pub fn merge(&mut self, other: &Self) -> Result<(), SolveError> {
        check_len("columns of the other accumulator", self.columns, other.columns)?;
        check_len("right-hand sides of the other accumulator", self.rhs, other.rhs)?;
        self.pieces.flush(&mut self.whole);
        self.whole += other.flushed().as_ref();
        self.rows += other.rows;
        Ok(())
    }

    /// Brings everything to one matrix, which [`Gram::solve_guarded`] and [`Gram::finish`] otherwise do on a copy.
    pub fn flush(&mut self) {
        self.pieces.flush(&mut self.whole);
    }

    /// The whole with everything in it.
    fn flushed(&self) -> Cow<'_, DMatrix<f64>> {
        if self.pieces.is_empty() {
            return Cow::Borrowed(&self.whole);
        }
        let (mut whole, mut pieces) = (self.whole.clone(), self.pieces.clone());
        pieces.flush(&mut whole);
        Cow::Owned(whole)
    }

    /// The factor of all rows seen: G = V D Vᵀ of the equilibrated G, R from the QR of D^{1/2} Vᵀ. Directions below the
    /// resolution come out as zero.
    pub fn finish(&self) -> Result<Factor, SolveError> {
        let (p, k) = (self.columns, self.rhs);
        let whole = self.flushed();
        let size: Vec<f64> =
            (0..p).map(|i| if whole[(i, i)] > 0.0 { whole[(i, i)].sqrt() } else { 1.0 }).collect();
        let full = DMatrix::from_fn(p, p, |i, j| whole[(i.max(j), i.min(j))] / size[i] / size[j]);
        check_finite("the Gram matrix", &full)?;
        let parts = svd(&full)?;
        let floor = parts.d.first().map_or(0.0, |d| d * p as f64 * f64::EPSILON);
        let moments = DMatrix::from_fn(p, k, |i, j| whole[(p + j, i)] / size[i]);
        let turned = parts.v.tr_mul(&moments);
        let mut block = DMatrix::from_fn(p, p + k, |i, j| {
            if parts.d[i] <= floor {
                0.0
            } else if j < p {
                parts.d[i].sqrt() * parts.v[(j, i)] * size[j]
            } else {
                turned[(i, j - p)] / parts.d[i].sqrt()
            }
        });
        let mut top = DMatrix::zeros(p, p + k);
        if p > 0 {
            fold(
                MatMut::from_column_major_slice_mut(top.as_mut_slice(), p, p + k),
                MatMut::from_column_major_slice_mut(block.as_mut_slice(), p, p + k),
                &mut Reflectors::default(),
            );
        }
        let z = top.columns(p, k).into_owned();
        let rss = (0..k).map(|j| (whole[(p + j, p + j)] - z.column(j).norm_squared()).max(0.0)).collect();
        let resolution = (p.max(1) as f64 * f64::EPSILON).sqrt();
        Ok(Factor { r: top.columns(0, p).into_owned(), z, rss, rows: self.rows, resolution })
    }

    /// The stored form, independent of the machine.
    pub fn to_bytes(&self) -> Vec<u8> {
        let (p, k, whole) = (self.columns, self.rhs, self.flushed());
        let g = (0..p).flat_map(|j| (0..p).map(move |i| (i, j)));
        let mut numbers: Vec<f64> = g.map(|(i, j)| if i >= j { whole[(i, j)] } else { 0.0 }).collect();
        numbers.extend((0..k).flat_map(|j| (0..p).map(move |i| (p + j, i))).map(|at| whole[at]));
        numbers.extend((p..p + k).map(|j| whole[(j, j)]));
        write(MAGIC, &Stored { columns: p, rhs: k, rows: self.rows, numbers })
    }

    /// Reads the stored form; refuses what is cut off or altered.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, SolveError> {
        let count = |p: usize, k: usize| p.checked_mul(p)?.checked_add(p.checked_mul(k)?)?.checked_add(k);
        let Stored { columns: p, rhs: k, rows, numbers } = read(MAGIC, bytes, count)?;
        let mut made = Self::new(p, k);
        made.rows = rows;
        for j in 0..p {
            (j..p).for_each(|i| made.whole[(i, j)] = numbers[j * p + i]);
        }
        for j in 0..k {
            (0..p).for_each(|i| made.whole[(p + j, i)] = numbers[(p + j) * p + i]);
            made.whole[(p + j, p + j)] = numbers[(p + k) * p + j];
        }
        Ok(made)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::RankRule;
    use crate::accumulator::{ColumnScale, Triangular};

    fn block(rows: usize, columns: usize, seed: usize) -> DMatrix<f64> {
        DMatrix::from_fn(rows, columns, |i, j| {
            ((i * 31 + j * 17 + seed * 5 + i * j) as f64 * 0.9).sin() * 10f64.powi(3 * j as i32)
        })
    }

    #[test]
    fn agrees_with_the_triangle_and_merges() {
        let (a, y) = (block(400, 5, 1), block(400, 2, 2));
        let mut t = Triangular::new(5, 2);
        t.update(&a, &y).unwrap();
        let (mut left, mut right) = (Gram::new(5, 2), Gram::new(5, 2));
        left.update(&a.rows(0, 150).into_owned(), &y.rows(0, 150).into_owned()).unwrap();
        right.update(&a.rows(150, 250).into_owned(), &y.rows(150, 250).into_owned()).unwrap();
        left.merge(&Gram::from_bytes(&right.to_bytes()).unwrap()).unwrap();
        let (want, have) = (t.finish(), left.finish().unwrap());
        for j in 0..5 {
            assert!((want.r.column(j) - have.r.column(j)).norm() < 1e-12 * want.r.column(j).norm());
        }
        for k in 0..2 {
            assert!(
                (want.rss[k] - have.rss[k]).abs() < 1e-11 * (want.rss[k] + want.z.column(k).norm_squared())
            );
        }
        assert_eq!(left.rows(), 400);
    }

    #[test]
    fn a_dependency_survives_only_down_to_the_resolution() {
        let mut a = block(100, 3, 4);
        let sum = a.column(0) + a.column(1);
        a.set_column(2, &sum);
        let mut g = Gram::new(3, 1);
        g.update(&a, &block(100, 1, 5)).unwrap();
        let f = g.finish().unwrap();
        assert_eq!(f.rank(ColumnScale::Norms, RankRule::Default).unwrap().rank, 2);
    }

    #[test]
    fn blocks_with_some_of_the_columns_are_the_same_rows() {
        let (mut sparse, mut dense) = (Gram::new(6, 1), Gram::new(6, 1));
        for (k, active) in [[0, 2, 5], [1, 2, 4], [0, 2, 5], [3, 4, 5]].iter().enumerate() {
            let some = block(11, 4, k);
            let mut numbers = vec![f64::NAN; 4 * 16];
            (0..4).for_each(|j| numbers[16 * j..16 * j + 11].copy_from_slice(some.column(j).as_slice()));
            sparse.update_columns(active, 11, 16, &numbers).unwrap();
            let mut a = DMatrix::zeros(11, 6);
            active.iter().enumerate().for_each(|(j, &column)| a.set_column(column, &some.column(j)));
            dense.update(&a, &some.columns(3, 1).into_owned()).unwrap();
        }
        let (have, want) = (sparse.flushed(), dense.flushed());
        assert!(have.iter().zip(want.iter()).all(|(h, w)| (h - w).abs() <= 1e-14 * w.abs().max(1.0)));
        let back = Gram::from_bytes(&sparse.to_bytes()).unwrap();
        assert_eq!(back.finish().unwrap(), sparse.finish().unwrap());
        assert!(sparse.update_columns(&[6], 1, 4, &[0.0; 8]).is_err());
        assert!(sparse.update_columns(&[0], 3, 4, &[0.0; 6]).is_err());
    }
}
