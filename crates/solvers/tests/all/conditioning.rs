//! The cones on columns that are nearly, or exactly, dependent: optimality to 1e-7 relative, measured on the rows.

use truepose_solvers::nalgebra::{DMatrix, DVector};
use truepose_solvers::{
    Bounded, Bounds, ElasticNet, ExactHuber, GroupLasso, Lasso, LeastSquares, Solution, Solver, Strength,
};

const OPTIMAL: f64 = 1e-7;

fn wave(i: usize, j: usize, seed: usize) -> f64 {
    ((i * 19 + j * 31 + seed * 7 + i * j) as f64 * 0.77).sin()
}

/// Columns whose last third repeats the first to within `apart`.
fn alike(seed: usize, apart: f64) -> (DMatrix<f64>, DVector<f64>) {
    let (m, p) = (90 + 5 * seed, 6 + 3 * (seed % 6));
    let a = DMatrix::from_fn(m, p, |i, j| {
        if j >= 2 * p / 3 {
            wave(i, j - 2 * p / 3, seed) + apart * wave(i, j, seed)
        } else {
            wave(i, j, seed)
        }
    });
    let y =
        DVector::from_fn(m, |i, _| 2.0 * wave(i, 1, seed) - wave(i, 2, seed) + 0.3 * wave(i * i, 40, seed));
    (a, y)
}

/// Gradient along unit columns, relative to y.
fn gradient(a: &DMatrix<f64>, y: &DVector<f64>, s: &Solution) -> Vec<f64> {
    let weights = s.info.row_weights.clone().unwrap_or_else(|| vec![1.0; y.len()]);
    let r = DVector::from_fn(y.len(), |i, _| weights[i] * ((a.row(i) * &s.x)[0] - y[i]));
    a.column_iter().map(|c| c.dot(&r) / c.norm() / y.norm()).collect()
}

#[test]
fn optimal_to_1e_7_however_alike_the_columns_are() {
    for seed in 0..12 {
        for apart in [1.0, 1e-3, 1e-6, 1e-9, 0.0] {
            let (a, y) = alike(seed, apart);
            let p = a.ncols();
            let label = format!("seed {seed}, columns {apart:e} apart");
            let problem = LeastSquares::new(&a, &y);

            let bounds = Bounds { lower: vec![-0.1; p], upper: vec![0.2; p] };
            let s = Bounded::default().solve(&problem.with_bounds(&bounds)).expect("a problem");
            assert!(s.status.is_success() && bounds.contains(s.x.as_slice()), "{label}: {:?}", s.status);
            for (j, g) in gradient(&a, &y, &s).iter().enumerate() {
                assert!(s.x[j] <= -0.1 || *g < OPTIMAL, "{label}: {g:e}");
                assert!(s.x[j] >= 0.2 || *g > -OPTIMAL, "{label}: {g:e}");
            }

            for mix in [1.0, 0.5] {
                let strength = Strength::Ratio(0.03);
                let s = if mix < 1.0 {
                    ElasticNet { strength, mix, refit: false }.solve(&problem)
                } else {
                    Lasso { strength, refit: false }.solve(&problem)
                }
                .expect("a problem");
                assert!(s.status.is_success(), "{label}, mix {mix}: {:?}", s.status);
                let lambda = s.info.strength.expect("chosen") / y.norm();
                for (j, g) in gradient(&a, &y, &s).iter().enumerate() {
                    let v = s.x[j] * a.column(j).norm() / y.norm();
                    let g = g + lambda * y.norm() * (1.0 - mix) * v;
                    let wrong = if v.abs() > 0.0 {
                        (g + lambda * mix * v.signum()).abs()
                    } else {
                        g.abs() - lambda * mix
                    };
                    assert!(wrong < OPTIMAL, "{label}, mix {mix}, column {j}: {wrong:e}");
                }
            }

            let ids: Vec<usize> = (0..p).map(|j| j / 2).collect();
            let s = GroupLasso { strength: Strength::Ratio(0.03), refit: false }
                .solve(&problem.with_column_groups(&ids))
                .expect("a problem");
            assert!(s.status.is_success(), "{label}, groups: {:?} {:?}", s.status, s.info.optimality);
            assert!(s.info.optimality.expect("measured") < OPTIMAL, "{label}: {:?}", s.info.optimality);

            let s = ExactHuber::default().solve(&problem).expect("a problem");
            assert!(s.status.is_success(), "{label}, Huber: {:?}", s.status);
            for g in gradient(&a, &y, &s) {
                assert!(g.abs() < OPTIMAL, "{label}, Huber: {g:e}");
            }
        }
    }
}
