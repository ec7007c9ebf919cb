//! Pivoted QR: reduce the rows to a triangle, then pivot the triangle.
//!
//! W^{1/2} A S = Q R,  R Π = Q₂ [R₁ R₂; 0 ≈0],  x = S Π [R₁⁻¹ (Q₂ᵀ Qᵀ W^{1/2} y)₁; 0]
//!
//! | symbol | name | shape |
//! | --- | --- | --- |
//! | S | column scale | p × p, diagonal |
//! | R₁ | kept part, one row per pivot above the tolerance | rank × rank |
//!
//! Source: Golub and Van Loan, §5.5. Columns that depend on others are zero in the answer: it is a *basic* solution,
//! with names that a person can read.

use crate::accumulator::Factor;
use crate::{LeastSquares, Need, RankRule, Solution, SolveError, Solver};

/// Triangle by blocks, then column-pivoted QR of the triangle.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct PivotedQr {
    /// Where the pivots end.
    pub rank: RankRule,
}

impl Solver for PivotedQr {
    fn name(&self) -> &str {
        "qr"
    }

    fn supports(&self, need: Need) -> bool {
        matches!(need, Need::RankDeficient | Need::Weights | Need::Unpenalised)
    }

    fn solve(&self, problem: &LeastSquares<'_>) -> Result<Solution, SolveError> {
        problem.admit(self)?;
        let solution = Factor::of_valid(problem).solve_pivoted(0, problem.column_scale(), self.rank)?;
        Ok(problem.with_true_residual(solution))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn passes_the_kit() {
        crate::testkit::check_solver(&PivotedQr::default());
    }
}
