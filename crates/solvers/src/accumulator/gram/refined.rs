//! All digits from a Gram matrix: its solution is refined on the rows that it is of, and what it takes for dependent is checked on them.
//!
//! ```text
//! x ← x + (A₁ᵀA₁)⁻¹ A₁ᵀ (y − A x)         until nothing moves        corrected seminormal equations
//! ‖A Z w‖ ≤ η τ                            for some random w          each column of A Z, a dependency, is below τ
//! ```
//!
//! | symbol | name | shape |
//! | --- | --- | --- |
//! | A₁ | columns that the guard keeps ([`Gram::solve_guarded`]), brought to length one | m × r |
//! | Z | what each of the other columns is in terms of those: `[−(A₁ᵀA₁)⁻¹A₁ᵀA₂; 1]` | p × (p − r) |
//! | τ | the rank rule's tolerance of a pivot | 1 |
//!
//! With a condition number κ each step takes away all but `κ²ε` of the error, and the last leaves that of the residual, as a QR factorisation does.
//! The entries of w are uniform on \[−1, 1\]: a column longer than τ is overlooked by one w with a probability of η at most, whatever the others are.
//! Source: Björck, *Stability analysis of the method of seminormal equations for linear least squares problems*, Linear Algebra and its
//! Applications 88/89 (1987).

use super::Gram;
use super::guarded::Clear;
use crate::{RankRule, Solution, SolveError};
use nalgebra::{DMatrix, DMatrixView, DVector};

/// Random combinations of dependencies.
const PROBES: usize = 10;

/// Share of the tolerance below which each has to be: ten overlook a longer column once in a million.
const SHARE: f64 = 0.25;

/// Passes over the rows, at most.
const PASSES: usize = 5;

/// A pass has to take this part of what the one before it moved.
const CONTRACTS: f64 = 0.1;

impl Gram {
    /// The basic solution of one right-hand side, with all digits: as [`Triangular`](crate::accumulator::Triangular) with columns of length one
    /// gives it; x in units of the right-hand side over those of the columns. The blocks are the rows that this is the Gram matrix of: active
    /// columns (ascending), how many rows, and the numbers, column after column, the right-hand side last. `limit` is as in
    /// [`Gram::solve_guarded`], at most 1e6 leaves steps that get shorter. Of the rank decision `first_dropped` is the longest of some
    /// random combinations of the dependencies. None where the guard refuses ([`Gram::solve_guarded`]), the rule is none that a pivot
    /// can be held against, the dependencies do not hold to its tolerance, or steps do not get shorter.
    ///
    /// # Errors
    /// When sizes do not fit, or a number is not finite.
    pub fn solve_refined<'b>(
        &self,
        limit: f64,
        rule: RankRule,
        blocks: impl Iterator<Item = (&'b [usize], usize, &'b [f64])> + Clone,
    ) -> Result<Option<Solution>, SolveError> {
        rule.validate()?;
        crate::problem::check_len("right-hand sides", self.rhs, 1)?;
        let (RankRule::Relative(tolerance) | RankRule::Absolute(tolerance)) = rule else { return Ok(None) };
        let Some(clear) = self.clear(limit)? else { return Ok(None) };
        if clear.last() <= tolerance {
            return Ok(None);
        }
        let p = self.columns;
        for (active, rows, numbers) in blocks.clone() {
            crate::accumulator::fits(p, active, 1, (rows, rows), numbers)?;
        }
        // The first pass also sees the probes.
        let probes = if clear.dropped().is_empty() { 0 } else { PROBES };
        let mut all = DMatrix::zeros(p, 1 + probes);
        all.set_column(0, &clear.first());
        let mut random = Random(1);
        (0..probes).for_each(|k| all.set_column(1 + k, &clear.dependency(&mut random)));
        let mut before = clear.length(&all.column(0).into_owned());
        let whole = before;
        let mut longest = 0.0_f64;
        for _ in 0..PASSES {
            let pass = Pass::over(blocks.clone(), &all);
            longest = pass.squares.iter().fold(longest, |longest, square| longest.max(square.sqrt()));
            if longest > SHARE * tolerance {
                return Ok(None);
            }
            let moments: Vec<f64> = clear.kept().iter().map(|&c| pass.gradient[c] * clear.size[c]).collect();
            let step = clear.solve(&moments);
            let moved = clear.length(&step);
            // What is round-off from the start can get no shorter.
            if !(moved <= CONTRACTS * before || moved <= 1e-14 * whole) {
                return Ok(None);
            }
            let x = all.column(0) + &step;
            if moved * (moved / before.max(f64::MIN_POSITIVE)) <= f64::EPSILON * whole
                || moved <= 1e-14 * whole
            {
                // ‖A d‖² less than before the step d.
                let kept = clear.kept().iter().zip(&moments);
                let gained: f64 = kept.map(|(&c, moment)| step[c] / clear.size[c] * moment).sum();
                let mut solution = clear.solution(x, (pass.left - gained).max(0.0).sqrt());
                if let Some(decision) = &mut solution.info.rank_decision {
                    decision.tolerance = tolerance;
                    decision.first_dropped = longest;
                    decision.gap = if longest > 0.0 { decision.last_kept / longest } else { f64::INFINITY };
                }
                return Ok(Some(solution));
            }
            before = moved;
            all = DMatrix::from_column_slice(p, 1, x.as_slice());
        }
        Ok(None)
    }
}

