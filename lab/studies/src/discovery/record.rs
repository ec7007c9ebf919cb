//! One line a robot.

use crate::prelude::*;

/// A parameter with its interval and its truth.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Interval {
    pub name: String,
    pub truth: f64,
    pub value: f64,
    pub ci95: [f64; 2],
}

impl Interval {
    pub fn covers(&self) -> bool {
        (self.ci95[0]..=self.ci95[1]).contains(&self.truth)
    }

    /// An interval without a width has no information.
    pub fn empty(&self) -> bool {
        self.ci95[1] - self.ci95[0] <= 1e-12 * self.value.abs()
    }
}

/// What became of one robot.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct Record {
    pub cause: String,
    pub multiple: f64,
    pub seed: u64,
    pub robot: String,
    /// Heavy-tailed noise.
    pub heavy: bool,
    pub visits: usize,
    #[serde(with = "number")]
    pub lambda: f64,
    /// The first finding's family; `none`, `error`, `panic`, `no_plant`.
    pub first: String,
    /// The first finding has the right name and place.
    pub first_right: bool,
    /// Some finding has.
    pub found: bool,
    pub findings: usize,
    /// Findings that are not the hidden cause.
    pub extras: usize,
    /// The right one (or, with its family taken out, `unmodelled`) is an equivalent alternative of the first.
    pub listed: bool,
    /// Family-wise p of the first finding; of the last screen.
    #[serde(with = "number")]
    pub p_first: f64,
    #[serde(with = "number")]
    pub p_value: f64,
    pub significant: bool,
    /// Held-out RMS over that of the true plant, after and before.
    #[serde(with = "number")]
    pub ratio: f64,
    #[serde(with = "number")]
    pub ratio_before: f64,
    /// On the wall, and of the processor where the system reports it.
    #[serde(with = "number")]
    pub seconds: f64,
    #[serde(with = "number")]
    pub processor: f64,
    pub intervals: Vec<Interval>,
    pub story: String,
}

impl Record {
    /// Whether this is what became of that task.
    pub fn is(&self, cause: &str, multiple: f64, seed: u64) -> bool {
        self.cause == cause && (self.multiple - multiple).abs() < 1e-9 && self.seed == seed
    }

    /// Whether a plant was made and the loop came to an end.
    pub fn ended(&self) -> bool {
        !["error", "panic", "no_plant"].contains(&self.first.as_str())
    }
}
