//! Gram matrices of blocks in which most columns are zero, each over the columns that it has.
//!
//! Blocks with the same columns share a matrix, which comes to the whole only when another one needs its place: so that a
//! block costs the square of the columns that it has, and not of those that there are.

use crate::dense::gram_of;
use nalgebra::DMatrix;
use std::ops::Range;

/// How many sets of columns are kept apart.
const SETS: usize = 48;

/// Gram matrices over some of the columns, right-hand sides among them.
#[derive(Debug, Clone, Default)]
pub(super) struct Pieces {
    sets: Vec<Piece>,
}

#[derive(Debug, Clone)]
struct Piece {
    /// Columns of the whole; those of the right-hand sides come last.
    columns: Vec<usize>,
    /// Lower triangle.
    g: DMatrix<f64>,
}

impl Pieces {
    pub fn is_empty(&self) -> bool {
        self.sets.is_empty()
    }

    /// Adds `rows` rows of these columns, `stride` numbers from one column to the next; what has to make place goes to `whole`.
    pub fn add(
        &mut self,
        columns: &[usize],
        rhs: Range<usize>,
        rows: usize,
        stride: usize,
        numbers: &[f64],
        whole: &mut DMatrix<f64>,
    ) {
        let at = match self
            .sets
            .iter()
            .position(|piece| piece.columns[..piece.columns.len() - rhs.len()] == *columns)
        {
            Some(at) => at,
            None => {
                if self.sets.len() == SETS {
                    self.sets.remove(0).into_whole(whole);
                }
                let columns: Vec<usize> = columns.iter().copied().chain(rhs).collect();
                let g = DMatrix::zeros(columns.len(), columns.len());
                self.sets.push(Piece { columns, g });
                self.sets.len() - 1
            }
        };
        gram_of(&mut self.sets[at].g, rows, stride, numbers);
    }

    /// Everything goes to the whole, in the order in which the sets first came.
    pub fn flush(&mut self, whole: &mut DMatrix<f64>) {
        self.sets.drain(..).for_each(|piece| piece.into_whole(whole));
    }
}

impl Piece {
    fn into_whole(self, whole: &mut DMatrix<f64>) {
        let (size, stride) = (self.columns.len(), whole.nrows());
        let whole = whole.as_mut_slice();
        for (j, (&column, from)) in self.columns.iter().zip(self.g.as_slice().chunks_exact(size)).enumerate()
        {
            for (&row, value) in self.columns[j..].iter().zip(&from[j..]) {
                whole[row.max(column) + stride * row.min(column)] += value;
            }
        }
    }
}
