//! Least squares without some of the rows, as often as one likes: cross-validation of linear models from one pass over the data.
//!
//! ```text
//! (G − A_Fᵀ A_F) x_F = Aᵀy − A_Fᵀ y_F,            e_F = y_F − A_F x_F             a fold F left out
//! e_v = (I − A_v G⁻¹ A_vᵀ)⁻¹ (y_v − A_v x)                                        one group v after the other
//! ```
//!
//! | symbol | name | shape |
//! | --- | --- | --- |
//! | G = AᵀA | Gram matrix, columns brought to length one | p × p |
//! | A_v, y_v | rows of a group, which are never parted | m_v × p, m_v |
//!
//! Rows stand with those that have the same columns, so that taking a fold out costs the columns that its rows have. Source: Björck,
//! *Numerical Methods for Least Squares Problems*, §3.4; Zhang (1993) on leaving groups out. For columns that are known to be
//! independent, as [`super::Gram::solve_guarded`] has found them.

use crate::SolveError;
use crate::dense::{
    cholesky_lower, gram_of_rows, residual_of_rows, solve_lower, solve_lower_many, solve_lower_transposed,
};
use crate::problem::check_len;
use nalgebra::{DMatrix, DVector};

/// A set takes in rows with fewer columns if it has at most this many times as many.
const WIDER: usize = 3;

/// Rows by groups, and their common normal equations.
#[derive(Debug, Clone)]
pub struct LeftOut {
    columns: usize,
    clusters: Vec<Cluster>,
    /// For each group: its cluster, first row there, number of rows.
    groups: Vec<Vec<(usize, usize, usize)>>,
    /// What columns are multiplied by.
    scale: Vec<f64>,
    /// Lower triangle of [A | y]ᵀ [A | y].
    whole: DMatrix<f64>,
}

/// Rows over some of the columns, one after the other, each with its right-hand side.
#[derive(Debug, Clone)]
struct Cluster {
    columns: Vec<usize>,
    numbers: Vec<f64>,
}

impl LeftOut {
    /// Takes blocks of rows: active columns (ascending), the group of each row, and the numbers, column after column, the right-hand side last.
    ///
    /// # Errors
    /// When sizes do not fit, or a number is not finite.
    pub fn new<'b>(
        columns: usize,
        groups: usize,
        blocks: impl IntoIterator<Item = (&'b [usize], &'b [usize], &'b [f64])>,
    ) -> Result<Self, SolveError> {
        let mut blocks: Vec<_> = blocks.into_iter().collect();
        blocks.sort_by_key(|(active, ..)| std::cmp::Reverse(active.len()));
        let mut made = LeftOut {
            columns,
            clusters: Vec::new(),
            groups: vec![Vec::new(); groups],
            scale: vec![0.0; columns],
            whole: DMatrix::zeros(columns + 1, columns + 1),
        };
        for (active, group, numbers) in blocks {
            made.take(active, group, numbers)?;
        }
        made.finish()?;
        Ok(made)
    }

    fn take(&mut self, active: &[usize], group: &[usize], numbers: &[f64]) -> Result<(), SolveError> {
        let rows = group.len();
        check_len("numbers of the block", (active.len() + 1) * rows, numbers.len())?;
        if let Some(&far) = active.iter().find(|&&column| column >= self.columns) {
            return Err(SolveError::Shape { what: "the columns", expected: self.columns, found: far + 1 });
        }
        if let Some(&far) = group.iter().find(|&&group| group >= self.groups.len()) {
            return Err(SolveError::Shape {
                what: "the groups",
                expected: self.groups.len(),
                found: far + 1,
            });
        }
        let fits = |cluster: &Cluster| {
            cluster.columns.len() <= WIDER * active.len().max(1)
                && active.iter().all(|column| cluster.columns.binary_search(column).is_ok())
        };
        let at = match self.clusters.iter().rposition(fits) {
            Some(at) => at,
            None => {
                self.clusters.push(Cluster { columns: active.to_vec(), numbers: Vec::new() });
                self.clusters.len() - 1
            }
        };
        let cluster = &mut self.clusters[at];
        let width = cluster.columns.len() + 1;
        let places: Vec<usize> = active
            .iter()
            .filter_map(|column| cluster.columns.binary_search(column).ok())
            .chain([width - 1])
            .collect();
        let first = cluster.numbers.len() / width;
        cluster.numbers.resize((first + rows) * width, 0.0);
        for (from, place) in numbers.chunks_exact(rows.max(1)).zip(places) {
            for (row, value) in from.iter().enumerate() {
                cluster.numbers[(first + row) * width + place] = *value;
            }
        }
        for (row, &group) in group.iter().enumerate() {
            match self.groups[group].last_mut() {
                Some((cluster, start, count)) if *cluster == at && *start + *count == first + row => {
                    *count += 1
                }
                _ => self.groups[group].push((at, first + row, 1)),
            }
        }
        Ok(())
    }

