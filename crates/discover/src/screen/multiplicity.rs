//! What a single test of a screen has to be corrected for.

use crate::screen::candidates::TestCounts;
use crate::significance::rotation::NullDistribution;

/// How many tests a screen made of each family, and the distribution of its smallest p.
pub(crate) struct Multiplicity {
    pub counts: TestCounts,
    pub null: NullDistribution,
}
