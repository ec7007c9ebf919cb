//! The linear least-squares problem that every backend takes.
//!
//! minimise ‖W^{1/2} (A x − y)‖² over lower ≤ x ≤ upper
//!
//! | symbol | field | shape | unit |
//! | --- | --- | --- | --- |
//! | A | `a` | m × p | unit of y per unit of x_j |
//! | y | `y` | m | as measured, or 1 when whitened |
//! | W | `weights` | m, diagonal | 1/y² (1/σ² whitens) |
//! | s | `scale` | p | that of x_j: its expected size |
//! | lower, upper | `bounds` | p | that of x_j |

use crate::SolveError;
use nalgebra::{DMatrix, DVector};

/// A weighted linear least-squares problem, borrowed from its owner.
#[derive(Debug, Clone, Copy)]
pub struct LeastSquares<'a> {
    /// Design matrix, m × p.
    pub a: &'a DMatrix<f64>,
    /// Observations, m.
    pub y: &'a DVector<f64>,
    /// Weight ≥ 0 of each row; all 1 when absent.
    pub weights: Option<&'a [f64]>,
    /// Rows of one visit share an id; robust weighting and cross-validation work on whole groups.
    pub row_groups: Option<&'a [usize]>,
    /// Expected size > 0 of each unknown: scales columns, and is the prior σ of a MAP ridge.
    pub scale: Option<&'a [f64]>,
    /// Which effect each column belongs to; the group lasso takes or leaves whole effects.
    pub column_groups: Option<&'a [usize]>,
    /// Lower and upper bound of each unknown.
    pub bounds: Option<&'a Bounds>,
    /// So many rows at the end were not measured: they are a prior. No robust solver lowers their weight or takes a scale from them, and
    /// no fold holds them out.
    pub prior_rows: usize,
}

/// Box constraints, ±∞ where there is none.
#[derive(Debug, Clone, PartialEq)]
pub struct Bounds {
    /// Lower bounds.
    pub lower: Vec<f64>,
    /// Upper bounds.
    pub upper: Vec<f64>,
}

impl Bounds {
    /// No bound on any of `p` unknowns.
    pub fn free(p: usize) -> Self {
        Self { lower: vec![f64::NEG_INFINITY; p], upper: vec![f64::INFINITY; p] }
    }

    /// The same with unknown `column` held within `[lower, upper]`.
    pub fn with(mut self, column: usize, lower: f64, upper: f64) -> Self {
        self.lower[column] = lower;
        self.upper[column] = upper;
        self
    }

    /// Whether any bound is finite.
    pub fn any(&self) -> bool {
        self.lower.iter().any(|b| *b > f64::NEG_INFINITY) || self.upper.iter().any(|b| *b < f64::INFINITY)
    }

    /// Whether `x` lies inside.
    pub fn contains(&self, x: &[f64]) -> bool {
        x.iter().zip(&self.lower).zip(&self.upper).all(|((x, l), u)| l <= x && x <= u)
    }

    fn validate(&self, p: usize) -> Result<(), SolveError> {
        check_len("bounds.lower", p, self.lower.len())?;
        check_len("bounds.upper", p, self.upper.len())?;
        for (column, (&lower, &upper)) in self.lower.iter().zip(&self.upper).enumerate() {
            let reachable = lower < f64::INFINITY && upper > f64::NEG_INFINITY;
            if lower.is_nan() || upper.is_nan() || lower > upper || !reachable {
                return Err(SolveError::BadBounds { column, lower, upper });
            }
        }
        Ok(())
    }
}

impl<'a> LeastSquares<'a> {
    /// The plain problem: every weight 1, no bounds, columns scaled by their norms.
    pub fn new(a: &'a DMatrix<f64>, y: &'a DVector<f64>) -> Self {
        Self {
            a,
            y,
            weights: None,
            row_groups: None,
            scale: None,
            column_groups: None,
            bounds: None,
            prior_rows: 0,
        }
    }

    /// With one weight per row.
    pub fn with_weights(self, weights: &'a [f64]) -> Self {
        Self { weights: Some(weights), ..self }
    }

    /// With an id of its group for each row.
    pub fn with_row_groups(self, groups: &'a [usize]) -> Self {
        Self { row_groups: Some(groups), ..self }
    }

    /// With so many rows at the end that are a prior.
    pub fn with_prior_rows(self, count: usize) -> Self {
        Self { prior_rows: count, ..self }
    }

    /// With the expected size of each unknown.
    pub fn with_scale(self, scale: &'a [f64]) -> Self {
        Self { scale: Some(scale), ..self }
    }

    /// With an id of its effect for each column.
    pub fn with_column_groups(self, groups: &'a [usize]) -> Self {
        Self { column_groups: Some(groups), ..self }
    }

    /// With bounds.
    pub fn with_bounds(self, bounds: &'a Bounds) -> Self {
        Self { bounds: Some(bounds), ..self }
    }

