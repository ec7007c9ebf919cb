//! An error that jumps once: something was bumped, changed or mounted anew.
//!
//! `ε(t) = c · [t ≥ t_0]`, one unknown a component of the place; t_0 (`at`, s) is its shape where `at_range` is given.

use super::Spot;
use super::travel::{ascending, free};
use crate::{Column, Effect, Emission, ModelError, Search, Shape, Signal};
use serde::{Deserialize, Serialize};
use truepose_kinematics::{Axis, Chain, Posture};

/// A step at an instant.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Shift {
    /// Where.
    #[serde(flatten)]
    pub spot: Spot,
    /// Which components of a frame; all six when absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub components: Option<Vec<Axis>>,
    /// From when on, s.
    pub at: f64,
    /// Between which instants `at` is to be found, s; it is known when absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub at_range: Option<[f64; 2]>,
}

impl Effect for Shift {
    const KIND: &'static str = "shift";
    const ABOUT: &'static str = "base, tool or a joint jumps once, at an instant that may be unknown";

    fn settles(&self) -> bool {
        false
    }

    fn columns(&self, chain: &Chain) -> Vec<Column> {
        let parts = self.spot.parts(self.components.as_deref(), chain);
        let column = |part: super::spot::Part| {
            Column::new(format!("shift {}", part.word), part.unit(), part.expected(chain))
        };
        parts.into_iter().map(column).collect()
    }

    fn eval(&self, at: &Posture<'_>, out: &mut Emission) {
        if at.signal(0) >= self.at {
            self.spot.put(self.components.as_deref(), (0, 1), 1.0, at, out);
        }
    }

    fn needs(&self) -> Vec<Signal> {
        vec![Signal::Time]
    }

    fn validate(&self, chain: &Chain) -> Result<(), ModelError> {
        self.spot.check(Self::KIND, self.components.as_deref(), chain)?;
        ascending(Self::KIND, "at_range", self.at_range)
    }

    fn shape(&self) -> Vec<Shape> {
        free("at", "s", self.at, self.at_range, Search::Instant)
    }

    fn with_shape(&self, values: &[f64]) -> Self {
        Shift { at: values.first().copied().unwrap_or(self.at), ..self.clone() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testkit::{check_effect, emitted};
    use truepose_kinematics::{Conditions, FrameId, JointId, samples};

    #[test]
    fn conforms() {
        for chain in samples::all() {
            let at_range = Some([10.0, 300.0]);
            for spot in [Spot::Frame(FrameId::BASE), Spot::Frame(chain.tool_frame()), Spot::Joint(JointId(1))]
            {
                check_effect(&Shift { spot, components: None, at: 100.0, at_range }, &chain);
            }
        }
    }

    #[test]
    fn begins_at_its_instant_and_stays() {
        let chain = samples::ur10();
        let components = Some(vec![Axis::Tz, Axis::Rx]);
        let shift = Shift { spot: Spot::Frame(FrameId::BASE), components, at: 50.0, at_range: None };
        let count = |time| {
            let conditions = Conditions { time, ..Conditions::at(&chain, &[0.0; 6]) };
            emitted(&shift, &chain, &conditions).len()
        };
        assert_eq!([count(49.9), count(50.0), count(1e6)], [0, 2, 2]);
    }
}
