//! An error that moves smoothly with time.
//!
//! `ε(t) = Σ_k c_k (B_k(t) − B_k(t_0))`, k = 2 … N: cubic B-splines on [t_0, t_1] without their constant, so that the
//! drift is zero at t_0 and a constant error stays with the frame's geometry. Before t_0 it is zero, after t_1 it
//! holds its last value.
//!
//! What warms up or settles comes to rest: with a time constant τ it is `ε(t) = c (1 − exp(−(t − t_0)/τ))`, one unknown a
//! component. τ is its shape where `time_constant_range` is given. With `second_time_constant` there are two of them, one more unknown a
//! component: housings and castings.

use super::checks::refused;
use super::expansion::Basis;
use super::spot::Spot;
use super::travel::{ascending, free, positive};
use crate::lanes::{LANES, LaneEmission, LanePosture};
use crate::{AnyEffect, Column, Effect, Emission, ModelError, NonlinearParameter, Search, Signal};
use serde::{Deserialize, Serialize};
use truepose_kinematics::{Axis, Chain, Posture};

/// A smooth function of time.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Drift {
    /// Where.
    #[serde(flatten)]
    pub spot: Spot,
    /// Which components of a frame; all six when absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub components: Option<Vec<Axis>>,
    /// First and last moment of the drift, s.
    pub range: [f64; 2],
    /// Equal pieces into which the range is cut.
    #[serde(default = "four")]
    pub pieces: usize,
    /// Time constant with which it comes to rest, s; a smooth function of any form when absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub time_constant: Option<f64>,
    /// Between which values `time_constant` is to be found, s; it is known when absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub time_constant_range: Option<[f64; 2]>,
    /// A second time constant, s; it needs the first.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub second_time_constant: Option<f64>,
    /// Between which values `second_time_constant` is to be found, s; it is known when absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub second_time_constant_range: Option<[f64; 2]>,
}

fn four() -> usize {
    4
}

impl Drift {
    /// Any smooth function of time, in so many pieces.
    pub fn smooth(spot: Spot, range: [f64; 2], pieces: usize) -> Self {
        Drift {
            spot,
            components: None,
            range,
            pieces,
            time_constant: None,
            time_constant_range: None,
            second_time_constant: None,
            second_time_constant_range: None,
        }
    }

    /// What comes to rest with a time constant, s.
    pub fn settling(spot: Spot, range: [f64; 2], time_constant: f64) -> Self {
        Drift { time_constant: Some(time_constant), ..Drift::smooth(spot, range, four()) }
    }

    fn basis(&self) -> Basis {
        let [lower, upper] = self.range;
        Basis::Spline { lower, upper, pieces: self.pieces, degree: 3 }
    }
}

impl Effect for Drift {
    const FAMILY: &'static str = "drift";
    const ABOUT: &'static str = "base, tool or a joint moves smoothly with time";

    fn load_dependent(&self) -> bool {
        false
    }

    fn columns(&self, chain: &Chain) -> Vec<Column> {
        let mut columns = Vec::new();
        for part in self.spot.parts(self.components.as_deref(), chain) {
            if self.time_constant.is_some() {
                let name = format!("drift {}", part.word);
                columns.push(Column::new(name.clone(), part.unit(), part.expected(chain)));
                if self.second_time_constant.is_some() {
                    columns.push(Column::new(format!("{name} second"), part.unit(), part.expected(chain)));
                }
                continue;
            }
            for k in 2..=self.basis().len() {
                let name = format!("drift {} B{k}", part.word);
                columns.push(Column::new(name, part.unit(), part.expected(chain)));
            }
        }
        columns
    }

    fn eval(&self, at: &Posture<'_>, out: &mut Emission) {
        let (basis, components) = (self.basis(), self.components.as_deref());
        if let Some(constant) = self.time_constant {
            let [from, until] = self.range;
            let age = at.signal(0).clamp(from, until) - from;
            let stride = 1 + usize::from(self.second_time_constant.is_some());
            for (k, constant) in std::iter::once(constant).chain(self.second_time_constant).enumerate() {
                self.spot.put(components, (k, stride), -(-age / constant).exp_m1(), at, out);
            }
            return;
        }
        let stride = basis.len() - 1;
        basis.for_each_from(self.range[0], at.signal(0), |column, value| {
            self.spot.put(components, (column, stride), value, at, out);
        });
    }