    /// Number of rows m.
    pub fn rows(&self) -> usize {
        self.a.nrows()
    }

    /// Number of unknowns p.
    pub fn columns(&self) -> usize {
        self.a.ncols()
    }

    /// Whether any bound is finite.
    pub fn is_bounded(&self) -> bool {
        self.bounds.is_some_and(Bounds::any)
    }

    /// Refuses what cannot be solved: shapes, numbers that are not finite, negative weights, empty bounds.
    pub fn validate(&self) -> Result<(), SolveError> {
        let (m, p) = self.a.shape();
        check_len("y", m, self.y.len())?;
        for (column, values) in self.a.column_iter().enumerate() {
            if let Some(row) = values.iter().position(|v| !v.is_finite()) {
                return Err(SolveError::NotFinite { what: "the design matrix", row, column });
            }
        }
        if let Some(row) = self.y.iter().position(|v| !v.is_finite()) {
            return Err(SolveError::NotFinite { what: "y", row, column: 0 });
        }
        if let Some(weights) = self.weights {
            check_len("weights", m, weights.len())?;
            if let Some(row) = weights.iter().position(|w| !w.is_finite() || *w < 0.0) {
                return Err(SolveError::BadWeight { row, value: weights[row] });
            }
        }
        if let Some(scale) = self.scale {
            check_len("scale", p, scale.len())?;
            if let Some(column) = scale.iter().position(|s| !s.is_finite() || *s <= 0.0) {
                return Err(SolveError::BadScale { column, value: scale[column] });
            }
        }
        if let Some(groups) = self.row_groups {
            check_len("row_groups", m, groups.len())?;
        }
        if let Some(groups) = self.column_groups {
            check_len("column_groups", p, groups.len())?;
        }
        self.bounds.map_or(Ok(()), |b| b.validate(p))
    }

    /// Square root of the weight of a row.
    pub fn root_weight(&self, row: usize) -> f64 {
        self.weights.map_or(1.0, |w| w[row].sqrt())
    }

    /// W^{1/2} (A x − y).
    pub fn residual(&self, x: &DVector<f64>) -> DVector<f64> {
        let mut r = self.a * x - self.y;
        if let Some(weights) = self.weights {
            r.iter_mut().zip(weights).for_each(|(r, w)| *r *= w.sqrt());
        }
        r
    }

    /// Number of rows that were measured.
    pub fn measured_rows(&self) -> usize {
        self.rows().saturating_sub(self.prior_rows)
    }

    /// Groups of measured rows as lists of row numbers, in the order in which their ids first appear; without
    /// `row_groups` every row is a group of its own.
    pub fn groups_of_rows(&self) -> Vec<Vec<usize>> {
        let measured = self.measured_rows();
        match self.row_groups {
            None => (0..measured).map(|r| vec![r]).collect(),
            Some(ids) => collect_groups(&ids[..measured]),
        }
    }
}

/// Positions that share an id, in the order in which ids first appear.
pub(crate) fn collect_groups(ids: &[usize]) -> Vec<Vec<usize>> {
    let mut place = std::collections::HashMap::new();
    let mut groups: Vec<Vec<usize>> = Vec::new();
    for (position, id) in ids.iter().enumerate() {
        let at = *place.entry(*id).or_insert_with(|| {
            groups.push(Vec::new());
            groups.len() - 1
        });
        groups[at].push(position);
    }
    groups
}

pub(crate) fn check_len(what: &'static str, expected: usize, found: usize) -> Result<(), SolveError> {
    if expected == found { Ok(()) } else { Err(SolveError::Shape { what, expected, found }) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn refuses_what_cannot_be_solved() {
        let a = DMatrix::from_element(3, 2, 1.0);
        let y = DVector::zeros(3);
        let p = LeastSquares::new(&a, &y);
        assert!(p.validate().is_ok());
        assert!(matches!(
            p.with_weights(&[1.0, -1.0, 1.0]).validate(),
            Err(SolveError::BadWeight { row: 1, .. })
        ));
        assert!(matches!(p.with_weights(&[1.0]).validate(), Err(SolveError::Shape { found: 1, .. })));
        assert!(matches!(p.with_scale(&[1.0, 0.0]).validate(), Err(SolveError::BadScale { column: 1, .. })));
        let crossed = Bounds::free(2).with(0, 1.0, 0.0);
        assert!(matches!(p.with_bounds(&crossed).validate(), Err(SolveError::BadBounds { column: 0, .. })));
        let mut broken = a.clone();
        broken[(2, 1)] = f64::NAN;
        let e = LeastSquares::new(&broken, &y).validate();
        assert_eq!(e, Err(SolveError::NotFinite { what: "the design matrix", row: 2, column: 1 }));
    }

    #[test]
    fn groups_keep_the_order_of_appearance() {
        assert_eq!(collect_groups(&[7, 2, 7, 2, 9]), vec![vec![0, 2], vec![1, 3], vec![4]]);
    }
}
