//! What one strategy did on one problem.

use crate::prelude::*;
use truepose_identify::Paired;

/// A strategy on a problem.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct Record {
    /// Which problems belong together: `condition`, `rows`, `ur10` …
    pub sweep: String,
    #[serde(with = "number")]
    pub condition: f64,
    #[serde(with = "number")]
    pub noise: f64,
    pub outliers: f64,
    pub rows: f64,
    pub unknowns: f64,
    pub seed: f64,
    pub solver: String,
    /// RMS error at rows that took no part and are not wrong; in standard deviations, for robots in mm.
    #[serde(with = "number")]
    pub held_out: f64,
    /// The same of least squares without the outlying rows.
    #[serde(with = "number")]
    pub oracle: f64,
    /// RMS error of the parameters in true sizes; NaN where there is no truth.
    #[serde(with = "number")]
    pub parameters: f64,
    #[serde(with = "number")]
    pub oracle_parameters: f64,
    /// Wall time of one solve (for robots: of one fit), s.
    #[serde(with = "number")]
    pub seconds: f64,
    pub iterations: f64,
    /// Most bytes held at once.
    pub bytes: f64,
    pub rank: f64,
    /// Violation of the optimality conditions, relative.
    #[serde(with = "number")]
    pub optimality: f64,
    /// Student's t and p of the held-out squares against the first strategy, over the folds.
    #[serde(with = "number")]
    pub t: f64,
    #[serde(with = "number")]
    pub p_value: f64,
    pub status: String,
}

impl Record {
    /// Of a strategy on a problem, without any result.
    pub fn blank(sweep: &str, solver: &str) -> Self {
        let none = f64::NAN;
        Record {
            sweep: sweep.into(),
            solver: solver.into(),
            condition: none,
            noise: none,
            held_out: none,
            parameters: none,
            oracle_parameters: none,
            optimality: none,
            t: none,
            p_value: none,
            ..Record::default()
        }
    }

    /// Notes the held-out squares, and the test of their differences from those of the first strategy.
    pub fn compare(&mut self, squares: Squares, rows: usize, first: &mut Option<Squares>) {
        if let Some(paired) = first.as_ref().and_then(|first| Paired::of(first, &squares, rows)) {
            (self.t, self.p_value) = (paired.t, paired.p_value);
        }
        first.get_or_insert(squares);
    }

    /// Held-out error over that of the oracle.
    pub fn ratio(&self) -> f64 {
        self.held_out / self.oracle
    }
}

/// All that was found out about one problem.
#[derive(Serialize, Deserialize)]
pub struct Solved {
    pub problem: String,
    pub records: Vec<Record>,
}
