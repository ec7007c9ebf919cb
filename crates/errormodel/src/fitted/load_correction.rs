//! Payloads that are declared wrongly.

use truepose_kinematics::{Load, Payload};

/// A payload whose declared mass is wrong, wherever it is declared.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LoadCorrection {
    /// As declared, kg.
    pub declared: f64,
    /// As it is, kg.
    pub carried: f64,
}

impl LoadCorrection {
    /// Declared masses closer than this share are one level.
    const SAME: f64 = 1e-9;

    /// The load that is carried, when this is the level that it declares.
    pub fn apply(&self, load: Load) -> Option<Load> {
        match load {
            Load::Payload(payload)
                if (payload.mass - self.declared).abs() <= Self::SAME * self.declared.abs().max(1.0) =>
            {
                Some(Load::Payload(Payload { mass: self.carried, ..payload }))
            }
            _ => None,
        }
    }
}
