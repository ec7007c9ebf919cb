//! The mergeable triangular factor of [A | Y].
//!
//! [A | Y] = Q [R Z; 0 E],  with ‖E_k‖ the part of Y_k that no column reaches
//!
//! | symbol | name | shape | unit |
//! | --- | --- | --- | --- |
//! | A, Y | rows seen so far | m × p, m × k | as given |
//! | R, Z | triangle and Qᵀ Y | p × p, p × k | as given |
//!
//! Source: Demmel, Grigori, Hoemmen and Langou (2012). Rows are kept in a buffer and folded in blocks.

mod sets;

use super::Factor;
use super::bytes::{Stored, read, write};
use crate::dense::{Reflectors, fold, norm, zeros};
use crate::problem::check_len;
use crate::{LeastSquares, SolveError};
use faer::MatMut;
use nalgebra::{DMatrix, DMatrixView};
use sets::{Ordered, Sets};

const MAGIC: [u8; 4] = *b"TPTR";

/// Rows for which there is room at least.
const LEAST_ROOM: usize = 128;

/// Triangular factor of a stream of rows, in constant memory.
#[derive(Debug, Clone)]
pub struct Triangular {
    columns: usize,
    rhs: usize,
    rows: usize,
    /// p × (p + k), upper triangular.
    top: DMatrix<f64>,
    /// ‖E_k‖.
    below: Vec<f64>,
    /// Rows not folded yet, capacity × (p + k).
    buffer: DMatrix<f64>,
    filled: usize,
    work: Reflectors,
    /// Rows over some of the columns.
    sets: Sets,
}

impl Triangular {
    /// An empty factor of `columns` unknowns and `rhs` right-hand sides.
    pub fn new(columns: usize, rhs: usize) -> Self {
        let width = columns + rhs;
        Self {
            columns,
            rhs,
            rows: 0,
            top: zeros(columns, width),
            below: vec![0.0; rhs],
            buffer: DMatrix::zeros(0, 0),
            filled: 0,
            work: Reflectors::default(),
            sets: Sets::default(),
        }
    }

    /// One that has seen the rows of a factor.
    pub fn of(factor: &Factor) -> Self {
        let mut made = Self::new(factor.columns(), factor.z.ncols());
        made.top.columns_mut(0, made.columns).copy_from(&factor.r);
        made.top.columns_mut(made.columns, made.rhs).copy_from(&factor.z);
        made.below = factor.rss.iter().map(|rss| rss.sqrt()).collect();
        made.rows = factor.rows;
        made
    }

    /// The same without memory for the triangle until rows are folded.
    fn waiting(columns: usize, rhs: usize) -> Self {
        Self { top: DMatrix::zeros(0, 0), columns, ..Self::new(0, rhs) }
    }

    /// Number of rows seen.
    pub fn rows(&self) -> usize {
        self.rows
    }

    /// Takes in rows of A and the same rows of Y.
    pub fn update(&mut self, a: &DMatrix<f64>, y: &DMatrix<f64>) -> Result<(), SolveError> {
        check_len("columns of the block", self.columns, a.ncols())?;
        check_len("right-hand sides of the block", self.rhs, y.ncols())?;
        check_len("rows of the right-hand sides", a.nrows(), y.nrows())?;
        check_finite("the block", a)?;
        check_finite("the right-hand side", y)?;
        self.take(a.nrows(), |i, j| if j < a.ncols() { a[(i, j)] } else { y[(i, j - a.ncols())] });
        Ok(())
    }

    /// Takes in rows of [A | Y] at once, in the memory in which they are.
    pub fn update_block(&mut self, mut block: DMatrix<f64>) -> Result<(), SolveError> {
        check_len("columns of the block", self.columns + self.rhs, block.ncols())?;
        check_finite("the block", &block)?;
        self.take_block(&mut block);
        Ok(())
    }

    /// Takes in rows given one after the other, each [a_1 … a_p, y_1 … y_k]. Allocates nothing.
    pub fn update_rows(&mut self, rows: &[f64]) -> Result<(), SolveError> {
        let width = self.columns + self.rhs;
        if width == 0 || !rows.len().is_multiple_of(width) {
            let expected = width * rows.len().div_ceil(width.max(1));
            return Err(SolveError::Shape { what: "the slice of rows", expected, found: rows.len() });
        }
        if let Some(at) = rows.iter().position(|v| !v.is_finite()) {
            return Err(SolveError::NotFinite { what: "the block", row: at / width, column: at % width });
        }
        self.take(rows.len() / width, |i, j| rows[i * width + j]);
        Ok(())
    }

