//! Least squares, reduction and covariance of ten ill-conditioned problems against digits from mpmath (`reference/make.py`).
//!
//! | symbol | here | of |
//! | --- | --- | --- |
//! | κ | `condition` | largest over smallest singular value, columns of unit length |
//! | ε | `f64::EPSILON` | 2.2e-16 |
//! | error | of a solution, of a relation | ‖x − x*‖ / ‖x*‖, in columns of unit length |
//! | | of a covariance | largest entry of C − C* over largest of C*, in columns of unit length |
//!
//! What a backward stable method can promise is a small multiple of κ ε, where the residual is small; normal equations lose κ² ε.

use crate::prelude::*;
use truepose_identify::reduction::echelon;
use truepose_solvers::accumulator::{ColumnScale, Triangular};
use truepose_solvers::{RankRule, SolveError, Svd};

/// One problem's errors.
#[derive(Debug, Clone, PartialEq)]
pub struct Precision {
    pub name: String,
    pub condition: f64,
    pub qr: f64,
    pub svd: f64,
    pub covariance: f64,
    /// Of the problem with a column that depends on the others: its rank less what it should be, and the error of the relation.
    pub rank: i64,
    pub relation: f64,
}

/// Errors in multiples of κ ε that are promised.
#[cfg(test)]
const PROMISED: f64 = 50.0;

/// All ten problems.
pub fn all() -> Result<Vec<Precision>, SolveError> {
    let problems = [
        ("hilbert_4", hilbert(10, 4)),
        ("hilbert_6", hilbert(12, 6)),
        ("hilbert_8", hilbert(14, 8)),
        ("powers_6", powers(41, 6)),
        ("powers_9", powers(65, 9)),
        ("laeuchli_2e-13", laeuchli(5, 2f64.powi(-13))),
        ("laeuchli_2e-24", laeuchli(5, 2f64.powi(-24))),
        ("alike_2e-20", alike(30, 6, 2f64.powi(-20))),
        ("alike_2e-32", alike(30, 6, 2f64.powi(-32))),
        ("graded", graded(30, 6)),
    ];
    let grade = |name: &str| if name == "graded" { 4096.0 } else { 1.0 };
    problems.into_iter().map(|(name, a)| judged(name, &a, grade(name))).collect()
}

/// `grade`: of which columns are the smaller, one after the other.
fn judged(name: &str, a: &DMatrix<f64>, grade: f64) -> Result<Precision, SolveError> {
    let (m, n) = a.shape();
    let mut y = DVector::zeros(m);
    for i in 0..m {
        for j in 0..n {
            y[i] += a[(i, j)] * (j % 3 + 1) as f64;
        }
    }
    let size = DVector::from_fn(n, |j, _| a.column(j).norm());
    let off = |x: &DVector<f64>, what: &str| {
        let want = DVector::from_vec(digits(name, what));
        (x - &want).component_mul(&size).norm() / want.component_mul(&size).norm()
    };
    let problem = LeastSquares::new(a, &y);
    let mut triangle = Triangular::new(n, 1);
    triangle.update(a, &DMatrix::from_column_slice(m, 1, y.as_slice()))?;
    let covariance = triangle.finish().inverse_gram().unwrap_or_else(|| DMatrix::zeros(n, n));
    let want = DMatrix::from_row_slice(n, n, &digits(name, "covariance"));
    let unit = |c: &DMatrix<f64>| DMatrix::from_fn(n, n, |i, j| size[i] * size[j] * c[(i, j)]);

    let mut more = a.clone().insert_column(n, 0.0);
    for i in 0..m {
        more[(i, n)] = a[(i, 0)] + 2.0 * grade * a[(i, 1)] - grade * grade * a[(i, 2)];
    }
    let mut triangle = Triangular::new(n + 1, 1);
    triangle.update(&more, &DMatrix::zeros(m, 1))?;
    let null = triangle.finish().null_space(ColumnScale::Norms, RankRule::Default)?;
    let order: Vec<usize> = (0..=n).collect();
    let form = echelon(&null.basis, &order);
    let relation = match form.dropped.as_slice() {
        [last] if *last == n => {
            let unscaled = |j: usize| form.relations[(0, j)] * null.scale[j] / null.scale[n];
            off(&DVector::from_fn(n, |j, _| unscaled(j)), "relation")
        }
        _ => f64::INFINITY,
    };
    Ok(Precision {
        name: name.into(),
        condition: digits(name, "condition")[0],
        qr: off(&PivotedQr::default().solve(&problem)?.x, "solution"),
        svd: off(&Svd::default().solve(&problem)?.x, "solution"),
        covariance: (unit(&covariance) - unit(&want)).amax() / unit(&want).amax(),
        rank: null.decision.rank as i64 - n as i64,
        relation,
    })
}

