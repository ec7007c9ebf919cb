//! Directions that the rows do not determine.
//!
//! ```text
//! R diag(s) Π = Q [R₁ R₁₂; 0 R₂]     σ_min(R₁) ≤ d_r,  d_{r+1} ≤ ‖R₂‖_F     N = Π [−R₁⁻¹ R₁₂; I] L⁻ᵀ,  L Lᵀ = I + (R₁⁻¹R₁₂)ᵀ R₁⁻¹R₁₂
//! ```
//!
//! | symbol | name | shape | unit |
//! | --- | --- | --- | --- |
//! | d | singular values of R diag(s), largest first | p | 1 |
//! | r | rank | 1 | |
//! | N | [`NullSpace::basis`], orthonormal | p × (p − r) | 1 |
//!
//! Where both bounds lie far from the tolerance on their sides of it, the rank is what singular values would say, and needs none: a triangle with
//! pivots and one substitution give the null space. Where they do not, singular values decide. Source: Golub and Van Loan, *Matrix
//! Computations*, 4th ed., §5.4–5.5.

use super::{ColumnScale, Factor};
use crate::dense::{
    cholesky_lower, gram, inverse_gram, norm, ordered_qr, pivoted_qr, solve_lower_many, solve_upper_many, svd,
};
use crate::{RankDecision, RankRule, SolveError};
use nalgebra::DMatrix;

/// Directions that the rows do not determine.
#[derive(Debug, Clone, PartialEq)]
pub struct NullSpace {
    /// p × (p − rank), orthonormal, in the scaled unknowns: A diag(scale) basis = 0.
    pub basis: DMatrix<f64>,
    /// Scale of each unknown: `scale ∘ column` is a direction in the unknowns themselves.
    pub scale: Vec<f64>,
    /// How the rank was decided; where bounds decide, `last_kept` is one from below and `first_dropped` one from above.
    pub decision: RankDecision,
}

/// How far above the tolerance everything lies that certainly makes the rank full.
const MARGIN: f64 = 1e3;
/// The same beside something that is dropped, and how far apart both are.
const ABOVE: f64 = 10.0;
const APART: f64 = 1e3;
/// How far below it everything lies that is certainly dropped.
const BELOW: f64 = 0.5;
/// Squares of R₁⁻¹ R₁₂ up to which its Cholesky factor makes an orthonormal basis to the last digits but four.
const MILD: f64 = 1e4;

impl Factor {
    /// The decision that the rank is full, where the inverse of the triangle shows it without singular values: by the default rule and by a
    /// wide margin. Its `last_kept` is a lower bound of the smallest singular value.
    ///
    /// # Errors
    /// When the scale does not fit.
    pub fn certainly_full(&self, scale: ColumnScale<'_>) -> Result<Option<RankDecision>, SolveError> {
        let scaled = Self { r: self.scaled(&self.multipliers(scale)?), ..self.clone() };
        let Some(inverse) = scaled.inverse_gram() else { return Ok(None) };
        // ‖R⁻¹‖_F² is the trace of (RᵀR)⁻¹, and σ_min ≥ 1/‖R⁻¹‖_F.
        let (least, most) = (1.0 / inverse.trace().sqrt(), scaled.r.norm());
        let size = self.rows.max(self.columns()) as f64;
        let tolerance = (size * f64::EPSILON).max(self.resolution) * most;
        let rank = self.columns();
        let sure = self.rows >= rank && least > MARGIN * tolerance;
        Ok(sure.then(|| decision(rank, tolerance, least, 0.0, 0)))
    }

    /// A basis of the directions that the rows do not determine.
    ///
    /// # Errors
    /// When rule or scale do not fit, or the decomposition fails.
    pub fn null_space(&self, scale: ColumnScale<'_>, rule: RankRule) -> Result<NullSpace, SolveError> {
        rule.validate()?;
        let s = self.multipliers(scale)?;
        let scaled = self.scaled(&s);
        if rule == RankRule::Default
            && let Some((decision, basis)) = self.certain_null_space(&scaled)
        {
            return Ok(NullSpace { basis, scale: s, decision });
        }
        let parts = svd(&scaled)?;
        let decision = self.decide(&parts.d, rule);
        let basis = parts.v.columns(decision.rank, self.columns() - decision.rank).into_owned();
        Ok(NullSpace { basis, scale: s, decision })
    }

