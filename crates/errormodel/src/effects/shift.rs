//! An error that jumps once: something was bumped, changed or mounted anew.
//!
//! `ε(t) = c · [t ≥ t_0]`, one unknown a component of the place; t_0 (`at`, s) is its shape where `at_range` is given.
//!
//! `ε(t) = c · [t_0 ≤ t < t_1]` where it was put right (`until`, s); `ε(t) = [t ≥ t_0] (c + d exp(−(t − t_0)/τ))` where it settles (`settling`
//! τ, s), two unknowns a component: c is what stays. Both are its shapes where `until_range` and `settling_range` are given.
//!
//! Nobody saw it happen: of what was measured, the last on one side of it and the first on the other are known. In between (`gap`) the jump has
//! happened with a probability that grows with the time gone by, `c (t − t_−)/(t_+ − t_−)` is what is to be expected, and there is no
//! prediction with smaller squares.

use super::checks::refused;
use super::spot::Spot;
use super::travel::{ascending, free, positive};
use crate::lanes::{LaneEmission, LanePosture};
use crate::{AnyEffect, Column, Effect, Emission, ModelError, NonlinearParameter, Search, Signal};
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
    /// When it was put right, s; never when absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub until: Option<f64>,
    /// Between which instants `until` is to be found, s; it is known when absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub until_range: Option<[f64; 2]>,
    /// Time constant with which a part of it comes to rest, s; all of it stays when absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub settling: Option<f64>,
    /// Between which values `settling` is to be found, s; it is known when absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub settling_range: Option<[f64; 2]>,
}

impl Shift {
    /// A jump of all components at a known instant, s.
    pub fn of(spot: Spot, at: f64) -> Self {
        Shift {
            spot,
            components: None,
            at,
            at_range: None,
            gap: None,
            until: None,
            until_range: None,
            settling: None,
            settling_range: None,
        }
    }

    /// How much of it has happened, as far as one knows, at an instant, s.
    fn share(&self, time: f64) -> f64 {
        if self.until.is_some_and(|until| time >= until) {
            return 0.0;
        }
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
        let mut columns = Vec::new();
        for part in parts {
            let name = format!("shift {}", part.word);
            columns.push(Column::new(name.clone(), part.unit(), part.expected(chain)));
            if self.settling.is_some() {
                columns.push(Column::new(format!("{name} settles"), part.unit(), part.expected(chain)));
            }
        }
        columns
    }

    fn eval(&self, at: &Posture<'_>, out: &mut Emission) {
        let (time, share) = (at.signal(0), self.share(at.signal(0)));
        if share > 0.0 {
            let stride = 1 + usize::from(self.settling.is_some());
            self.spot.put(self.components.as_deref(), (0, stride), share, at, out);
            if let Some(settling) = self.settling {
                let left = (-(time - self.at).max(0.0) / settling).exp();
                self.spot.put(self.components.as_deref(), (1, stride), share * left, at, out);
            }
        }
    }

    fn eval_lanes(&self, at: &LanePosture<'_>, out: &mut LaneEmission) -> bool {
        let (times, components) = (at.signal(0), self.components.as_deref());
        let stride = 1 + usize::from(self.settling.is_some());
        let share = out.each(at.rows(), |row| self.share(times[row]));
        self.spot.put_lanes(components, (0, stride), share, (at.chain(), out));
        if let Some(settling) = self.settling {
            let left = |row: usize| (-(times[row] - self.at).max(0.0) / settling).exp();
            let left = out.each(at.rows(), left);
            let left = out.product(share, left);
            self.spot.put_lanes(components, (1, stride), left, (at.chain(), out));
        }
        true
    }

    fn needs(&self) -> Vec<Signal> {
        vec![Signal::Time]
    }

    fn without_time(&self) -> Option<Box<dyn AnyEffect>> {
        Some(self.spot.constant(self.components.as_deref()).boxed())
    }

