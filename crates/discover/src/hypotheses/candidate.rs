//! A candidate: a change of the model that might explain what is left.

use crate::hypotheses::covariate::{LOADED, TIME};
use crate::hypotheses::family::Family;
use crate::hypotheses::place::Place;
use truepose_errormodel::AnyEffect;

/// What would be done to the model.
#[derive(Debug, Clone)]
pub enum Change {
    /// Effects are added; several are one cause (periods of one gear).
    Add(Vec<Box<dyn AnyEffect>>),
    /// Rows that declare this payload (kg) carried another mass (kg).
    CorrectLoad {
        /// As declared.
        level: f64,
        /// As it is.
        mass: f64,
        /// Standard deviation of that, kg; zero before it was fitted.
        deviation: f64,
    },
}

/// A change with its name and place.
#[derive(Debug, Clone)]
pub struct Candidate {
    /// What kind of cause.
    pub family: Family,
    /// Where.
    pub place: Place,
    /// What would be done.
    pub change: Change,
    /// Standard deviation of the prior on its coefficients, in expected sizes; none before it was fitted.
    pub width: Option<f64>,
}

impl Candidate {
    /// One effect at one place.
    pub fn new(family: Family, place: Place, effect: impl AnyEffect + 'static) -> Self {
        Candidate { family, place, change: Change::Add(vec![Box::new(effect)]), width: None }
    }

    /// Whether both are the same cause at the same place, in whatever shape.
    pub fn same_cause(&self, other: &Candidate) -> bool {
        self.family == other.family && self.place == other.place
    }

    /// Whether it is a structure without a name that follows the time.
    pub(crate) fn follows_the_time(&self) -> bool {
        self.depends(|covariate| covariate == TIME)
    }

    /// Whether it follows the time, under a name or without.
    pub(crate) fn belongs_to_time(&self) -> bool {
        self.family.belongs_to_time() || self.follows_the_time()
    }

    /// Whether it is one that follows a joint's load.
    pub(crate) fn follows_a_load(&self) -> bool {
        self.depends(|covariate| covariate.starts_with(LOADED))
    }

    fn depends(&self, on: impl Fn(&str) -> bool) -> bool {
        self.family == Family::Unmodelled && self.place.covariate.as_deref().is_some_and(on)
    }

    /// Its effects; none of a corrected load.
    pub fn effects(&self) -> &[Box<dyn AnyEffect>] {
        match &self.change {
            Change::Add(effects) => effects,
            Change::CorrectLoad { .. } => &[],
        }
    }

    /// In a few words: `backlash a1`.
    pub fn words(&self) -> String {
        format!("{} {}", self.family, self.place.words()).trim_end().to_owned()
    }
}