    /// Lengths of the columns, and the whole.
    fn finish(&mut self) -> Result<(), SolveError> {
        for cluster in &self.clusters {
            for row in cluster.numbers.chunks_exact(cluster.columns.len() + 1) {
                cluster.columns.iter().zip(row).for_each(|(&column, v)| self.scale[column] += v * v);
            }
        }
        if let Some(column) = self.scale.iter().position(|s| !s.is_finite()) {
            return Err(SolveError::NotFinite { what: "the rows", row: 0, column });
        }
        self.scale.iter_mut().for_each(|s| *s = if *s > 0.0 { 1.0 / s.sqrt() } else { 1.0 });
        let mut work = DMatrix::zeros(0, 0);
        for k in 0..self.clusters.len() {
            let Cluster { columns, numbers } = &mut self.clusters[k];
            for row in numbers.chunks_exact_mut(columns.len() + 1) {
                columns.iter().zip(row).for_each(|(&column, v)| *v *= self.scale[column]);
            }
            scatter(columns, numbers, 1.0, &mut self.whole, &mut work);
        }
        Ok(())
    }

    /// Number of groups.
    pub fn groups(&self) -> usize {
        self.groups.len()
    }

    /// What is left of the rows of some groups when they are left out: group after group, in the order in which their rows came. None where
    /// the others do not determine the unknowns.
    pub fn without(&self, out: &[usize]) -> Option<Vec<f64>> {
        let (mut rest, mut work) = (self.whole.clone(), DMatrix::zeros(0, 0));
        let mut gathered: Vec<Vec<f64>> = vec![Vec::new(); self.clusters.len()];
        for &(cluster, start, count) in out.iter().flat_map(|&group| &self.groups[group]) {
            let width = self.clusters[cluster].columns.len() + 1;
            gathered[cluster]
                .extend_from_slice(&self.clusters[cluster].numbers[start * width..(start + count) * width]);
        }
        for (cluster, numbers) in self.clusters.iter().zip(&gathered) {
            scatter(&cluster.columns, numbers, -1.0, &mut rest, &mut work);
        }
        let p = self.columns;
        let moments: Vec<f64> = (0..p).map(|column| rest[(p, column)]).collect();
        let l = cholesky_lower(rest, p)?;
        let x = solve_lower_transposed(&l, solve_lower(&l, &moments).as_slice());
        let mut left: Vec<std::vec::IntoIter<f64>> = self
            .clusters
            .iter()
            .zip(&gathered)
            .map(|(c, numbers)| c.residuals(numbers, &x).into_iter())
            .collect();
        let runs = out.iter().flat_map(|&group| &self.groups[group]);
        Some(
            runs.flat_map(|&(cluster, _, count)| left[cluster].by_ref().take(count).collect::<Vec<f64>>())
                .collect(),
        )
    }

    /// What is left of each group's rows when it alone is left out, group after group.
    ///
    /// # Errors
    /// When the rows do not determine the unknowns, or would not without one of the groups.
    pub fn one_by_one(&self) -> Result<Vec<Vec<f64>>, SolveError> {
        let p = self.columns;
        let broken =
            || SolveError::Breakdown { what: "leaving a group out", rows: self.groups.len(), columns: p };
        let moments: Vec<f64> = (0..p).map(|column| self.whole[(p, column)]).collect();
        let l = cholesky_lower(self.whole.clone(), p).ok_or_else(broken)?;
        let x = solve_lower_transposed(&l, solve_lower(&l, &moments).as_slice());
        let mut all = Vec::with_capacity(self.groups.len());
        // Some groups at a time: L⁻¹ A_vᵀ of all of them in one go.
        for groups in self.groups.chunks(32) {
            let rows: usize = groups.iter().flatten().map(|run| run.2).sum();
            let mut turned = DMatrix::zeros(p, rows);
            let mut left = Vec::with_capacity(rows);
            for &(cluster, start, count) in groups.iter().flatten() {
                let Cluster { columns, numbers } = &self.clusters[cluster];
                let width = columns.len() + 1;
                let numbers = &numbers[start * width..(start + count) * width];
                for (row, values) in numbers.chunks_exact(width).enumerate() {
                    let into = &mut turned.as_mut_slice()[(left.len() + row) * p..][..p];
                    columns.iter().zip(values).for_each(|(&column, v)| into[column] = *v);
                }
                left.extend(self.clusters[cluster].residuals(numbers, &x));
            }
            solve_lower_many(&l, &mut turned);
            let mut first = 0;
            for group in groups {
                let count: usize = group.iter().map(|run| run.2).sum();
                let v = turned.columns(first, count);
                let mut rest = DMatrix::identity(count, count);
                rest.gemm_tr(-1.0, &v, &v, 1.0);
                let own = DVector::from_column_slice(&left[first..first + count]);
                all.push(rest.cholesky().ok_or_else(broken)?.solve(&own).as_slice().to_vec());
                first += count;
            }
        }
        Ok(all)
    }
}

