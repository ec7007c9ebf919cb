//! What a hypothesis would do to the model, or to the data.

use truepose_errormodel::AnyEffect;

/// What would be done to the model or to the data.
#[derive(Debug, Clone)]
#[non_exhaustive]
pub enum Change {
    /// Effects are added; several belong to one cause (periods of one transmission).
    Add(Vec<Box<dyn AnyEffect>>),
    /// Rows that declare this payload (kg), all or those of a stretch of time, carried another mass (kg).
    CorrectLoad {
        /// As declared.
        level: f64,
        /// As it is.
        mass: f64,
        /// Standard deviation of that, kg; zero before it was fitted.
        deviation: f64,
        /// From which instant until which, s; always when absent.
        during: Option<[f64; 2]>,
    },
    /// Rows (0-based, of the whole data) are kept out of the fit: no repeatable effect explains them.
    Exclude {
        /// The rows, ascending.
        rows: Vec<usize>,
    },
}

impl Change {
    /// The effects that are added; none of another change.
    pub fn effects(&self) -> &[Box<dyn AnyEffect>] {
        match self {
            Change::Add(effects) => effects,
            Change::CorrectLoad { .. } | Change::Exclude { .. } => &[],
        }
    }
}
