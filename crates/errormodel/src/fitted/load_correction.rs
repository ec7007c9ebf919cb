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
    /// From which instant until which, s; whenever it is declared when absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub during: Option<[f64; 2]>,
}

impl LoadCorrection {
    /// Declared masses closer than this share are one level.
    const SAME: f64 = 1e-9;

    /// The load that is carried at a time (s), when this is the level that it declares.
    pub fn apply(&self, load: Load, time: f64) -> Option<Load> {
        if self.during.is_some_and(|[from, until]| !(from..until).contains(&time)) {
            return None;
        }
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
