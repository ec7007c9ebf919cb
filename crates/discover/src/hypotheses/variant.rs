//! One form of a hypothesis at one place, before it is a candidate of a search.

use crate::hypotheses::change::Change;
use crate::hypotheses::place::Place;
use truepose_errormodel::AnyEffect;

/// One form of a hypothesis at one place: so many coefficients, this period, that degree.
#[derive(Debug, Clone)]
pub struct Variant {
    /// Where.
    pub place: Place,
    /// What would be done.
    pub change: Change,
}

impl Variant {
    /// One effect is added.
    pub fn new(place: Place, effect: impl AnyEffect) -> Self {
        Variant { place, change: Change::Add(vec![Box::new(effect)]) }
    }
}