impl Clear<'_> {
    /// The solution of the Gram matrix.
    fn first(&self) -> DVector<f64> {
        self.solve(&self.moments(0))
    }

    /// Length in units in which all columns have length one.
    fn length(&self, x: &DVector<f64>) -> f64 {
        x.iter().zip(&self.size).map(|(x, size)| (x / size).powi(2)).sum::<f64>().sqrt()
    }

    /// A random combination of what each dependent column, brought to length one, is in terms of those that are kept: Z w.
    fn dependency(&self, random: &mut Random) -> DVector<f64> {
        let mut combined = DVector::zeros(self.size.len());
        self.dropped().iter().for_each(|&c| combined[c] = random.next() * self.size[c]);
        let moment = |&kept: &usize| {
            let of = |&c: &usize| self.whole[(kept.max(c), kept.min(c))] * combined[c];
            self.size[kept] * self.dropped().iter().map(of).sum::<f64>()
        };
        let moments: Vec<f64> = self.kept().iter().map(moment).collect();
        combined - self.solve(&moments)
    }
}

/// What a pass over the rows gives.
struct Pass {
    /// `Aᵀ(y − A x)`.
    gradient: DVector<f64>,
    /// `‖y − A x‖²`.
    left: f64,
    /// `‖A z‖²` of further columns.
    squares: Vec<f64>,
}

impl Pass {
    /// With x in the first column.
    fn over<'b>(blocks: impl Iterator<Item = (&'b [usize], usize, &'b [f64])>, all: &DMatrix<f64>) -> Self {
        let mut made =
            Pass { gradient: DVector::zeros(all.nrows()), left: 0.0, squares: vec![0.0; all.ncols() - 1] };
        for (active, rows, numbers) in blocks {
            let a = DMatrixView::from_slice(&numbers[..rows * active.len()], rows, active.len());
            let reached = a * all.select_rows(active);
            let y = &numbers[rows * active.len()..][..rows];
            let left =
                DVector::from_iterator(rows, y.iter().zip(reached.column(0).iter()).map(|(y, at)| y - at));
            made.left += left.norm_squared();
            let gradient = a.tr_mul(&left);
            active.iter().zip(gradient.iter()).for_each(|(&column, part)| made.gradient[column] += part);
            let further = reached.column_iter().skip(1);
            made.squares.iter_mut().zip(further).for_each(|(sum, one)| *sum += one.norm_squared());
        }
        made
    }
}

/// Uniform numbers on [−1, 1], the same in every run: Knuth's multiplier.
struct Random(u64);

impl Random {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::accumulator::{ColumnScale, Triangular};

    const RULE: RankRule = RankRule::Relative(1e-9);

