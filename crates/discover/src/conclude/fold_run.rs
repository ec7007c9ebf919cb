//! The run of one outer fold, as a value that can be made anywhere and stored.

use nalgebra::Vector3;
use serde::{Deserialize, Serialize};
use truepose_identify::Spread;

/// What nested cross-validation takes from the search without one fold: no fits and no data, so that each fold may run on another machine.
/// [`Nested::of`](crate::Nested::of) puts the folds together.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FoldRun {
    /// Number of the fold, from 0.
    pub fold: usize,
    /// How many folds there are.
    pub folds: usize,
    /// Names of the findings, in the order in which they were added.
    pub findings: Vec<String>,
    /// Rows (0-based) that were left out.
    pub rows: Vec<usize>,
    /// Position residuals of the declared model in these rows, m; zero in a component that was not measured, `None` where none was.
    pub before: Vec<Option<[f64; 3]>>,
    /// The same of the model with the findings, m.
    pub after: Vec<Option<[f64; 3]>>,
    /// p of no dependence between poses; `None` with fewer than ten poses.
    pub dependence: Option<f64>,
    /// The bootstrap cluster of each row of the data, as this run sees the dependence between poses.
    pub clusters: Vec<usize>,
    /// Rank of the final model.
    pub rank: usize,
    /// Share of the degrees of freedom that the unknowns of the declared and the final model use up.
    pub used: [f64; 2],
}

impl FoldRun {
    /// Position errors in the rows that were left out, of the model with the findings, m.
    pub fn errors(&self) -> Spread {
        Spread::of(self.after.iter().flatten().map(|&error| Vector3::from(error).norm()))
    }
}
