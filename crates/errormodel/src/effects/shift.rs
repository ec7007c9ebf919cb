//! An error that jumps once: something was bumped, changed or mounted anew.
//!
//! `ε(t) = c · [t ≥ t_0]`, one unknown a component of the place; t_0 (`at`, s) is its shape where `at_range` is given.
//!
//! Nobody saw it happen: of what was measured, the last on one side of it and the first on the other are known. In between (`gap`) the jump has
//! happened with a probability that grows with the time gone by, `c (t − t_−)/(t_+ − t_−)` is what is to be expected, and there is no
//! prediction with smaller squares.

use super::spot::Spot;
use super::travel::{ascending, free};
use crate::{Column, Effect, Emission, ModelError, NonlinearParameter, Search, Signal};
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
    /// Last instant known to be before it and first one known to be after it, s; when absent all of it happens at `at`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub gap: Option<[f64; 2]>,
}

impl Shift {
    /// A jump of all components at a known instant, s.
    pub fn of(spot: Spot, at: f64) -> Self {
        Shift { spot, components: None, at, at_range: None, gap: None }
    }

    /// How much of it has happened, as far as one knows, at an instant, s.
    fn share(&self, time: f64) -> f64 {
        match self.gap {
            Some([before, after]) => ((time - before) / (after - before)).clamp(0.0, 1.0),
            None => f64::from(time >= self.at),
        }
    }
}

impl Effect for Shift {
    const FAMILY: &'static str = "shift";
    const ABOUT: &'static str = "base, tool or a joint jumps once, at an instant that may be unknown";

    fn load_dependent(&self) -> bool {
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
        let share = self.share(at.signal(0));
        if share > 0.0 {
            self.spot.put(self.components.as_deref(), (0, 1), share, at, out);
        }
    }

    fn needs(&self) -> Vec<Signal> {
        vec![Signal::Time]
    }

    fn validate(&self, chain: &Chain) -> Result<(), ModelError> {
        self.spot.check(Self::FAMILY, self.components.as_deref(), chain)?;
        ascending(Self::FAMILY, "at_range", self.at_range)?;
        ascending(Self::FAMILY, "gap", self.gap)
    }

    fn shape(&self) -> Vec<NonlinearParameter> {
        free("at", "s", self.at, self.at_range, Search::Instant)
    }

    fn with_nonlinear(&self, values: &[f64]) -> Self {
        Shift { at: values.first().copied().unwrap_or(self.at), gap: None, ..self.clone() }
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
                check_effect(&Shift { at_range, ..Shift::of(spot, 100.0) }, &chain);
            }
        }
    }

    #[test]
    fn begins_at_its_instant_and_stays() {
        let chain = samples::ur10();
        let components = Some(vec![Axis::Tz, Axis::Rx]);
        let shift = Shift { components, ..Shift::of(Spot::Frame(FrameId::BASE), 50.0) };
        let count = |time| {
            let conditions = Conditions { time, ..Conditions::at(&chain, &[0.0; 6]) };
            emitted(&shift, &chain, &conditions).len()
        };
        assert_eq!([count(49.9), count(50.0), count(1e6)], [0, 2, 2]);
    }

    #[test]
    fn what_nobody_saw_has_happened_in_part() {
        let chain = samples::ur10();
        let gap = Some([40.0, 60.0]);
        let shift = Shift { gap, ..Shift::of(Spot::Joint(JointId(1)), 50.0) };
        let share = |time| {
            let conditions = Conditions { time, ..Conditions::at(&chain, &[0.0; 6]) };
            emitted(&shift, &chain, &conditions).first().map_or(0.0, |entry| entry.value)
        };
        let whole = share(1e6);
        assert!(whole.abs() > 0.0);
        for (time, expected) in [(0.0, 0.0), (40.0, 0.0), (45.0, 0.25), (50.0, 0.5), (60.0, 1.0), (70.0, 1.0)]
        {
            assert!((share(time) / whole - expected).abs() < 1e-12, "{time}");
        }
        // Where its instant is searched for it happens at once.
        assert_eq!(Effect::with_nonlinear(&shift, &[45.0]).gap, None);
        let none = Shift { gap: Some([60.0, 40.0]), ..shift };
        assert!(Effect::validate(&none, &chain).is_err());
    }
}