    /// Rank and null space of the scaled triangle by the default rule, where bounds decide.
    fn certain_null_space(&self, scaled: &DMatrix<f64>) -> Option<(RankDecision, DMatrix<f64>)> {
        let p = self.columns();
        // The largest singular value lies between the longest column and the root of the sum of all squares.
        let longest = scaled.column_iter().fold(0.0_f64, |most, c| most.max(norm(c.as_slice())));
        let share = (self.rows.max(p) as f64 * f64::EPSILON).max(self.resolution);
        let (tolerance, nothing) = (share * scaled.norm(), BELOW * share * longest);
        let Parted { order, lead, mut across, beyond } = self.parted(scaled, nothing);
        let (rank, dropped) = across.shape();
        if rank == 0 || rank > self.rows || (0..rank).any(|k| lead[(k, k)] == 0.0) {
            return None;
        }
        let least = 1.0 / inverse_gram(&lead).trace().sqrt();
        let above = if dropped == 0 { MARGIN } else { ABOVE };
        if !(least > above * tolerance && least > APART * beyond && beyond < nothing) {
            return None;
        }
        if dropped == 0 {
            return Some((decision(rank, tolerance, least, 0.0, 0), DMatrix::zeros(p, 0)));
        }
        solve_upper_many(&lead, &mut across);
        if across.norm_squared() > MILD {
            return None;
        }
        let mut square = DMatrix::identity(dropped, dropped);
        gram(&mut square, &across);
        let root = cholesky_lower(square, dropped)?;
        // Transposed: one row a direction, one column an unknown.
        let mut turned = DMatrix::zeros(dropped, p);
        for (place, &column) in order.iter().enumerate() {
            match place.checked_sub(rank) {
                None => turned.set_column(column, &(-across.row(place)).transpose()),
                Some(own) => turned[(own, column)] = 1.0,
            }
        }
        solve_lower_many(&root, &mut turned);
        Some((decision(rank, tolerance, least, beyond, dropped), turned.transpose()))
    }

    /// The triangle with pivots, parted where they end: in the order of its Gram matrix, or column by column where that leaves more than
    /// `nothing`.
    fn parted(&self, scaled: &DMatrix<f64>, nothing: f64) -> Parted {
        let p = self.columns();
        let quick = ordered_qr(scaled, &DMatrix::zeros(p, 0)).map(|(qr, rest)| {
            let rank = qr.r.nrows();
            (qr.r, qr.order, rank, rest * ((p - rank) as f64).sqrt())
        });
        let (r, order, rank, beyond) = quick.filter(|found| found.3 < nothing).unwrap_or_else(|| {
            let (r, order, rank) = self.pivoted_again(scaled);
            let beyond = r.view((rank, rank), (p - rank, p - rank)).norm();
            (r, order, rank, beyond)
        });
        let top = r.rows(0, rank);
        let across = top.columns(rank, p - rank).into_owned();
        Parted { order, lead: top.columns(0, rank).into_owned(), across, beyond }
    }

    /// Pivots column by column. Lengths of columns are brought up to date on the way and lose their digits: where they seem to end, what is left
    /// is looked at afresh.
    fn pivoted_again(&self, scaled: &DMatrix<f64>) -> (DMatrix<f64>, Vec<usize>, usize) {
        let p = self.columns();
        let (mut r, mut order, mut rank) = (scaled.clone(), (0..p).collect::<Vec<_>>(), 0);
        let share = (self.rows.max(p) as f64 * f64::EPSILON).max(self.resolution);
        let mut tolerance = 0.0;
        while rank < p {
            let left = p - rank;
            let qr = pivoted_qr(&r.view((rank, rank), (left, left)).into_owned(), &DMatrix::zeros(left, 0));
            let pivots = qr.pivots();
            if rank == 0 {
                tolerance = share * pivots[0];
            }
            let above = r.view((0, rank), (rank, left)).into_owned();
            let known = order[rank..].to_vec();
            for (to, &from) in qr.order.iter().enumerate() {
                r.view_mut((0, rank + to), (rank, 1)).copy_from(&above.column(from));
                order[rank + to] = known[from];
            }
            r.view_mut((rank, rank), (left, left)).copy_from(&qr.r);
            let more = pivots.iter().take_while(|pivot| **pivot > tolerance).count();
            if more == 0 {
                break;
            }
            rank += more;
        }
        (r, order, rank)
    }
}

/// R Π = Q [R₁ R₁₂; 0 R₂].
struct Parted {
    /// The column at each place.
    order: Vec<usize>,
    /// R₁.
    lead: DMatrix<f64>,
    /// R₁₂.
    across: DMatrix<f64>,
    /// No less than ‖R₂‖_F.
    beyond: f64,
}

