//! A nonlinear parameter of an effect (a period, a lag, a change point) with its interval.

use crate::significant;
use serde::Serialize;
use truepose_identify::{Fit, FittedNonlinear};

/// A nonlinear parameter of an effect.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct NonlinearParameterSummary {
    /// The effect's family, and the number of the effect in the model (from 1).
    pub effect: (String, usize),
    /// Name of the parameter.
    pub name: String,
    /// Value in SI units.
    pub value: f64,
    /// Its 95 % interval.
    pub ci95: [f64; 2],
    /// Whether the interval is limited, below and above, by the search range and not by the data.
    #[serde(rename = "cut")]
    pub truncated: [bool; 2],
    /// SI unit.
    pub unit: String,
}

impl NonlinearParameterSummary {
    /// The nonlinear parameters of a fit.
    pub(super) fn all(fit: &Fit) -> Vec<Self> {
        let effects = fit.fitted.model().effects();
        fit.shapes
            .iter()
            .map(|shape| NonlinearParameterSummary::of(shape, effects[shape.effect].kind()))
            .collect()
    }

    fn of(shape: &FittedNonlinear, family: &str) -> Self {
        NonlinearParameterSummary {
            effect: (family.into(), shape.effect + 1),
            name: shape.name.clone(),
            value: shape.value,
            ci95: shape.interval,
            truncated: [shape.interval[0] <= shape.range[0], shape.interval[1] >= shape.range[1]],
            unit: shape.unit.clone(),
        }
    }

    /// The value, and the interval in brackets.
    pub(crate) fn value_and_interval(&self) -> [String; 2] {
        let [lower, upper] = self.ci95.map(|end| significant(end, 6));
        [significant(self.value, 6), format!("[{lower}, {upper}]")]
    }

    /// Number and family of the effect.
    pub(crate) fn effect_name(&self) -> String {
        format!("effect {}, {}", self.effect.1, self.effect.0)
    }

    /// Which ends of the interval are limited by the search range; empty where the data limits both.
    pub(crate) fn truncation(&self) -> &'static str {
        match self.truncated {
            [false, false] => "",
            [true, false] => "lower end limited by the search range",
            [false, true] => "upper end limited by the search range",
            [true, true] => "both ends limited by the search range",
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_interval_limited_by_the_search_range_is_marked() {
        let truncation = |interval: [f64; 2]| {
            let parameter = FittedNonlinear {
                effect: 0,
                name: "period".into(),
                unit: "rad".into(),
                value: 0.3,
                interval,
                range: [0.2, 0.5],
            };
            NonlinearParameterSummary::of(&parameter, "transmission").truncation()
        };
        assert_eq!(truncation([0.29, 0.31]), "");
        assert_eq!(truncation([0.2, 0.31]), "lower end limited by the search range");
        assert_eq!(truncation([0.29, 0.5]), "upper end limited by the search range");
        assert_eq!(truncation([0.2, 0.5]), "both ends limited by the search range");
    }
}
