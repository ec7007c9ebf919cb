//! Truncated singular value decomposition of the triangle.
//!
//! W^{1/2} A S = Q U D Vᵀ,  x = S Σ_{k ≤ rank} v_k (u_kᵀ Qᵀ W^{1/2} y) / d_k
//!
//! | symbol | name | shape |
//! | --- | --- | --- |
//! | S | column scale | p × p, diagonal |
//! | d_k | singular values, largest first | p |
//!
//! Source: Golub and Van Loan, §5.5.2. Of all optima it is the shortest in the scaled unknowns: nothing is singled out,
//! everything that depends shares.

use crate::accumulator::Factor;
use crate::{LeastSquares, Need, RankRule, Solution, SolveError, Solver};

/// Triangle by blocks, then truncated SVD of the triangle.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Svd {
    /// Where the singular values are cut.
    pub rank: RankRule,
}

impl Solver for Svd {
    fn name(&self) -> &str {
        "svd"
    }

    fn supports(&self, need: Need) -> bool {
        matches!(need, Need::RankDeficient | Need::Weights | Need::Unpenalised)
    }

    fn solve(&self, problem: &LeastSquares<'_>) -> Result<Solution, SolveError> {
        problem.admit(self)?;
        let solution = Factor::of_valid(problem).solve_svd(0, problem.column_scale(), self.rank)?;
        Ok(problem.with_true_residual(solution))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn passes_the_kit() {
        crate::testkit::check_solver(&Svd::default());
    }
}
