//! Against digits from numpy, scipy and mpmath (`reference/make.py`), which share the formulas of the data and nothing else.

use truepose_solvers::nalgebra::{DMatrix, DVector};
#[cfg(feature = "clarabel")]
use truepose_solvers::{Bounded, Bounds, ExactHuber, Lasso, Strength};
use truepose_solvers::{
    LeastSquares, NormalEquations, PivotedQr, RankRule, Ridge, RidgeStrength, Solver, Svd,
};

fn design(m: usize, p: usize) -> DMatrix<f64> {
    DMatrix::from_fn(m, p, |i, j| {
        let (i, j) = (i as f64, j as f64);
        (0.7 * (i + 1.0) * (j + 1.0) + 0.3 * j).sin() + 0.2 * (0.11 * i).cos()
    })
}

fn observed(m: usize) -> DVector<f64> {
    DVector::from_fn(m, |i, _| 2.0 * (0.37 * i as f64).sin() + 0.5 * (1.9 * i as f64).cos() + 0.3)
}

fn digits(name: &str) -> DVector<f64> {
    let lines = include_str!("reference/digits.txt").lines();
    let numbers = lines.filter_map(|l| l.strip_prefix(name)?.strip_prefix(' ')).flat_map(|l| l.split(' '));
    DVector::from_vec(numbers.map(|n| n.parse().expect("a number")).collect())
}

#[track_caller]
fn check(name: &str, have: &DVector<f64>, tolerance: f64) {
    let want = digits(name);
    let error = (have - &want).norm() / want.norm();
    assert!(error < tolerance, "{name}: off by {error:e}\n{have}\n{want}");
}

const SIZES: [f64; 6] = [1.0, 2.0, 0.5, 1.5, 3.0, 1.0];

#[test]
fn direct_methods() {
    let (a, y) = (design(80, 6), observed(80));
    let weights: Vec<f64> = (0..80).map(|i| 1.0 + (i % 7) as f64).collect();
    let problem = LeastSquares::new(&a, &y).with_weights(&weights);
    for solver in [&PivotedQr::default() as &dyn Solver, &Svd::default(), &NormalEquations::default()] {
        check("weighted", &solver.solve(&problem).unwrap().x, 1e-12);
    }
    let mut b = a.clone();
    let dependent = 2.0 * b.column(0) - b.column(3);
    b.set_column(4, &dependent);
    let problem = LeastSquares::new(&b, &y).with_scale(&SIZES);
    check("shortest", &Svd { rank: RankRule::Relative(1e-10) }.solve(&problem).unwrap().x, 1e-12);
    let ridge = Ridge { strength: RidgeStrength::Fixed(0.7) };
    check("ridge", &ridge.solve(&LeastSquares::new(&a, &y).with_scale(&SIZES)).unwrap().x, 1e-12);
}

#[cfg(feature = "clarabel")]
#[test]
fn cones() {
    let (a, y) = (design(80, 6), observed(80));
    let mut bounds = Bounds { lower: vec![-0.02; 6], upper: vec![0.03; 6] };
    bounds.lower[5] = f64::NEG_INFINITY;
    let problem = LeastSquares::new(&a, &y).with_bounds(&bounds);
    check("bounded", &Bounded::default().solve(&problem).unwrap().x, 1e-12);

    let (few, fewer) = (design(30, 6), observed(30));
    let lasso = Lasso { strength: Strength::Fixed(1.0), refit: false };
    check("lasso", &lasso.solve(&LeastSquares::new(&few, &fewer).with_scale(&[1.0; 6])).unwrap().x, 1e-12);

    let huber = ExactHuber { k: 1.6, noise: Some(0.5) };
    check("huber", &huber.solve(&LeastSquares::new(&a, &y)).unwrap().x, 1e-12);
}

#[cfg(feature = "argmin")]
mod nonlinear {
    use super::*;
    use truepose_solvers::Status;
    use truepose_solvers::nonlinear::{Lbfgs, LevenbergMarquardt, NonlinearLeastSquares, TrustRegion};

    struct Peak {
        t: Vec<f64>,
        y: Vec<f64>,
    }

    fn model(x: &[f64], t: f64) -> f64 {
        x[0] + x[1] * (-x[2] * t).exp()
            + x[3] * (x[4] * t + x[5]).sin()
            + x[6] / (1.0 + ((t - x[7]) / x[8]).powi(2))
    }

    impl NonlinearLeastSquares for Peak {
        fn size(&self) -> (usize, usize) {
            (400, 9)
        }
        fn residual(&self, x: &[f64], out: &mut DVector<f64>) {
            (0..400).for_each(|i| out[i] = model(x, self.t[i]) - self.y[i]);
        }
        fn jacobian(&self, x: &[f64], out: &mut DMatrix<f64>) {
            for (i, &t) in self.t.iter().enumerate() {
                let (e, u) = ((-x[2] * t).exp(), t - x[7]);
                let (sin, cos) = (x[4] * t + x[5]).sin_cos();
                let d = 1.0 + (u / x[8]).powi(2);
                let peak = 2.0 * x[6] * u / x[8].powi(2) / d.powi(2);
                let row =
                    [1.0, e, -x[1] * t * e, sin, x[3] * t * cos, x[3] * cos, 1.0 / d, peak, peak * u / x[8]];
                (0..9).for_each(|j| out[(i, j)] = row[j]);
            }
        }
    }

    fn peak() -> Peak {
        let truth = [0.3, 2.0, 0.4, 1.1, 2.7, 0.5, 1.6, 6.0, 0.8];
        let t: Vec<f64> = (0..400).map(|i| i as f64 / 40.0).collect();
        let ripple = |i: usize| 0.05 * (12.9898 * (i * i) as f64).sin() + 0.02 * (0.3 * i as f64).cos();
        let y = t.iter().enumerate().map(|(i, t)| model(&truth, *t) + ripple(i)).collect();
        Peak { t, y }
    }

    const START: [f64; 9] = [0.0, 1.0, 0.2, 1.0, 2.5, 0.0, 1.0, 5.5, 1.0];

    #[test]
    fn levenberg_marquardt_reaches_the_minimum_of_minpack_and_mpmath() {
        let s = LevenbergMarquardt::default().minimise(&peak(), &START).unwrap();
        assert_eq!(s.status, Status::Converged);
        // Unknowns to 1e-9; the norm of the residual, being flat there, to round-off.
        check("nonlinear", &s.x, 1e-9);
        check("nonlinear_norm", &DVector::from_element(1, s.residual_norm), 1e-13);
    }

    #[test]
    fn so_do_the_others_to_their_tolerance() {
        let region = TrustRegion::default().minimise(&peak(), &START).unwrap();
        check("nonlinear_norm", &DVector::from_element(1, region.residual_norm), 1e-9);
        let memory = Lbfgs::default().minimise(&peak(), &START).unwrap();
        check("nonlinear_norm", &DVector::from_element(1, memory.residual_norm), 1e-9);
    }
}