/// As a table.
pub fn table(problems: &[Precision]) -> String {
    let mut table =
        Table::markdown("problem|κ|κ ε|least squares, qr|svd|covariance|rank|relations of the reduction");
    for p in problems {
        let rank = if p.rank == 0 { "right".to_owned() } else { format!("{:+}", p.rank) };
        let numbers = [p.condition, p.condition * f64::EPSILON, p.qr, p.svd, p.covariance, p.relation];
        let [condition, floor, qr, svd, covariance, relation] = numbers.map(|v| format!("{v:.1e}"));
        table.row(&[&p.name, &condition, &floor, &qr, &svd, &covariance, &rank, &relation]);
    }
    table.text()
}

fn digits(name: &str, what: &str) -> Vec<f64> {
    let head = format!("{name} {what} ");
    let lines = include_str!("reference/digits.txt").lines();
    let line = lines.filter_map(|line| line.strip_prefix(&head)).next().unwrap_or_default();
    line.split(' ').filter_map(|number| number.parse().ok()).collect()
}

fn hilbert(m: usize, n: usize) -> DMatrix<f64> {
    DMatrix::from_fn(m, n, |i, j| 1.0 / (i + j + 1) as f64)
}

fn powers(m: usize, n: usize) -> DMatrix<f64> {
    let mut a = DMatrix::from_element(m, n, 1.0);
    for i in 0..m {
        for j in 1..n {
            a[(i, j)] = a[(i, j - 1)] * (i as f64 / 64.0);
        }
    }
    a
}

fn laeuchli(n: usize, step: f64) -> DMatrix<f64> {
    let below = |i: usize, j: usize| if i == j + 1 { step } else { 0.0 };
    DMatrix::from_fn(n + 1, n, |i, j| if i == 0 { 1.0 } else { below(i, j) })
}

/// The last column is the first but for a trifle.
fn alike(m: usize, n: usize, apart: f64) -> DMatrix<f64> {
    let mut a = DMatrix::from_fn(m, n, |i, j| ((7 * i * i + 3 * (j + 1) * i + 5 * j * j) % 23) as f64 - 11.0);
    for i in 0..m {
        a[(i, n - 1)] = a[(i, 0)] + apart * (((5 * i + 3) % 13) as f64 - 6.0);
    }
    a
}

/// Columns of very different sizes that are nearly of one direction.
fn graded(m: usize, n: usize) -> DMatrix<f64> {
    let mut a = alike(m, n, 2f64.powi(-12));
    for j in 0..n {
        a.column_mut(j).scale_mut(4096f64.powi(-(j as i32)));
    }
    a
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn errors_are_a_small_multiple_of_what_the_condition_allows() {
        let problems = all().expect("ten problems");
        assert_eq!(problems.len(), 10);
        for p in problems {
            let allowed = PROMISED * p.condition * f64::EPSILON;
            assert_eq!(p.rank, 0, "{p:?}");
            for error in [p.qr, p.svd, p.covariance, p.relation] {
                assert!(error <= allowed, "{p:?}: {allowed:e}");
            }
        }
    }

    #[test]
    fn digits_are_there_for_every_number() {
        assert_eq!(digits("hilbert_8", "covariance").len(), 64);
        assert_eq!(digits("graded", "relation").len(), 6);
    }
}
