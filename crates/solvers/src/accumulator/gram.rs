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

use super::Factor;
use super::bytes::{Stored, read, write};
use super::triangular::check_finite;
use crate::SolveError;
use crate::dense::{Reflectors, fold, gram, svd};
use crate::problem::check_len;
use faer::MatMut;
use nalgebra::DMatrix;

const MAGIC: [u8; 4] = *b"TPGR";

/// AᵀA, AᵀY and the squares of Y over a stream of rows.
#[derive(Debug, Clone)]
pub struct Gram {
    /// Lower triangle of G.
    g: DMatrix<f64>,
    h: DMatrix<f64>,
    q: Vec<f64>,
    rows: usize,
}

impl Gram {
    /// An empty accumulator of `columns` unknowns and `rhs` right-hand sides.
    pub fn new(columns: usize, rhs: usize) -> Self {
        Self {
            g: DMatrix::zeros(columns, columns),
            h: DMatrix::zeros(columns, rhs),
            q: vec![0.0; rhs],
            rows: 0,
        }
    }

    /// Number of rows seen.
    pub fn rows(&self) -> usize {
        self.rows
    }

    /// Takes in rows of A and the same rows of Y.
    pub fn update(&mut self, a: &DMatrix<f64>, y: &DMatrix<f64>) -> Result<(), SolveError> {
        check_len("columns of the block", self.h.nrows(), a.ncols())?;
        check_len("right-hand sides of the block", self.h.ncols(), y.ncols())?;
        check_len("rows of the right-hand sides", a.nrows(), y.nrows())?;
        check_finite("the block", a)?;
        check_finite("the right-hand side", y)?;
        gram(&mut self.g, a);
        self.h += a.tr_mul(y);
        for (q, column) in self.q.iter_mut().zip(y.column_iter()) {
            *q += column.norm_squared();
        }
        self.rows += a.nrows();
        Ok(())
    }

    /// Takes in rows given one after the other, each [a_1 … a_p, y_1 … y_k].
    pub fn update_rows(&mut self, rows: &[f64]) -> Result<(), SolveError> {
        let (p, k) = self.h.shape();
        if p + k == 0 || !rows.len().is_multiple_of(p + k) {
            let expected = (p + k) * rows.len().div_ceil((p + k).max(1));
            return Err(SolveError::Shape { what: "the slice of rows", expected, found: rows.len() });
        }
        let all = DMatrix::from_row_slice(rows.len() / (p + k), p + k, rows);
        self.update(&all.columns(0, p).into_owned(), &all.columns(p, k).into_owned())
    }

    /// Takes in what another has seen.
    pub fn merge(&mut self, other: &Self) -> Result<(), SolveError> {
        check_len("columns of the other accumulator", self.h.nrows(), other.h.nrows())?;
        check_len("right-hand sides of the other accumulator", self.h.ncols(), other.h.ncols())?;
        self.g += &other.g;
        self.h += &other.h;
        self.q.iter_mut().zip(&other.q).for_each(|(q, o)| *q += o);
        self.rows += other.rows;
        Ok(())
    }

    /// The factor of all rows seen: G = V D Vᵀ of the equilibrated G, R from the QR of D^{1/2} Vᵀ. Directions below the
    /// resolution come out as zero.
    pub fn finish(&self) -> Result<Factor, SolveError> {
        let (p, k) = self.h.shape();
        let size: Vec<f64> =
            self.g.diagonal().iter().map(|g| if *g > 0.0 { g.sqrt() } else { 1.0 }).collect();
        let full = DMatrix::from_fn(p, p, |i, j| self.g[(i.max(j), i.min(j))] / size[i] / size[j]);
        check_finite("the Gram matrix", &full)?;
        let parts = svd(&full)?;
        let floor = parts.d.first().map_or(0.0, |d| d * p as f64 * f64::EPSILON);
        let moments = DMatrix::from_fn(p, k, |i, j| self.h[(i, j)] / size[i]);
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
        let rss = self.q.iter().enumerate().map(|(j, q)| (q - z.column(j).norm_squared()).max(0.0)).collect();
        let resolution = (p.max(1) as f64 * f64::EPSILON).sqrt();
        Ok(Factor { r: top.columns(0, p).into_owned(), z, rss, rows: self.rows, resolution })
    }

    /// The stored form, independent of the machine.
    pub fn to_bytes(&self) -> Vec<u8> {
        let numbers = [self.g.as_slice(), self.h.as_slice(), &self.q].concat();
        write(MAGIC, &Stored { columns: self.h.nrows(), rhs: self.h.ncols(), rows: self.rows, numbers })
    }

    /// Reads the stored form; refuses what is cut off or altered.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, SolveError> {
        let count = |p: usize, k: usize| p.checked_mul(p)?.checked_add(p.checked_mul(k)?)?.checked_add(k);
        let Stored { columns: p, rhs: k, rows, numbers } = read(MAGIC, bytes, count)?;
        Ok(Self {
            g: DMatrix::from_column_slice(p, p, &numbers[..p * p]),
            h: DMatrix::from_column_slice(p, k, &numbers[p * p..p * (p + k)]),
            q: numbers[p * (p + k)..].to_vec(),
            rows,
        })
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
}
