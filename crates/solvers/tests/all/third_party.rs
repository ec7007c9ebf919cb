//! A third party's solver goes through the same door as ours.

use truepose_solvers::nalgebra::DVector;
use truepose_solvers::testkit::{check_solver, examine};
use truepose_solvers::{LeastSquares, Need, Solution, SolveError, Solver, Status};

/// Conjugate gradients on the least-squares problem (CGLS), columns scaled by their norms.
struct ConjugateGradients {
    iterations: usize,
}

impl Solver for ConjugateGradients {
    fn name(&self) -> &str {
        "third_party/cgls"
    }

    fn supports(&self, need: Need) -> bool {
        matches!(need, Need::Weights | Need::Unpenalised)
    }

    fn solve(&self, problem: &LeastSquares<'_>) -> Result<Solution, SolveError> {
        problem.admit(self)?;
        let (m, p) = (problem.rows(), problem.columns());
        let mut a = problem.a.clone();
        a.row_iter_mut().enumerate().for_each(|(i, mut r)| r *= problem.root_weight(i));
        let scale: Vec<f64> = a
            .column_iter()
            .map(|c| c.amax() * (c / c.amax().max(f64::MIN_POSITIVE)).norm())
            .map(|n| if n > 0.0 { 1.0 / n } else { 1.0 })
            .collect();
        a.column_iter_mut().zip(&scale).for_each(|(mut c, s)| c *= *s);
        let mut x = DVector::zeros(p);
        let mut r = DVector::from_fn(m, |i, _| problem.root_weight(i) * problem.y[i]);
        let size = r.norm();
        for _ in 0..self.iterations {
            // Restarted every p steps, which refines against the true residual.
            let mut g = a.tr_mul(&r);
            let mut d = g.clone();
            for _ in 0..p {
                let ad = &a * &d;
                if g.norm() <= 1e-15 * size || ad.norm_squared() < f64::MIN_POSITIVE {
                    break;
                }
                let step = g.norm_squared() / ad.norm_squared();
                x += &d * step;
                r -= ad * step;
                let next = a.tr_mul(&r);
                d = &next + &d * (next.norm_squared() / g.norm_squared());
                g = next;
            }
        }
        let x = DVector::from_fn(p, |j, _| x[j] * scale[j]);
        Ok(Solution::new(problem, x, p.min(m), Status::Converged))
    }
}

#[test]
fn a_third_party_solver_passes_the_kit() {
    check_solver(&ConjugateGradients { iterations: 300 });
}

#[test]
fn a_lazy_one_does_not() {
    let outcomes = examine(&ConjugateGradients { iterations: 0 });
    assert!(outcomes.iter().any(|o| o.case == "full rank" && o.failure.is_some()));
    assert!(outcomes.iter().any(|o| o.case == "what is not finite is refused" && o.failure.is_none()));
}
