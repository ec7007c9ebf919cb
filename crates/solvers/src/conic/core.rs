//! The problem in numbers near one: what the cones and the active sets work on.
//!
//! ½ ‖W^{1/2} (A x − y)‖² = h² (½ ‖M u − z‖² + const),  x_j = (h / n_j) u_j
//!
//! | symbol | name | shape | unit |
//! | --- | --- | --- | --- |
//! | n_j | norms of the weighted columns that are not zero | p' | that of A |
//! | h | size of the part of y that columns reach | 1 | that of y |
//! | M | triangle with columns of norm 1 | p × p' | 1 |
//!
//! So every component of the gradient Mᵀ (M u − z) is relative to ‖a_j‖ ‖y‖ already.

use crate::accumulator::Factor;
use crate::dense::norm;
use crate::solver::status_of_rank;
use crate::{LeastSquares, RankDecision, RankRule, Solution, SolveError, SolverInfo, Status};
use nalgebra::{DMatrix, DVector};

pub(super) struct Core {
    pub m: DMatrix<f64>,
    pub z: DVector<f64>,
    /// Columns of the problem that are not zero.
    pub live: Vec<usize>,
    /// x = unit ∘ u.
    pub unit: Vec<f64>,
    /// h.
    pub size: f64,
    columns: usize,
    decision: RankDecision,
    values: Vec<f64>,
}

impl Core {
    pub fn new(factor: &Factor) -> Result<Self, SolveError> {
        let norms = factor.column_norms();
        let live: Vec<usize> = (0..norms.len()).filter(|j| norms[*j] >= f64::MIN_POSITIVE).collect();
        let reached = norm(factor.z.column(0).as_slice());
        let size = if reached >= f64::MIN_POSITIVE { reached } else { 1.0 };
        let m =
            DMatrix::from_fn(factor.columns(), live.len(), |i, j| factor.r[(i, live[j])] / norms[live[j]]);
        let z = factor.z.column(0) / size;
        let values = crate::dense::singular_values(&m)?;
        let decision = factor.decide(&values, RankRule::Default);
        let unit = live.iter().map(|j| size / norms[*j]).collect();
        Ok(Self { m, z, live, unit, size, columns: norms.len(), decision, values })
    }

    /// Mᵀ (M u − z).
    pub fn gradient(&self, u: &DVector<f64>) -> DVector<f64> {
        self.m.tr_mul(&(&self.m * u - &self.z))
    }

    /// The unknowns of the problem; zero where columns are.
    pub fn x(&self, u: &DVector<f64>) -> DVector<f64> {
        let mut x = DVector::zeros(self.columns);
        for (k, j) in self.live.iter().enumerate() {
            x[*j] = u[k] * self.unit[k];
        }
        x
    }

    /// A solution from what the program or the polish arrived at.
    pub fn solution(&self, problem: &LeastSquares<'_>, inner: &Inner) -> Solution {
        let rank = self.decision.rank;
        let x = match &inner.u {
            Some(u) => self.x(u),
            None => DVector::from_element(self.columns, f64::NAN),
        };
        let status = match inner.status {
            Status::Converged => status_of_rank(rank, self.columns),
            other => other,
        };
        let mut solution = Solution::new(problem, x, rank, status);
        solution.info = SolverInfo {
            residual_norm: solution.info.residual_norm,
            condition: (rank > 0).then(|| self.values[0] / self.decision.last_kept),
            singular_values: Some(self.values.clone()),
            rank_decision: Some(RankDecision { dropped: self.columns - rank, ..self.decision }),
            iterations: inner.iterations,
            optimality: inner.u.as_ref().map(|_| inner.optimality),
            ..SolverInfo::default()
        };
        solution
    }
}

/// An answer in u.
pub(super) struct Inner {
    /// Nothing when there is no answer.
    pub u: Option<DVector<f64>>,
    pub status: Status,
    pub iterations: usize,
    /// Largest violation of the optimality conditions.
    pub optimality: f64,
}

/// Violation of the optimality conditions that counts as converged.
pub(super) const OPTIMAL: f64 = 1e-7;

impl Inner {
    /// The better of the polished and the interior answer, with a status that follows from the violation measured here.
    pub fn best(
        interior: (DVector<f64>, f64),
        polished: Option<(DVector<f64>, f64)>,
        ended: Status,
        iterations: usize,
    ) -> Self {
        let (u, optimality) = match polished {
            Some(p) if p.1 <= interior.1 => p,
            _ => interior,
        };
        let status = match ended {
            _ if optimality <= OPTIMAL => Status::Converged,
            Status::Converged => Status::AlmostConverged,
            other => other,
        };
        Self { u: Some(u), status, iterations, optimality }
    }

    pub fn failed(status: Status, iterations: usize) -> Self {
        Self { u: None, status, iterations, optimality: f64::NAN }
    }
}