impl Cluster {
    fn residuals(&self, numbers: &[f64], x: &DVector<f64>) -> Vec<f64> {
        let own: Vec<f64> = self.columns.iter().map(|&column| x[column]).collect();
        residual_of_rows(&own, numbers)
    }
}

/// Adds ± BᵀB of rows over some columns to the lower triangle of the whole; the right-hand side is its last row.
fn scatter(columns: &[usize], numbers: &[f64], sign: f64, whole: &mut DMatrix<f64>, work: &mut DMatrix<f64>) {
    let (width, stride) = (columns.len() + 1, whole.nrows());
    if numbers.is_empty() {
        return;
    }
    if width == stride {
        gram_of_rows(whole, numbers, sign);
        return;
    }
    if work.nrows() != width {
        *work = DMatrix::zeros(width, width);
    }
    work.fill(0.0);
    gram_of_rows(work, numbers, sign);
    let last = stride - 1;
    let place = |k: usize| columns.get(k).copied().unwrap_or(last);
    let (into, from) = (whole.as_mut_slice(), work.as_slice());
    for j in 0..width {
        let column = &mut into[place(j) * stride..][..stride];
        for i in j..width {
            column[place(i)] += from[j * width + i];
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Rows of six groups over two sets of columns, and the same as one matrix.
    fn rows() -> (LeftOut, DMatrix<f64>, DVector<f64>, Vec<usize>) {
        let value = |i: usize, j: usize| ((i * 31 + j * 17 + i * j * 7) as f64 * 0.9).sin();
        let sets: [(&[usize], usize); 3] = [(&[0, 2, 4], 14), (&[0, 1, 2, 3, 4], 22), (&[2, 4], 9)];
        let (mut blocks, mut a, mut y, mut groups) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
        for (k, (active, count)) in sets.iter().enumerate() {
            let group: Vec<usize> = (0..*count).map(|row| row * 6 / count).collect();
            let numbers: Vec<f64> =
                (0..=active.len()).flat_map(|j| (0..*count).map(move |i| value(i + 50 * k, j))).collect();
            for row in 0..*count {
                let mut full = [0.0; 5];
                active.iter().enumerate().for_each(|(j, &column)| full[column] = numbers[j * count + row]);
                a.extend(full);
                y.push(numbers[active.len() * count + row]);
                groups.push(group[row]);
            }
            blocks.push((*active, group, numbers));
        }
        let views = blocks.iter().map(|(a, g, n)| (*a, g.as_slice(), n.as_slice()));
        let made = LeftOut::new(5, 6, views).unwrap();
        let count = y.len();
        (made, DMatrix::from_row_slice(count, 5, &a), DVector::from_vec(y), groups)
    }

    /// Squares of what is left of these groups by a fit that has not seen them.
    fn by_hand(a: &DMatrix<f64>, y: &DVector<f64>, groups: &[usize], out: &[usize]) -> f64 {
        let (left, kept): (Vec<usize>, Vec<usize>) =
            (0..y.len()).partition(|&row| out.contains(&groups[row]));
        let x = a.select_rows(&kept).svd(true, true).solve(&y.select_rows(&kept), 1e-12).unwrap();
        (y.select_rows(&left) - a.select_rows(&left) * x).norm_squared()
    }

    #[test]
    fn what_is_left_is_that_of_fits_without() {
        let (made, a, y, groups) = rows();
        let squares = |left: &[f64]| left.iter().map(|v| v * v).sum::<f64>();
        for out in [vec![0, 3], vec![5], vec![4, 1, 2]] {
            let left = made.without(&out).unwrap();
            assert_eq!(left.len(), groups.iter().filter(|g| out.contains(g)).count());
            assert!((squares(&left) / by_hand(&a, &y, &groups, &out) - 1.0).abs() < 1e-10, "{out:?}");
        }
        for (group, left) in made.one_by_one().unwrap().iter().enumerate() {
            assert!((squares(left) / by_hand(&a, &y, &groups, &[group]) - 1.0).abs() < 1e-10, "{group}");
        }
        assert!(made.without(&[0, 1, 2, 3, 4, 5]).is_none(), "nothing is left to fit");
    }

    #[test]
    fn what_does_not_fit_is_refused() {
        let one = |active: &[usize], group: &[usize], numbers: &[f64]| {
            LeftOut::new(2, 1, [(active, group, numbers)]).is_err()
        };
        assert!(one(&[0, 2], &[0], &[1.0; 3]) && one(&[0], &[1], &[1.0; 2]) && one(&[0], &[0], &[1.0; 3]));
        assert!(one(&[0], &[0], &[f64::NAN, 1.0]));
    }
}
