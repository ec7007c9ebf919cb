//! Kept columns, dropped ones, and what each kept coefficient stands for.

use nalgebra::DMatrix;
use truepose_solvers::RankDecision;

/// Which columns are kept, and what each kept coefficient stands for.
#[derive(Debug, Clone, PartialEq)]
pub struct Reduction {
    /// Kept columns, ascending.
    pub kept: Vec<usize>,
    /// Dropped columns and why.
    pub dropped: Vec<Dropped>,
    /// What each kept coefficient stands for, in the order of `kept`.
    pub groups: Vec<Group>,
    /// How the structural rank was decided.
    pub structural: RankDecision,
    /// How the rank of the data, on the structurally kept columns, was decided.
    pub practical: RankDecision,
}

/// A column that is left at zero.
#[derive(Debug, Clone, PartialEq)]
pub struct Dropped {
    /// The column.
    pub column: usize,
    /// Kept columns j with their c_j in `J^p = −Σ_j c_j J^j`; empty when the column has no effect at all.
    pub relation: Vec<(usize, f64)>,
    /// Whose null space it belongs to.
    pub cause: Cause,
}

/// Why a column cannot be told from others.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Cause {
    /// No data can tell them apart on this robot with this kind of measurement.
    Structural,
    /// This data set excites their difference not at all.
    Unexcited,
}

/// A grouped error: the kept column and what passes into it.
#[derive(Debug, Clone, PartialEq)]
pub struct Group {
    /// The kept column.
    pub column: usize,
    /// Dropped columns p with −c_j: β = ε_kept + Σ (−c_j) ε_p.
    pub members: Vec<(usize, f64)>,
}

impl Reduction {
    /// Nothing is reduced away: for models whose columns are known to be independent.
    pub fn none(columns: usize) -> Self {
        let clear = RankDecision {
            rank: columns,
            tolerance: 0.0,
            last_kept: 1.0,
            first_dropped: 0.0,
            gap: f64::INFINITY,
            dropped: 0,
        };
        Reduction {
            kept: (0..columns).collect(),
            dropped: Vec::new(),
            groups: (0..columns).map(|column| Group { column, members: Vec::new() }).collect(),
            structural: clear,
            practical: clear,
        }
    }

    /// The rank: how many grouped errors there are.
    pub fn rank(&self) -> usize {
        self.kept.len()
    }

    /// The columns of a p-column matrix that are kept.
    pub fn select(&self, matrix: &DMatrix<f64>) -> DMatrix<f64> {
        matrix.select_columns(&self.kept)
    }

    /// β of the model's coefficients, when the dropped ones are zero.
    pub fn grouped(&self, coefficients: &[f64]) -> Vec<f64> {
        self.kept.iter().map(|&column| coefficients[column]).collect()
    }

    /// β as the model's coefficients: kept ones in their places, zero elsewhere.
    pub fn expand(&self, grouped: &[f64], columns: usize) -> Vec<f64> {
        let mut coefficients = vec![0.0; columns];
        for (&column, &value) in self.kept.iter().zip(grouped) {
            coefficients[column] = value;
        }
        coefficients
    }
}
