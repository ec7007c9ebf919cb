//! What a single test of a screen has to be corrected for.

use crate::error::DiscoverError;
use crate::options::DiscoverOptions;
use crate::problem::linearisation::Linearisation;
use crate::screen::candidates::{Screen, TestCounts};
use crate::significance::rotation::NullDistribution;

/// How many tests a screen made of each family, and the distribution of its smallest p.
pub(crate) struct Multiplicity {
    pub counts: TestCounts,
    pub null: NullDistribution,
}

impl Multiplicity {
    /// The smallest family-wise p of a screen, with what it was corrected for. The distribution of the smallest p depends on the columns of the
    /// candidates and of the model, hardly on a few more effects in the model: that of an earlier screen serves until p comes near α.
    pub fn of(
        linearisation: &Linearisation<'_>,
        screen: &Screen,
        known: Option<NullDistribution>,
        options: &DiscoverOptions,
    ) -> Result<(Self, f64), DiscoverError> {
        const NEAR: f64 = 10.0;
        let p_value = |null: &NullDistribution| null.p_value(screen.largest());
        let far = |null: &NullDistribution| !(1.0 / NEAR..NEAR).contains(&(p_value(null) / options.alpha));
        let null = match known.filter(far) {
            Some(null) => null,
            None => screen.null(linearisation, options.rotations, options.seed)?,
        };
        let p_value = p_value(&null);
        Ok((Multiplicity { counts: screen.test_counts().clone(), null }, p_value))
    }
}
