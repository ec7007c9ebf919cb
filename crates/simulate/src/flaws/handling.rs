//! What people get wrong: labels of payloads, and rows that mean nothing.

use super::{Draft, Install};
use crate::SimulateError;
use rand_chacha::ChaCha8Rng;
use serde::{Deserialize, Serialize};

/// A payload whose label is wrong whenever it is carried.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Mislabelled {
    /// Declared mass, kg.
    pub declared_kg: f64,
    /// True mass, kg.
    pub true_kg: f64,
}

/// Wrong payloads at some of the loaded pose measurements.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct WrongPayloads {
    /// Fraction of the loaded pose measurements.
    pub share: f64,
    /// True mass over declared mass.
    pub factor: f64,
}

/// Rows that mean nothing.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Outliers {
    /// Share of the rows.
    pub share: f64,
    /// Their size, mm.
    pub size_mm: f64,
}

impl Install for Mislabelled {
    fn install(&self, draft: &mut Draft<'_>, _: &mut ChaCha8Rng) -> Result<(), SimulateError> {
        if self.true_kg.is_nan() || self.true_kg < 0.0 {
            return Err(SimulateError::Size { what: "true_kg", value: self.true_kg, need: "zero or more" });
        }
        draft.blunders.mislabelled.push((self.declared_kg, self.true_kg));
        Ok(())
    }
}

impl Install for WrongPayloads {
    fn install(&self, draft: &mut Draft<'_>, _: &mut ChaCha8Rng) -> Result<(), SimulateError> {
        draft.blunders.wrong_payload_share = share(self.share)?;
        if self.factor.is_nan() || self.factor < 0.0 {
            return Err(SimulateError::Size { what: "factor", value: self.factor, need: "zero or more" });
        }
        draft.blunders.wrong_payload_factor = self.factor;
        Ok(())
    }
}

impl Install for Outliers {
    fn install(&self, draft: &mut Draft<'_>, _: &mut ChaCha8Rng) -> Result<(), SimulateError> {
        draft.blunders.outlier_share = share(self.share)?;
        draft.blunders.outlier_size = 1e-3 * self.size_mm;
        Ok(())
    }
}

fn share(value: f64) -> Result<f64, SimulateError> {
    if (0.0..=1.0).contains(&value) {
        Ok(value)
    } else {
        Err(SimulateError::Size { what: "a fraction", value, need: "between 0 and 1" })
    }
}

#[cfg(test)]
mod tests {
    use super::super::Flaws;
    use super::*;
    use crate::physics::temperature::Shop;
    use truepose_kinematics::samples;

    #[test]
    fn fractions_are_between_zero_and_one() {
        let flaws = |share| Flaws {
            outliers: Some(Outliers { share, size_mm: 2.0 }),
            payload: vec![Mislabelled { declared_kg: 50.0, true_kg: 60.0 }],
            ..Flaws::default()
        };
        let shop = Shop::steady(20.0).expect("a shop");
        let (_, blunders) = flaws(0.02).on(&samples::heavy(), &shop, 1).expect("a truth");
        assert!((blunders.outlier_size - 2e-3).abs() < 1e-18);
        assert_eq!(blunders.mislabelled, [(50.0, 60.0)]);
        assert!(flaws(1.5).on(&samples::heavy(), &shop, 1).is_err());
    }
}
