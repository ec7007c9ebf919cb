//! `cargo xtask micro solvers`: accumulators, ranks, solutions on the small factor.

use divan::counter::ItemsCount;
use divan::{Bencher, black_box};
use nalgebra::DMatrix;
use truepose_solvers::{ColumnScale, Factor, Gram, RankRule, Triangular};

fn main() {
    divan::main();
}

const SIZES: [usize; 3] = [50, 150, 300];
const ROWS: usize = 2000;

/// Rows of which the last fifth of the columns depends on the others.
fn rows(columns: usize) -> (DMatrix<f64>, DMatrix<f64>) {
    let value = |i: usize, j: usize| ((i * 7 + j * j * 3 + i * j) as f64 * 0.37).sin();
    let mut a = DMatrix::from_fn(ROWS, columns, value);
    for k in columns - columns / 5..columns {
        let sum = a.column(k - columns / 5) * 0.5 - a.column(k % 7);
        a.set_column(k, &sum);
    }
    (a, DMatrix::from_fn(ROWS, 1, |i, _| value(i, 1001)))
}

fn factor(columns: usize) -> Factor {
    let (a, y) = rows(columns);
    let mut triangle = Triangular::new(columns, 1);
    triangle.update(&a, &y).expect("numbers are finite");
    triangle.finish()
}

#[divan::bench(args = SIZES)]
fn triangle(bencher: Bencher<'_, '_>, columns: usize) {
    let (a, y) = rows(columns);
    bencher.counter(ItemsCount::new(ROWS)).bench_local(|| {
        let mut triangle = Triangular::new(columns, 1);
        triangle.update(black_box(&a), &y).map(|()| triangle.into_factor())
    });
}

#[divan::bench(args = SIZES)]
fn gram_matrix(bencher: Bencher<'_, '_>, columns: usize) {
    let (a, y) = rows(columns);
    bencher.counter(ItemsCount::new(ROWS)).bench_local(|| {
        let mut gram = Gram::new(columns, 1);
        gram.update(black_box(&a), &y).map(|()| gram)
    });
}

#[divan::bench(args = SIZES)]
fn null_space(bencher: Bencher<'_, '_>, columns: usize) {
    let factor = factor(columns);
    bencher.bench_local(|| black_box(&factor).null_space(ColumnScale::Norms, RankRule::Default));
}

#[divan::bench(args = SIZES)]
fn basic_solution(bencher: Bencher<'_, '_>, columns: usize) {
    let factor = factor(columns);
    bencher.bench_local(|| black_box(&factor).solve_pivoted(0, ColumnScale::Norms, RankRule::Default));
}

#[divan::bench(args = SIZES)]
fn solution_of_least_norm(bencher: Bencher<'_, '_>, columns: usize) {
    let factor = factor(columns);
    bencher.bench_local(|| black_box(&factor).solve_svd(0, ColumnScale::Norms, RankRule::Default));
}