fn decision(rank: usize, tolerance: f64, last_kept: f64, first_dropped: f64, dropped: usize) -> RankDecision {
    let gap = if first_dropped > 0.0 { last_kept / first_dropped } else { f64::INFINITY };
    RankDecision { rank, tolerance, last_kept, first_dropped, gap, dropped }
}

#[cfg(test)]
mod tests {
    use super::super::factor::tests::deficient;
    use super::*;
    use crate::accumulator::Triangular;

    #[test]
    fn rank_and_null_space() {
        let (a, _, f) = deficient();
        let d = f.rank(ColumnScale::Norms, RankRule::Default).unwrap();
        assert!(d.rank == 3 && d.is_clear(), "{d:?}");
        let n = f.null_space(ColumnScale::Norms, RankRule::Default).unwrap();
        assert_eq!(n.basis.shape(), (5, 2));
        let directions = DMatrix::from_fn(5, 2, |i, j| n.basis[(i, j)] * n.scale[i]);
        assert!((a * directions).amax() < 1e-14);
    }

    #[test]
    fn what_is_certainly_full_is_full() {
        let a = DMatrix::from_fn(30, 5, |i, j| ((i * i * 3 + j * 7 + i * j) as f64 * 0.7).sin());
        let mut t = Triangular::new(5, 1);
        t.update(&a, &DMatrix::zeros(30, 1)).unwrap();
        let f = t.finish();
        let sure = f.certainly_full(ColumnScale::Norms).unwrap().unwrap();
        let values = f.singular_values(ColumnScale::Norms).unwrap();
        assert!(sure.rank == 5 && sure.is_clear() && sure.last_kept <= values[4] * (1.0 + 1e-12));
        assert!(deficient().2.certainly_full(ColumnScale::Norms).unwrap().is_none());
    }

    #[test]
    fn bounds_and_singular_values_find_the_same_null_space() {
        let value = |i: usize, j: usize| ((i * 7 + j * j * 3 + i * j) as f64 * 0.37).sin();
        let mut a = DMatrix::from_fn(200, 30, value);
        for k in 20..30 {
            let sum = a.column(k - 20) * 0.5 - a.column(k - 10) * 3.0;
            a.set_column(k, &sum);
        }
        let mut t = Triangular::new(30, 0);
        t.update(&a, &DMatrix::zeros(200, 0)).unwrap();
        let f = t.finish();
        let s = f.multipliers(ColumnScale::Norms).unwrap();
        let scaled = f.scaled(&s);
        let (decision, quick) = f.certain_null_space(&scaled).unwrap();
        let parts = svd(&scaled).unwrap();
        let slow = f.decide(&parts.d, RankRule::Default);
        assert_eq!((decision.rank, slow.rank), (20, 20));
        assert!(decision.last_kept <= parts.d[19] && decision.first_dropped >= parts.d[20] * 0.5);
        assert!(decision.is_clear());
        let basis = parts.v.columns(20, 10);
        assert!((quick.tr_mul(&quick) - DMatrix::identity(10, 10)).amax() < 1e-12, "orthonormal");
        assert!((&quick - basis * basis.tr_mul(&quick)).amax() < 1e-11, "the same directions");
        // Columns that are others but for 1e-9: beyond what the Gram matrix sees.
        for k in 20..23 {
            let near = a.column(k - 20) + nalgebra::DVector::from_fn(200, |i, _| 1e-9 * value(i, 50 + k));
            a.set_column(k, &near);
        }
        let mut t = Triangular::new(30, 0);
        t.update(&a, &DMatrix::zeros(200, 0)).unwrap();
        let f = t.finish();
        let scaled = f.scaled(&s);
        let (decision, quick) = f.certain_null_space(&scaled).unwrap();
        assert!(decision.rank == 23 && decision.is_clear(), "{decision:?}");
        assert!((scaled * quick).amax() < 1e-12);
        // A column that is another one but for 1e-12: too near the tolerance for bounds, and singular values decide.
        let near = a.column(3) + nalgebra::DVector::from_fn(200, |i, _| 1e-12 * value(i, 77));
        a.set_column(25, &near);
        let mut t = Triangular::new(30, 0);
        t.update(&a, &DMatrix::zeros(200, 0)).unwrap();
        let f = t.finish();
        assert!(f.certain_null_space(&f.scaled(&s)).is_none());
        assert_eq!(f.null_space(ColumnScale::Norms, RankRule::Default).unwrap().basis.ncols(), 6);
    }
}
