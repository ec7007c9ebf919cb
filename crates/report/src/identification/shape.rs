//! A parameter in which an effect is not linear, as it is shown: with the digits of its value and of its interval.

use crate::significant;
use serde::Serialize;
use truepose_identify::{Fit, FittedNonlinear};

/// A parameter in which an effect is not linear.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ShapeSummary {
    /// The effect's family, and the number of the effect in the model (from 1).
    pub effect: (String, usize),
    /// Its name.
    pub name: String,
    /// Value in SI units.
    pub value: f64,
    /// Its 95 % interval.
    pub ci95: [f64; 2],
    /// Whether the range in which it was looked for ends where the interval does, below and above: the data would allow more.
    pub cut: [bool; 2],
    /// SI unit.
    pub unit: String,
}

impl ShapeSummary {
    /// Those of a fit.
    pub(super) fn all(fit: &Fit) -> Vec<Self> {
        let effects = fit.fitted.model().effects();
        fit.shapes.iter().map(|shape| ShapeSummary::of(shape, effects[shape.effect].kind())).collect()
    }

    fn of(shape: &FittedNonlinear, family: &str) -> Self {
        ShapeSummary {
            effect: (family.into(), shape.effect + 1),
            name: shape.name.clone(),
            value: shape.value,
            ci95: shape.interval,
            cut: [shape.interval[0] <= shape.range[0], shape.interval[1] >= shape.range[1]],
            unit: shape.unit.clone(),
        }
    }

    /// Its value, and its interval in brackets.
    pub(crate) fn numbers(&self) -> [String; 2] {
        let [lower, upper] = self.ci95.map(|end| significant(end, 6));
        [significant(self.value, 6), format!("[{lower}, {upper}]")]
    }

    /// The effect that it belongs to.
    pub(crate) fn effect_words(&self) -> String {
        format!("effect {}, {}", self.effect.1, self.effect.0)
    }

    /// Where the interval ends only because its range does; nothing where the data ends it.
    pub(crate) fn cut_words(&self) -> &'static str {
        match self.cut {
            [false, false] => "",
            [true, false] => "below, only its range ends",
            [false, true] => "above, only its range ends",
            [true, true] => "the data leaves it open",
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_interval_that_its_range_cuts_says_so() {
        let told = |interval: [f64; 2]| {
            let shape = FittedNonlinear {
                effect: 0,
                name: "period".into(),
                unit: "rad".into(),
                value: 0.3,
                interval,
                range: [0.2, 0.5],
            };
            ShapeSummary::of(&shape, "transmission").cut_words()
        };
        assert_eq!(told([0.29, 0.31]), "");
        assert_eq!(told([0.2, 0.31]), "below, only its range ends");
        assert_eq!(told([0.29, 0.5]), "above, only its range ends");
        assert_eq!(told([0.2, 0.5]), "the data leaves it open");
    }
}
