//! The canned problems.

use crate::{Bounds, LeastSquares};
use nalgebra::{DMatrix, DVector};

/// A problem and what is known about its answer.
pub(super) struct Case {
    pub name: &'static str,
    pub a: DMatrix<f64>,
    pub y: DVector<f64>,
    pub weights: Option<Vec<f64>>,
    pub bounds: Option<Bounds>,
    pub row_groups: Option<Vec<usize>>,
    pub scale: Vec<f64>,
    pub column_groups: Vec<usize>,
    /// Rank of the matrix.
    pub rank: usize,
    /// Unknowns that the good rows come from, where some rows are wrong.
    pub truth: Option<DVector<f64>>,
    /// How far from the truth a robust answer may be.
    pub tolerance: f64,
}

impl Case {
    fn new(name: &'static str, a: DMatrix<f64>, y: DVector<f64>, rank: usize) -> Self {
        let inverse = |n: f64| if n >= f64::MIN_POSITIVE { 1.0 / n } else { 1.0 };
        let scale = a.column_iter().map(|c| inverse(crate::dense::norm(c.as_slice()))).collect();
        let column_groups = (0..a.ncols()).map(|j| j / 2).collect();
        let (weights, bounds, row_groups, truth) = (None, None, None, None);
        Self { name, a, y, weights, bounds, row_groups, scale, column_groups, rank, truth, tolerance: 0.0 }
    }

    pub fn problem(&self) -> LeastSquares<'_> {
        LeastSquares {
            a: &self.a,
            y: &self.y,
            weights: self.weights.as_deref(),
            row_groups: self.row_groups.as_deref(),
            scale: Some(&self.scale),
            column_groups: Some(&self.column_groups),
            bounds: self.bounds.as_ref(),
            prior_rows: 0,
        }
    }
}

/// Numbers in (−1, 1) that look random and are the same everywhere.
fn numbers(rows: usize, columns: usize, seed: u64) -> DMatrix<f64> {
    let mut state = seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) | 1;
    DMatrix::from_fn(rows, columns, |_, _| {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        (state >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    })
}

fn observed(a: &DMatrix<f64>, truth: &DVector<f64>, noise: f64, seed: u64) -> DVector<f64> {
    a * truth + numbers(a.nrows(), 1, seed).column(0) * noise
}

fn truth(p: usize) -> DVector<f64> {
    DVector::from_fn(p, |j, _| [1.0, -0.5, 2.0, 0.25, -1.5, 0.75, -0.3, 1.2][j % 8])
}

pub(super) fn full_rank() -> Case {
    let a = numbers(60, 6, 1);
    let y = observed(&a, &truth(6), 0.1, 2);
    Case::new("full rank", a, y, 6)
}

fn deficient() -> Case {
    let mut a = numbers(60, 6, 3);
    let dependent = a.column(0) - 2.0 * a.column(1) + 0.5 * a.column(4);
    a.set_column(3, &dependent);
    let y = observed(&a, &truth(6), 0.1, 4);
    Case::new("deficient rank", a, y, 5)
}

fn badly_scaled() -> Case {
    let mut a = numbers(60, 7, 5);
    let y = observed(&a, &truth(7), 0.1, 6);
    (0..7).for_each(|j| a.column_mut(j).scale_mut(10f64.powi(3 * j as i32 - 9)));
    Case::new("badly scaled columns", a, y, 7)
}

fn near_collinear() -> Case {
    let mut a = numbers(80, 4, 7);
    let close = a.column(0) + 1e-5 * numbers(80, 1, 8).column(0);
    a.set_column(1, &close);
    let y = observed(&a, &truth(4), 0.01, 9);
    Case::new("near collinear columns", a, y, 4)
}

fn zero_column() -> Case {
    let mut a = numbers(40, 4, 10);
    a.column_mut(2).fill(0.0);
    let y = observed(&a, &truth(4), 0.1, 11);
    Case::new("zero column", a, y, 3)
}

fn extreme_sizes() -> Case {
    let mut a = numbers(40, 3, 12);
    let y = observed(&a, &truth(3), 0.1, 13);
    a.column_mut(0).scale_mut(1e-200);
    a.column_mut(2).scale_mut(1e200);
    Case::new("columns of 1e-200 and 1e200", a, y, 3)
}

fn weighted() -> Case {
    let a = numbers(60, 5, 14);
    let mut y = observed(&a, &truth(5), 0.1, 15);
    y[7] = 1e6;
    let mut weights: Vec<f64> = (0..60).map(|i| 10f64.powi(i % 5 - 2)).collect();
    weights[7] = 0.0;
    let mut case = Case::new("weighted rows", a, y, 5);
    case.weights = Some(weights);
    case
}

fn bounded(name: &'static str, half_width: f64) -> Case {
    let a = numbers(60, 5, 16);
    let y = observed(&a, &truth(5), 0.1, 17);
    let mut case = Case::new(name, a, y, 5);
    case.bounds = Some(Bounds::free(5).with(0, -half_width, half_width).with(2, 0.0, half_width).with(
        4,
        -half_width,
        f64::INFINITY,
    ));
    case
}

fn outliers() -> Case {
    let a = numbers(240, 5, 18);
    let mut y = observed(&a, &truth(5), 1e-3, 19);
    // Three rows a visit; every tenth visit is wrong, all to the same side.
    (0..80).step_by(10).for_each(|visit| (0..3).for_each(|k| y[3 * visit + k] += 5.0));
    let mut case = Case::new("one visit in ten wrong", a, y, 5);
    case.row_groups = Some((0..240).map(|i| i / 3).collect());
    case.truth = Some(truth(5));
    case.tolerance = 2e-3;
    case
}

pub(super) fn cases() -> Vec<Case> {
    let one_row = Case::new("one row", numbers(1, 3, 20), DVector::from_element(1, 2.0), 1);
    let wide =
        Case::new("fewer rows than columns", numbers(4, 7, 21), numbers(4, 1, 22).column(0).into_owned(), 4);
    let no_rows = Case::new("no rows", DMatrix::zeros(0, 3), DVector::zeros(0), 0);
    let no_columns = Case::new("no columns", DMatrix::zeros(5, 0), DVector::from_element(5, 1.0), 0);
    let nothing = Case::new("y is zero", numbers(20, 3, 23), DVector::zeros(20), 3);
    vec![
        full_rank(),
        deficient(),
        badly_scaled(),
        near_collinear(),
        zero_column(),
        extreme_sizes(),
        one_row,
        wide,
        no_rows,
        no_columns,
        nothing,
        weighted(),
        bounded("bounds that do not bind", 50.0),
        bounded("bounds that bind", 0.4),
        outliers(),
    ]
}