    /// Columns of condition number `condition` and one that depends on them but for `off`, in two blocks; what the Gram matrix, refined, and
    /// the triangle make of them.
    fn both(condition: f64, off: f64, noise: f64) -> (DMatrix<f64>, Option<Solution>, Solution) {
        let mut random = Random(7);
        let (rows, p) = (90, 12);
        let mut a = DMatrix::from_fn(rows, p, |_, _| random.next());
        let near = a.column(3) + a.column(4) * (1.0 / condition);
        a.set_column(4, &near);
        let depends = a.column(0) * 2.0 - a.column(4) + DVector::from_fn(rows, |_, _| off * random.next());
        a.set_column(9, &depends);
        a.column_mut(2).scale_mut(1e5);
        let mut y = DMatrix::from_fn(rows, 1, |_, _| noise * random.next());
        y += &a * DVector::from_fn(p, |k, _| 1.0 + k as f64);
        let active: Vec<usize> = (0..p).collect();
        let blocks: Vec<(usize, Vec<f64>)> = [0..40, 40..rows]
            .map(|part| {
                let of = |m: &DMatrix<f64>| m.rows(part.start, part.len()).into_owned().as_slice().to_vec();
                (part.len(), [of(&a), of(&y)].concat())
            })
            .into();
        let mut gram = Gram::new(p, 1);
        for (rows, numbers) in &blocks {
            gram.update_columns(&active, *rows, *rows, numbers).unwrap();
        }
        let blocks = blocks.iter().map(|(rows, numbers)| (active.as_slice(), *rows, numbers.as_slice()));
        let refined = gram.solve_refined(1e6, RULE, blocks).unwrap();
        let mut triangle = Triangular::new(p, 1);
        triangle.update(&a, &y).unwrap();
        (a, refined, triangle.finish().solve_pivoted(0, ColumnScale::Norms, RULE).unwrap())
    }

    #[test]
    fn the_digits_are_those_of_the_triangle() {
        for condition in [1.0, 1e2, 1e4] {
            for noise in [1e-3, 1.0] {
                let (a, refined, want) = both(condition, 0.0, noise);
                let refined = refined.unwrap();
                // Which of those that depend on each other are kept is a matter of round-off.
                assert_eq!((refined.rank, want.rank), (11, 11));
                let [here, there] = [&refined, &want].map(|found| found.info.rank_decision.as_ref().unwrap());
                assert!((here.tolerance / there.tolerance - 1.0).abs() < 1e-12, "{here:?} {there:?}");
                assert!(here.first_dropped < 1e-14 * condition && here.is_clear(), "{here:?}");
                let off = (&a * (&refined.x - &want.x)).norm() / (&a * &want.x).norm();
                assert!(off < 1e-14 * condition, "{condition} {noise}: {off}");
                let norms = [refined.info.residual_norm, want.info.residual_norm];
                let off = (norms[0] - norms[1]).abs() / (&a * &want.x).norm();
                assert!(off < 1e-15, "{condition} {noise}: {norms:?} {off}");
            }
        }
    }

    #[test]
    fn what_only_seems_to_depend_is_left_to_the_triangle() {
        // The square of what is off is round-off: the Gram matrix does not see it.
        let (_, refined, want) = both(1.0, 3e-8, 1e-3);
        assert!(refined.is_none());
        assert_eq!(want.rank, 12);
        // Below the tolerance it depends for the triangle, too.
        let (_, refined, want) = both(1.0, 1e-13, 1e-3);
        assert_eq!((refined.map(|found| found.rank), want.rank), (Some(11), 11));
        // Beyond the guard.
        assert!(both(1e7, 0.0, 1e-3).1.is_none());
    }

    #[test]
    fn a_rule_without_a_tolerance_is_refused_and_so_are_sizes_that_do_not_fit() {
        let mut gram = Gram::new(1, 1);
        gram.update_columns(&[0], 2, 2, &[1.0, 2.0, 3.0, 4.0]).unwrap();
        let all = |rows: usize| std::iter::once((&[0_usize][..], rows, &[1.0, 2.0, 3.0, 4.0][..]));
        assert!(gram.solve_refined(1e6, RankRule::Default, all(2)).unwrap().is_none());
        assert!(gram.solve_refined(1e6, RULE, all(3)).is_err());
        let found = gram.solve_refined(1e6, RULE, all(2)).unwrap().unwrap();
        assert!(
            (found.x[0] - 2.2).abs() < 1e-15 && (found.info.residual_norm - 0.8_f64.sqrt()).abs() < 1e-15
        );
    }
}
