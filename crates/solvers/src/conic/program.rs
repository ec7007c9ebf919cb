//! A conic program under construction, its run, and what clarabel's verdict means here.
//!
//! minimise ½ vᵀ diag(P) v + qᵀ v  subject to  b − A v ∈ cones

use crate::Status;
use clarabel::algebra::CscMatrix;
use clarabel::solver::{DefaultSettings, DefaultSolver, IPSolver, SolverStatus, SupportedConeT};
use nalgebra::{DMatrix, DVector};

/// A program with `n` variables so far.
pub(super) struct Program {
    square: Vec<f64>,
    linear: Vec<f64>,
    row: Vec<usize>,
    column: Vec<usize>,
    value: Vec<f64>,
    right: Vec<f64>,
    cones: Vec<SupportedConeT<f64>>,
}

/// Where the interior point ended.
pub(super) struct Ended {
    /// All variables; empty unless the status is a success.
    pub v: Vec<f64>,
    pub status: Status,
    pub iterations: usize,
}

impl Program {
    /// Variables u and r with M u − r = z and the objective ½ ‖r‖².
    pub fn residual_form(m: &DMatrix<f64>, z: &DVector<f64>) -> Self {
        let (rows, p) = m.shape();
        let mut square = vec![0.0; p];
        square.resize(p + rows, 1.0);
        let (mut row, mut column, mut value) = (Vec::new(), Vec::new(), Vec::new());
        for j in 0..p {
            for i in 0..rows {
                if m[(i, j)] != 0.0 {
                    row.push(i);
                    column.push(j);
                    value.push(m[(i, j)]);
                }
            }
        }
        for i in 0..rows {
            row.push(i);
            column.push(p + i);
            value.push(-1.0);
        }
        let cones = if rows > 0 { vec![SupportedConeT::ZeroConeT(rows)] } else { Vec::new() };
        Self { linear: vec![0.0; p + rows], square, row, column, value, right: z.as_slice().to_vec(), cones }
    }

    /// A new variable with a linear cost; its number.
    pub fn variable(&mut self, cost: f64) -> usize {
        self.square.push(0.0);
        self.linear.push(cost);
        self.square.len() - 1
    }

    /// One more row Σ value · v ≤ right (or in the cone that is declared next), given as (variable, value).
    pub fn row(&mut self, entries: &[(usize, f64)], right: f64) {
        let at = self.right.len();
        for &(variable, value) in entries {
            self.row.push(at);
            self.column.push(variable);
            self.value.push(value);
        }
        self.right.push(right);
    }

    /// Adds to a row of the residual equation.
    pub fn in_residual(&mut self, row: usize, variable: usize, value: f64) {
        self.row.push(row);
        self.column.push(variable);
        self.value.push(value);
    }

    /// The last `count` rows are inequalities.
    pub fn inequalities(&mut self, count: usize) {
        self.cones.push(SupportedConeT::NonnegativeConeT(count));
    }

    /// The last `count` rows are a second-order cone.
    pub fn second_order(&mut self, count: usize) {
        self.cones.push(SupportedConeT::SecondOrderConeT(count));
    }

    /// Runs clarabel.
    pub fn run(self) -> Ended {
        let n = self.square.len();
        if n == 0 {
            return Ended { v: Vec::new(), status: Status::Converged, iterations: 0 };
        }
        let colptr = (0..=n).collect();
        let square = CscMatrix::new(n, n, colptr, (0..n).collect(), self.square);
        let a = CscMatrix::new_from_triplets(self.right.len(), n, self.row, self.column, self.value);
        let settings = DefaultSettings {
            verbose: false,
            max_threads: 1,
            tol_gap_abs: 1e-11,
            tol_gap_rel: 1e-11,
            tol_feas: 1e-11,
            ..DefaultSettings::default()
        };
        let Ok(mut solver) =
            DefaultSolver::new(&square, &self.linear, &a, &self.right, &self.cones, settings)
        else {
            return Ended { v: Vec::new(), status: Status::NotStarted, iterations: 0 };
        };
        solver.solve();
        let ended = solver.solution;
        let mut status = meaning(ended.status);
        if status.is_success() && ended.x.iter().any(|v| !v.is_finite()) {
            status = Status::NumericalFailure;
        }
        // What comes with a failure is not an answer: clarabel gives zeros after a NaN.
        let v = if status.is_success() { ended.x } else { Vec::new() };
        Ended { v, status, iterations: ended.iterations as usize }
    }
}

/// Clarabel's verdict in our words, one for one.
fn meaning(status: SolverStatus) -> Status {
    match status {
        SolverStatus::Unsolved => Status::NotStarted,
        SolverStatus::Solved => Status::Converged,
        SolverStatus::AlmostSolved => Status::AlmostConverged,
        SolverStatus::PrimalInfeasible => Status::Infeasible,
        SolverStatus::AlmostPrimalInfeasible => Status::AlmostInfeasible,
        SolverStatus::DualInfeasible => Status::Unbounded,
        SolverStatus::AlmostDualInfeasible => Status::AlmostUnbounded,
        SolverStatus::MaxIterations => Status::MaxIterations,
        SolverStatus::MaxTime => Status::MaxTime,
        SolverStatus::NumericalError => Status::NumericalFailure,
        SolverStatus::InsufficientProgress => Status::Stalled,
        SolverStatus::CallbackTerminated => Status::Interrupted,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_fails_is_not_an_answer() {
        let m = DMatrix::identity(2, 2);
        let mut crossed = Program::residual_form(&m, &DVector::zeros(2));
        crossed.row(&[(0, 1.0)], -1.0);
        crossed.row(&[(0, -1.0)], -1.0);
        crossed.inequalities(2);
        let ended = crossed.run();
        assert!(ended.status == Status::Infeasible && ended.v.is_empty());

        let broken = Program::residual_form(&DMatrix::from_element(2, 2, f64::NAN), &DVector::zeros(2)).run();
        assert!(!broken.status.is_success() && broken.v.is_empty(), "{:?}", broken.status);
    }

    #[test]
    fn every_verdict_has_its_own_word() {
        use SolverStatus::*;
        let all = [
            Unsolved,
            Solved,
            AlmostSolved,
            PrimalInfeasible,
            AlmostPrimalInfeasible,
            DualInfeasible,
            AlmostDualInfeasible,
            MaxIterations,
            MaxTime,
            NumericalError,
            InsufficientProgress,
            CallbackTerminated,
        ];
        for (k, one) in all.iter().enumerate() {
            assert!(all[k + 1..].iter().all(|other| meaning(*one) != meaning(*other)));
        }
    }
}