    fn eval_lanes(&self, at: &LanePosture<'_>, out: &mut LaneEmission) -> bool {
        let (times, components) = (&at.signal(0)[..at.rows()], self.components.as_deref());
        let [from, until] = self.range;
        if let Some(constant) = self.time_constant {
            let stride = 1 + usize::from(self.second_time_constant.is_some());
            for (k, constant) in std::iter::once(constant).chain(self.second_time_constant).enumerate() {
                let come = |row: usize| -(-(times[row].clamp(from, until) - from) / constant).exp_m1();
                let come = out.each(times.len(), come);
                self.spot.put_lanes(components, (k, stride), come, (at.chain(), out));
            }
            return true;
        }
        let basis = self.basis();
        let stride = basis.len() - 1;
        let values = out.values(stride, |into| {
            for (row, &time) in times.iter().enumerate() {
                basis.for_each_from(from, time, |column, value| into[column * LANES + row] += value);
            }
        });
        for (column, value) in values.enumerate() {
            self.spot.put_lanes(components, (column, stride), value, (at.chain(), out));
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
        ascending(Self::FAMILY, "range", Some(self.range))?;
        match self.time_constant {
            Some(constant) => positive(Self::FAMILY, "time_constant", constant, self.time_constant_range)?,
            None if self.time_constant_range.is_some() => {
                let reason = "`time_constant_range` stands without `time_constant`";
                return Err(refused(Self::FAMILY, reason));
            }
            None => {}
        }
        match self.second_time_constant {
            Some(_) if self.time_constant.is_none() => {
                return Err(refused(Self::FAMILY, "`second_time_constant` stands without `time_constant`"));
            }
            Some(second) => {
                positive(Self::FAMILY, "second_time_constant", second, self.second_time_constant_range)?;
            }
            None if self.second_time_constant_range.is_some() => {
                let reason = "`second_time_constant_range` stands without `second_time_constant`";
                return Err(refused(Self::FAMILY, reason));
            }
            None => {}
        }
        self.basis().check().map_err(|reason| refused(Self::FAMILY, reason))
    }

    fn shape(&self) -> Vec<NonlinearParameter> {
        let of = |name, constant: Option<f64>, range| {
            constant.map(|constant| free(name, "s", constant, range, Search::Smooth))
        };
        let first = of("time_constant", self.time_constant, self.time_constant_range);
        let second = of("second_time_constant", self.second_time_constant, self.second_time_constant_range);
        first.into_iter().chain(second).flatten().collect()
    }

    fn with_nonlinear(&self, values: &[f64]) -> Self {
        let mut values = values.iter().copied();
        // Those with a range; where none has one, all in turn.
        let none = self.time_constant_range.is_none() && self.second_time_constant_range.is_none();
        let first = if none || self.time_constant_range.is_some() { values.next() } else { None };
        let second = if none || self.second_time_constant_range.is_some() { values.next() } else { None };
        Drift {
            time_constant: first.or(self.time_constant),
            second_time_constant: self.second_time_constant.map(|known| second.unwrap_or(known)),
            ..self.clone()
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testkit::{check_effect, emitted};
    use truepose_kinematics::{Conditions, FrameId, JointId, samples};

    fn drift(spot: Spot) -> Drift {
        Drift::smooth(spot, [20.0, 180.0], 4)
    }

    #[test]
    fn conforms() {
        for chain in samples::all() {
            for spot in [Spot::Frame(FrameId::BASE), Spot::Frame(chain.tool_frame()), Spot::Joint(JointId(1))]
            {
                check_effect(&drift(spot), &chain);
                let settling = Drift::settling(spot, [20.0, 180.0], 30.0);
                let time_constant_range = Some([3.0, 300.0]);
                check_effect(&Drift { time_constant_range, ..settling.clone() }, &chain);
                let second_time_constant_range = Some([30.0, 3000.0]);
                let two = Drift { second_time_constant: Some(90.0), second_time_constant_range, ..settling };
                check_effect(&two, &chain);
                check_effect(&Drift { time_constant_range, ..two }, &chain);
            }
        }
    }

    #[test]
    fn two_time_constants_have_an_unknown_each() {
        let chain = samples::ur10();
        let settling = Drift::settling(Spot::Joint(JointId(3)), [0.0, 500.0], 20.0);
        let two = Drift { second_time_constant: Some(100.0), ..settling };
        let conditions = Conditions { time: 40.0, ..Conditions::at(&chain, &[0.0; 6]) };
        let sum = |column: usize| -> f64 {
            emitted(&two, &chain, &conditions).iter().filter(|e| e.column == column).map(|e| e.value).sum()
        };
        assert!((sum(0) - (1.0 - (-2f64).exp())).abs() < 1e-12);
        assert!((sum(1) - (1.0 - (-0.4f64).exp())).abs() < 1e-12);
        let lone = Drift { time_constant: None, ..two };
        assert!(Effect::validate(&lone, &chain).unwrap_err().to_string().contains("without `time_constant`"));
    }

    #[test]
    fn begins_at_zero_follows_a_line_and_holds_its_last_value() {
        let chain = samples::ur10();
        let effect = drift(Spot::Joint(JointId(3)));
        // Greville abscissae: Σ_k (k − 2)/pieces B_k, k from 1, is the straight line from 0 to 1; the constant drops out.
        let line = |time: f64| {
            let conditions = Conditions { time, ..Conditions::at(&chain, &[0.0; 6]) };
            emitted(&effect, &chain, &conditions)
                .iter()
                .map(|e| (e.column + 1) as f64 / 4.0 * e.value)
                .sum::<f64>()
        };
        for (time, expected) in [(-5.0, 0.0), (20.0, 0.0), (60.0, 0.25), (180.0, 1.0), (1e5, 1.0)] {
            assert!((line(time) - expected).abs() < 1e-13, "{time} s: {}", line(time));
        }
    }
}
