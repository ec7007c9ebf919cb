//! Triangular factors of blocks in which most columns are zero, each over the columns that it has, and how they come together.
//!
//! ```text
//! [A_1 | y_1] over columns S_1,  [A_2 | y_2] over S_2, …   ⟶   R over all, columns that few blocks have first
//! ```
//!
//! Rows of one set fold into the triangle of that set, at the cost of its own width. At the end the columns are put in the order of how
//! many sets have them: a set's triangle then begins where its first column stands, and each of its rows further right, so that little is
//! filled in. It is the row-merge of sparse QR (George and Heath 1980; Liu 1986) with sets in place of an elimination tree.

use super::Triangular;
use crate::SolveError;
use crate::dense::{Reflectors, fold, norm, zeros};
use faer::MatMut;
use nalgebra::{DMatrix, DMatrixView};

/// How many sets are kept apart.
const SETS: usize = 48;

/// Rows of a triangle that are folded together.
const CHUNK: usize = 96;

/// Factors over some of the columns.
#[derive(Debug, Clone, Default)]
pub(super) struct Sets {
    list: Vec<Set>,
}

#[derive(Debug, Clone)]
struct Set {
    columns: Vec<usize>,
    rows: Triangular,
}

/// A triangle whose columns stand in another order.
pub(super) struct Ordered {
    /// p × (p + k).
    pub top: DMatrix<f64>,
    /// Norms of what no column reaches.
    pub below: Vec<f64>,
    /// The column of the problem at each place.
    pub order: Vec<usize>,
}

impl Sets {
    pub fn is_empty(&self) -> bool {
        self.list.is_empty()
    }

    /// Takes rows over these columns; a set that has to make place is returned as a triangle over all.
    pub fn take(
        &mut self,
        columns: &[usize],
        rhs: usize,
        rows: usize,
        stride: usize,
        numbers: &[f64],
    ) -> Option<Self> {
        let found = self.list.iter().position(|set| set.columns == columns);
        let (index, out) = match found {
            Some(index) => (index, None),
            None => {
                let out = (self.list.len() == SETS).then(|| Sets { list: vec![self.list.remove(0)] });
                self.list
                    .push(Set { columns: columns.to_vec(), rows: Triangular::waiting(columns.len(), rhs) });
                (self.list.len() - 1, out)
            }
        };
        self.list[index].rows.take_columns(rows, stride, numbers);
        out
    }

    /// Takes what another has seen.
    pub fn merge(&mut self, other: &Self) -> Result<(), SolveError> {
        for set in &other.list {
            match self.list.iter().position(|own| own.columns == set.columns) {
                Some(index) => self.list[index].rows.merge(&set.rows)?,
                None => self.list.push(set.clone()),
            }
        }
        Ok(())
    }

    /// All sets over a triangle (p × (p + k)) that may have seen rows of its own.
    pub fn ordered(self, top: &DMatrix<f64>, below: &[f64]) -> Ordered {
        let (p, k) = (top.nrows(), below.len());
        let mut common = vec![0_usize; p];
        self.list.iter().flat_map(|set| &set.columns).for_each(|&column| common[column] += 1);
        let mut order: Vec<usize> = (0..p).collect();
        order.sort_by_key(|&column| common[column]);
        let mut place = vec![0; p];
        order.iter().enumerate().for_each(|(at, &column)| place[column] = at);
        let mut made = Ordered { top: zeros(p, p + k), below: below.to_vec(), order };
        let mut work = Reflectors::default();
        if top.iter().any(|v| *v != 0.0) {
            let all: Vec<usize> = (0..p).collect();
            made.fold(&all, top.as_view(), true, &place, &mut work);
        }
        for Set { columns, mut rows } in self.list {
            // What is hardly taller than wide gains nothing by being folded on its own.
            match rows.raw().filter(|raw| raw.nrows() <= 2 * columns.len()) {
                Some(raw) => made.fold(&columns, raw, false, &place, &mut work),
                None => {
                    rows.flush();
                    made.below
                        .iter_mut()
                        .zip(&rows.below)
                        .for_each(|(own, of_set)| *own = own.hypot(*of_set));
                    made.fold(&columns, rows.top.as_view(), true, &place, &mut work);
                }
            }
        }
        made
    }
}

impl Ordered {
    /// Folds rows over some columns; `tall` ones are brought to a triangle in the new order first.
    fn fold(
        &mut self,
        columns: &[usize],
        rows: DMatrixView<'_, f64>,
        tall: bool,
        place: &[usize],
        work: &mut Reflectors,
    ) {
        let (n, k) = (columns.len(), self.below.len());
        let mut sorted: Vec<usize> = (0..n).collect();
        sorted.sort_by_key(|&j| place[columns[j]]);
        if !tall || n == 0 {
            return self.fold_rows((columns, &sorted), rows, (0, rows.nrows()), place, work);
        }
        let mut block = zeros(rows.nrows(), n + k);
        let taken = sorted.iter().copied().chain(n..n + k);
        taken.enumerate().for_each(|(to, from)| block.set_column(to, &rows.column(from)));
        let mut triangle = zeros(n, n + k);
        fold(view(&mut triangle), view(&mut block), work);
        self.rest(&block, n);
        let columns: Vec<usize> = sorted.iter().map(|&j| columns[j]).collect();
        let all: Vec<usize> = (0..n).collect();
        for from in (0..n).step_by(CHUNK) {
            let count = CHUNK.min(n - from);
            // Rows of a triangle begin where their own column stands.
            let part = (columns.as_slice(), &all[from..]);
            self.fold_rows(part, triangle.as_view(), (from, count), place, work);
        }
    }

    /// Folds some rows, of which only the columns `sorted` are not zero.
    fn fold_rows(
        &mut self,
        (columns, sorted): (&[usize], &[usize]),
        rows: DMatrixView<'_, f64>,
        (from, count): (usize, usize),
        place: &[usize],
        work: &mut Reflectors,
    ) {
        let k = self.below.len();
        let start = sorted.first().map_or(place.len(), |&j| place[columns[j]]);
        let width = place.len() - start;
        let mut part = zeros(count, width + k);
        for &j in sorted {
            part.set_column(place[columns[j]] - start, &rows.column(j).rows(from, count));
        }
        for j in 0..k {
            part.set_column(width + j, &rows.column(columns.len() + j).rows(from, count));
        }
        let top = view(&mut self.top).submatrix_mut(start, start, width, width + k);
        fold(top, view(&mut part), work);
        self.rest(&part, width);
    }

    /// What a block leaves of the right-hand sides.
    fn rest(&mut self, block: &DMatrix<f64>, columns: usize) {
        for (j, below) in self.below.iter_mut().enumerate() {
            let rows = block.nrows();
            *below = below.hypot(norm(&block.as_slice()[(columns + j) * rows..(columns + j + 1) * rows]));
        }
    }
}

fn view(m: &mut DMatrix<f64>) -> MatMut<'_, f64> {
    let (rows, columns) = m.shape();
    MatMut::from_column_major_slice_mut(m.as_mut_slice(), rows, columns)
}