    /// Takes in rows of which only these columns, ascending, are not zero: column after column, `stride` numbers from one to the next, the right-hand
    /// sides last. Costs the width of the block and not that of the whole.
    pub fn update_columns(
        &mut self,
        active: &[usize],
        rows: usize,
        stride: usize,
        numbers: &[f64],
    ) -> Result<(), SolveError> {
        let width = active.len() + self.rhs;
        super::fits(self.columns, active, self.rhs, (rows, stride), numbers)?;
        if rows == 0 {
            return Ok(());
        }
        for column in 0..width {
            let column_of = &numbers[column * stride..][..rows];
            if !column_of.iter().fold(true, |all, v| all & v.is_finite()) {
                let row = column_of.iter().position(|v| !v.is_finite()).unwrap_or(0);
                return Err(SolveError::NotFinite { what: "the block", row, column });
            }
        }
        if let Some(out) = self.sets.take(active, self.rhs, rows, stride, numbers) {
            self.flush();
            self.natural(out);
        }
        self.rows += rows;
        Ok(())
    }

    /// Brings sets to the triangle over all columns, in their own order.
    fn natural(&mut self, sets: Sets) {
        let Ordered { top, below, order } = sets.ordered(&self.top, &self.below);
        let (p, width) = (self.columns, self.columns + self.rhs);
        let mut block = zeros(p, width);
        order.iter().enumerate().for_each(|(at, &column)| block.set_column(column, &top.column(at)));
        (p..width).for_each(|j| block.set_column(j, &top.column(j)));
        self.top = zeros(p, width);
        self.below = below;
        self.fold_in(&mut block, p);
    }

