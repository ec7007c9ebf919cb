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
        /// Fewer rotations do not decide a p near α.
        const DECIDING: usize = 249;
        let p_value = |null: &NullDistribution| null.p_value(screen.largest());
        let far = |null: &NullDistribution| !(1.0 / NEAR..NEAR).contains(&(p_value(null) / options.alpha));
        let null = match known.filter(far) {
            Some(null) => null,
            None => {
                let drawn = |rotations| screen.null(linearisation, rotations, options.seed);
                let first = drawn(options.rotations)?;
                if far(&first) || options.rotations >= DECIDING { first } else { drawn(DECIDING)? }
            }
        };
        let p_value = p_value(&null);
        Ok((Multiplicity { counts: screen.test_counts().clone(), null }, p_value))
    }
}