    fn validate(&self, chain: &Chain) -> Result<(), ModelError> {
        self.spot.check(Self::FAMILY, self.components.as_deref(), chain)?;
        ascending(Self::FAMILY, "at_range", self.at_range)?;
        ascending(Self::FAMILY, "gap", self.gap)?;
        ascending(Self::FAMILY, "until_range", self.until_range)?;
        let known = self.at_range.is_none() && self.until_range.is_none();
        match self.until {
            // Where they are searched for, an interval that ends before it begins is none.
            Some(until) if !until.is_finite() || (until <= self.at && known) => {
                return Err(refused(Self::FAMILY, format!("`until` has to be later than `at`, not {until}")));
            }
            None if self.until_range.is_some() => {
                return Err(refused(Self::FAMILY, "`until_range` stands without `until`"));
            }
            _ => {}
        }
        match self.settling {
            Some(settling) => positive(Self::FAMILY, "settling", settling, self.settling_range),
            None if self.settling_range.is_some() => {
                Err(refused(Self::FAMILY, "`settling_range` stands without `settling`"))
            }
            None => Ok(()),
        }
    }

    fn shape(&self) -> Vec<NonlinearParameter> {
        let at = free("at", "s", self.at, self.at_range, Search::Instant);
        let until = self.until.map(|until| free("until", "s", until, self.until_range, Search::Instant));
        let settling = self
            .settling
            .map(|constant| free("settling", "s", constant, self.settling_range, Search::Smooth));
        at.into_iter().chain(until.into_iter().flatten()).chain(settling.into_iter().flatten()).collect()
    }

    fn with_nonlinear(&self, values: &[f64]) -> Self {
        let mut values = values.iter().copied();
        // Those with a range; where none has one, all in turn.
        let ranges = [self.at_range, self.until_range, self.settling_range];
        let none = ranges.iter().all(Option::is_none);
        let mut next = |k: usize, known: Option<f64>| {
            known
                .map(|known| if none || ranges[k].is_some() { values.next().unwrap_or(known) } else { known })
        };
        let at = next(0, Some(self.at)).unwrap_or(self.at);
        let until = next(1, self.until);
        Shift { at, until, settling: next(2, self.settling), gap: None, ..self.clone() }
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
                let jump = Shift { at_range, ..Shift::of(spot, 100.0) };
                check_effect(&jump, &chain);
                let (until, until_range) = (Some(400.0), Some([350.0, 500.0]));
                check_effect(&Shift { until, until_range, ..jump.clone() }, &chain);
                let (settling, settling_range) = (Some(40.0), Some([4.0, 400.0]));
                check_effect(&Shift { settling, settling_range, ..jump }, &chain);
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
    fn what_is_put_right_ends_and_what_settles_leaves_a_part() {
        let chain = samples::ur10();
        let values = |shift: &Shift, time| {
            let conditions = Conditions { time, ..Conditions::at(&chain, &[0.0; 6]) };
            let all = emitted(shift, &chain, &conditions);
            [0, 1].map(|k| all.iter().filter(|e| e.column == k).map(|e| e.value.abs()).sum::<f64>())
        };
        let undone = Shift { until: Some(80.0), ..Shift::of(Spot::Joint(JointId(1)), 50.0) };
        let whole = [40.0, 50.0, 79.0, 80.0].map(|t| values(&undone, t)[0].round() as i32);
        assert_eq!(whole, [0, 1, 1, 0]);
        let settles = Shift { settling: Some(20.0), ..Shift::of(Spot::Joint(JointId(1)), 50.0) };
        assert!(values(&settles, 49.0).iter().all(|value| value.abs() <= 0.0));
        let [stays, left] = values(&settles, 90.0);
        assert!((stays - 1.0).abs() < 1e-15 && (left - (-2f64).exp()).abs() < 1e-15);
        let early = Shift { until: Some(20.0), ..undone };
        assert!(Effect::validate(&early, &chain).unwrap_err().to_string().contains("later than `at`"));
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