    /// Rows that wait, where none has been folded yet.
    fn raw(&self) -> Option<DMatrixView<'_, f64>> {
        (self.filled == self.rows).then(|| self.buffer.view((0, 0), (self.filled, self.buffer.ncols())))
    }

    /// The factor of all rows seen, with its columns in the order that is cheapest, and that order: the problem's column at each place.
    pub fn into_factor_in_any_order(mut self) -> (Factor, Vec<usize>) {
        if self.sets.is_empty() {
            let columns = self.columns;
            return (self.into_factor(), (0..columns).collect());
        }
        self.flush();
        let Ordered { top, below, order } = std::mem::take(&mut self.sets).ordered(&self.top, &self.below);
        (self.top, self.below) = (top, below);
        (self.into_factor(), order)
    }

    /// Takes in what another has seen.
    pub fn merge(&mut self, other: &Self) -> Result<(), SolveError> {
        check_len("columns of the other accumulator", self.columns, other.columns)?;
        check_len("right-hand sides of the other accumulator", self.rhs, other.rhs)?;
        self.flush();
        self.sets.merge(&other.sets)?;
        let mut other = other.clone();
        other.flush();
        if !other.top.is_empty() {
            self.fold_in(&mut other.top, self.columns);
        }
        for (below, theirs) in self.below.iter_mut().zip(other.below) {
            *below = below.hypot(theirs);
        }
        self.rows += other.rows;
        Ok(())
    }

    /// The factor of all rows seen; the accumulator can go on.
    pub fn finish(&self) -> Factor {
        self.clone().into_factor()
    }

    /// The factor of all rows seen.
    pub fn into_factor(mut self) -> Factor {
        self.flush();
        let sets = std::mem::take(&mut self.sets);
        if !sets.is_empty() {
            self.natural(sets);
        }
        let z = self.top.columns(self.columns, self.rhs).into_owned();
        Factor {
            r: self.top.remove_columns(self.columns, self.rhs),
            z,
            rss: self.below.iter().map(|b| b * b).collect(),
            rows: self.rows,
            resolution: f64::EPSILON,
        }
    }

    /// The stored form, independent of the machine.
    pub fn to_bytes(&self) -> Vec<u8> {
        let mut done = self.clone();
        done.flush();
        let sets = std::mem::take(&mut done.sets);
        if !sets.is_empty() {
            done.natural(sets);
        }
        let mut numbers = done.top.as_slice().to_vec();
        numbers.extend_from_slice(&done.below);
        write(MAGIC, &Stored { columns: self.columns, rhs: self.rhs, rows: self.rows, numbers })
    }

    /// Reads the stored form; refuses what is cut off or altered.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, SolveError> {
        let count = |p: usize, k: usize| p.checked_mul(p.checked_add(k)?)?.checked_add(k);
        let stored = read(MAGIC, bytes, count)?;
        let mut made = Self::new(stored.columns, stored.rhs);
        let (top, below) = stored.numbers.split_at(stored.numbers.len() - stored.rhs);
        made.top.as_mut_slice().copy_from_slice(top);
        made.below.copy_from_slice(below);
        made.rows = stored.rows;
        Ok(made)
    }

    /// Folds finite rows of [A | Y] in at once; overwrites them.
    pub(crate) fn take_block(&mut self, block: &mut DMatrix<f64>) {
        self.flush();
        self.rows += block.nrows();
        self.fold_in(block, block.nrows());
    }

    /// Takes in the weighted rows of a problem that has been validated.
    pub(crate) fn take_problem(&mut self, problem: &LeastSquares<'_>) {
        let (a, y) = (problem.a, problem.y);
        match problem.weights {
            None => self.take(a.nrows(), |i, j| if j < a.ncols() { a[(i, j)] } else { y[i] }),
            Some(weights) => {
                let roots: Vec<f64> = weights.iter().map(|w| w.sqrt()).collect();
                self.take(a.nrows(), |i, j| roots[i] * if j < a.ncols() { a[(i, j)] } else { y[i] });
            }
        }
    }

    /// Room for some more rows: little at first, since many triangles wait side by side, and no more than is folded well at once.
    fn reserve(&mut self, rows: usize) {
        let width = self.columns + self.rhs;
        let most = (2 * width).clamp(256, 2048);
        let height = self.buffer.nrows();
        if height == most || self.filled + rows <= height {
            return;
        }
        let taller = (self.filled + rows).next_multiple_of(LEAST_ROOM).max(2 * height).min(most);
        let mut buffer = zeros(taller, width);
        if self.filled > 0 {
            buffer.rows_mut(0, self.filled).copy_from(&self.buffer.rows(0, self.filled));
        }
        self.buffer = buffer;
    }

    /// Rows of all columns, column after column.
    fn take_columns(&mut self, rows: usize, stride: usize, numbers: &[f64]) {
        self.reserve(rows);
        let (height, mut from) = (self.buffer.nrows(), 0);
        while from < rows {
            let many = (height - self.filled).min(rows - from);
            for (into, column) in
                self.buffer.as_mut_slice().chunks_exact_mut(height).zip(numbers.chunks(stride))
            {
                into[self.filled..self.filled + many].copy_from_slice(&column[from..from + many]);
            }
            self.filled += many;
            from += many;
            if self.filled == height {
                self.flush();
            }
        }
        self.rows += rows;
    }

    fn take(&mut self, rows: usize, at: impl Fn(usize, usize) -> f64) {
        self.reserve(rows);
        let (height, mut from) = (self.buffer.nrows(), 0);
        while from < rows {
            let many = (height - self.filled).min(rows - from);
            for (j, column) in self.buffer.as_mut_slice().chunks_exact_mut(height).enumerate() {
                for (i, value) in column[self.filled..self.filled + many].iter_mut().enumerate() {
                    *value = at(from + i, j);
                }
            }
            self.filled += many;
            from += many;
            if self.filled == height {
                self.flush();
            }
        }
        self.rows += rows;
    }

    fn flush(&mut self) {
        if self.filled == 0 {
            return;
        }
        let mut buffer = std::mem::replace(&mut self.buffer, DMatrix::zeros(0, 0));
        self.fold_in(&mut buffer, self.filled);
        self.buffer = buffer;
        self.filled = 0;
    }

    /// Folds the first `rows` rows of `block`, which it overwrites.
    fn fold_in(&mut self, block: &mut DMatrix<f64>, rows: usize) {
        let (p, width, stride) = (self.columns, self.columns + self.rhs, block.nrows());
        if rows == 0 || width == 0 {
            return;
        }
        if self.top.is_empty() {
            self.top = zeros(p, width);
        }
        let top = MatMut::from_column_major_slice_mut(self.top.as_mut_slice(), p, width);
        let view = MatMut::from_column_major_slice_with_stride_mut(block.as_mut_slice(), rows, width, stride);
        fold(top, view, &mut self.work);
        for (k, below) in self.below.iter_mut().enumerate() {
            let from = (p + k) * stride;
            *below = below.hypot(norm(&block.as_slice()[from..from + rows]));
        }
    }
}

impl Factor {
    /// The factor of some of the columns.
    pub fn select(&self, columns: &[usize]) -> Self {
        let (p, k) = (columns.len(), self.z.ncols());
        let mut block = DMatrix::zeros(self.columns(), p + k);
        columns.iter().enumerate().for_each(|(to, from)| block.set_column(to, &self.r.column(*from)));
        (0..k).for_each(|j| block.set_column(p + j, &self.z.column(j)));
        let mut part = Triangular::new(p, k);
        part.take_block(&mut block);
        let mut factor = part.finish();
        factor.rss.iter_mut().zip(&self.rss).for_each(|(new, old)| *new += old);
        Self { rows: self.rows, resolution: self.resolution, ..factor }
    }
}

pub(super) fn check_finite(what: &'static str, m: &DMatrix<f64>) -> Result<(), SolveError> {
    match m.iter().position(|v| !v.is_finite()) {
        Some(at) => Err(SolveError::NotFinite { what, row: at % m.nrows(), column: at / m.nrows() }),
        None => Ok(()),
    }
}

#[cfg(test)]
mod tests;
