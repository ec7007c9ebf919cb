//! An error that follows a temperature, at once or late: lengths that grow, joints and frames that move.
//!
//! ```text
//! length       t_j = c (T − T_ref) (tip − root)      link j grows by a strain c a kelvin       1/K
//! scale        δq_j = (c (T − T_ref) + c_ref) q_j    a slide's scale grows                     1/K, 1
//! motion       δq_j = c (T − T_ref)                  a joint moves beyond what it says         rad/K or m/K
//! (a frame)    ε_i = c (T − T_ref)                   components of E_i                         rad/K or m/K
//! arm          all lengths and the scales of all slides grow by one strain c a kelvin          1/K
//! ```
//!
//! With `minus` T is the difference of two channels: a gradient bends what one temperature stretches (T_ref = 0). With `second_lag` the body has two time
//! constants, each with a coefficient of its own. What heats itself has no thermometer: its channel is a history
//! ([`crate::History`]), `channel = "travel_3"`, `"work_3"` or `"working_300"` with a `lag`, in its unit in place of K and zero where it is cold.
//!
//! Root and tip are those of [`truepose_kinematics::Span`]; T_ref only moves a share of the error into the constants. No constant
//! error is a slide's scale: where the slide is right at an unknown temperature, `offset` asks for c_ref as well (else it is zero).
//!
//! A body that follows the channel late, `lag · dT/dt = T_channel − T`, asks for a derived column: effects have no
//! memory. Its name is the channel's with the lag in seconds, `temperature~lag=600`, at fit time and in the controller
//! alike; [`crate::Dataset::derived_for`] makes it. The lag is its shape where `lag_range` is given: other values ask
//! for other columns.

mod growth;

use crate::effects::checks::refused;
use crate::effects::spot::Part;
use crate::effects::spot::Spot;
use crate::effects::travel::{ascending, free};
use crate::lanes::{LaneEmission, LanePosture};
use crate::{
    Column, Effect, Emission, History, ModelError, NonlinearParameter, Search, Signal, late_channel,
};
use serde::{Deserialize, Serialize};
use truepose_kinematics::{Axis, Chain, FrameId, JointId, JointKind, Posture};

/// What of a joint grows with temperature.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Grows {
    /// The length of the link behind it.
    Length,
    /// The scale of a slide.
    Scale,
    /// The joint itself moves about or along its axis.
    Motion,
    /// All lengths and the scales of all slides; it belongs to the base (`frame = "base"`).
    Arm,
}

/// Growth with a temperature channel.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Thermal {
    /// Where.
    #[serde(flatten)]
    pub spot: Spot,
    /// What of a joint grows; the link's length when absent, a slide's scale.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub grows: Option<Grows>,
    /// Which components of a frame; all six when absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub components: Option<Vec<Axis>>,
    /// The temperature channel.
    pub channel: String,
    /// Where the nominal robot is right, in the channel's unit (degC).
    #[serde(default = "room")]
    pub reference: f64,
    /// Whether a slide's scale is wrong at the reference already, by how much is to be found.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub offset: bool,
    /// Time constant with which the body follows the channel, s; at once when absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub lag: Option<f64>,
    /// Between which time constants `lag` is to be found, s; it is known when absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub lag_range: Option<[f64; 2]>,
    /// Time constant of a second part of the body, s; it needs `lag`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub second_lag: Option<f64>,
    /// Between which time constants `second_lag` is to be found, s; it is known when absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub second_lag_range: Option<[f64; 2]>,
    /// A channel whose value is taken from that of `channel`: a gradient.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub minus: Option<String>,
}

fn room() -> f64 {
    20.0
}

impl Thermal {
    /// Of one place, at once.
    pub fn of(spot: Spot, channel: impl Into<String>) -> Self {
        let channel = channel.into();
        Thermal {
            spot,
            grows: None,
            components: None,
            channel,
            reference: room(),
            offset: false,
            lag: None,
            lag_range: None,
            second_lag: None,
            second_lag_range: None,
            minus: None,
        }
    }

    /// Of the difference of two thermometers at one place.
    pub fn gradient(spot: Spot, channel: impl Into<String>, minus: impl Into<String>) -> Self {
        Thermal { minus: Some(minus.into()), reference: 0.0, ..Thermal::of(spot, channel) }
    }

    /// Of the whole arm: all links are of one material.
    pub fn arm(channel: impl Into<String>) -> Self {
        Thermal { grows: Some(Grows::Arm), ..Thermal::of(Spot::Frame(FrameId::BASE), channel) }
    }

    /// Of what heats itself, with this time constant, s.
    pub fn by(spot: Spot, history: History, lag: f64) -> Self {
        Thermal { lag: Some(lag), reference: 0.0, ..Thermal::of(spot, history.source()) }
    }

    /// What it reads where that is no thermometer but a history.
    fn history(&self) -> Option<History> {
        self.lag.and_then(|_| History::of_source(&self.channel))
    }

    /// Unit of what it reads, and how much of it makes as much as a kelvin.
    fn unit(&self) -> (&'static str, f64) {
        match self.history() {
            None => ("K", 1.0),
            // Twenty kelvin: of a robot at work, of a joint of 1 rad/s (1 m/s) without a pause, or of 30 W.
            Some(History::Working(_)) => ("1", 0.05),
            Some(History::Work(_)) => ("W", 1.5),
            Some(_) => ("(1/s)", 0.05),
        }
    }

    /// The signals for each time constant: the channel, and the one that is taken away.
    fn channels(&self) -> impl Iterator<Item = String> + '_ {
        let lags = match (self.lag, self.second_lag) {
            (None, _) => vec![None],
            (Some(lag), None) => vec![Some(lag)],
            (Some(lag), Some(second)) => vec![Some(lag), Some(second)],
        };
        let named = |source: &str, lag: Option<f64>| {
            lag.map_or_else(|| source.to_owned(), |lag| late_channel(source, lag))
        };
        lags.into_iter().flat_map(move |lag| {
            std::iter::once(named(&self.channel, lag))
                .chain(self.minus.iter().map(move |minus| named(minus, lag)))
        })
    }

    /// How many time constants it has.
    fn parts(&self) -> usize {
        1 + usize::from(self.lag.is_some() && self.second_lag.is_some())
    }

    /// The columns of one time constant.
    fn columns_once(&self, chain: &Chain) -> Vec<Column> {
        let name = |joint: JointId| &chain.joint(joint).name;
        let (unit, per) = self.unit();
        let strain = |what: String| Column::new(what, format!("1/{unit}"), STRAIN / per);
        if self.grows == Some(Grows::Arm) {
            return vec![strain("growth of the arm".into())];
        }
        match self.growth(chain) {
            Some((joint, Grows::Length)) => vec![strain(format!("growth {}", name(joint)))],
            Some((joint, Grows::Scale)) => {
                let growing = strain(format!("scale {}", name(joint)));
                let constant = Column::new(format!("scale {} at reference", name(joint)), "1", SCALE);
                if self.offset { vec![growing, constant] } else { vec![growing] }
            }
            _ => {
                // Ten kelvin move a place by a tenth of what its constant errors are.
                let column = |part: Part| {
                    let unit = format!("{}/{unit}", part.unit());
                    Column::new(format!("thermal {}", part.word), unit, 1e-2 * part.expected(chain) / per)
                };
                let parts = self.spot.parts(self.components.as_deref(), chain);
                parts.into_iter().map(column).collect()
            }
        }
    }

    /// What grows, when it is a joint's.
    fn growth(&self, chain: &Chain) -> Option<(JointId, Grows)> {
        let Spot::Joint(joint) = self.spot else { return None };
        let usual =
            if chain.joint(joint).kind == JointKind::Prismatic { Grows::Scale } else { Grows::Length };
        Some((joint, self.grows.unwrap_or(usual)))
    }
}

/// Steel, 1/K.
const STRAIN: f64 = 1.2e-5;
/// A slide's scale before it grows, 1.
const SCALE: f64 = 1e-4;

impl Effect for Thermal {
    const FAMILY: &'static str = "thermal";
    const ABOUT: &'static str =
        "a length, a slide's scale, a joint or a frame follows a temperature, at once or late";

    fn load_dependent(&self) -> bool {
        false
    }

    fn columns(&self, chain: &Chain) -> Vec<Column> {
        let mut columns = self.columns_once(chain);
        if self.parts() > 1 {
            let second =
                self.columns_once(chain).into_iter().filter(|column| !column.name.ends_with("reference"));
            let second: Vec<Column> = second.collect();
            columns.extend(second.into_iter().map(|c| Column { name: format!("{} second", c.name), ..c }));
        }
        columns
    }

    fn eval(&self, at: &Posture<'_>, out: &mut Emission) {
        let stride = 1 + usize::from(self.minus.is_some());
        let reference = if self.history().is_some() { 0.0 } else { self.reference };
        let mut first = 0;
        for part in 0..self.parts() {
            let mut warmer = at.signal(part * stride) - reference;
            if self.minus.is_some() {
                warmer -= at.signal(part * stride + 1);
            }
            self.grow(first, warmer, part == 0, at, out);
            first += self.count(at.chain());
        }
    }

    fn eval_lanes(&self, at: &LanePosture<'_>, out: &mut LaneEmission) -> bool {
        let stride = 1 + usize::from(self.minus.is_some());
        let reference = if self.history().is_some() { 0.0 } else { self.reference };
        let chain = at.chain();
        let mut first = 0;
        for part in 0..self.parts() {
            let warm = at.signal(part * stride);
            let less = self.minus.is_some().then(|| at.signal(part * stride + 1));
            let above = |row: usize| warm[row] - reference - less.map_or(0.0, |less| less[row]);
            let warmer = out.each(at.rows(), above);
            self.grow_lanes((first, part == 0), warmer, at, out);
            first += self.count(chain);
        }
        true
    }

    fn needs(&self) -> Vec<Signal> {
        self.channels().map(Signal::Channel).collect()
    }

    fn validate(&self, chain: &Chain) -> Result<(), ModelError> {
        self.spot.check(Self::FAMILY, self.components.as_deref(), chain)?;
        ascending(Self::FAMILY, "lag_range", self.lag_range)?;
        ascending(Self::FAMILY, "second_lag_range", self.second_lag_range)?;
        let refuse = |reason: String| Err(refused(Self::FAMILY, reason));
        if self.minus.as_ref() == Some(&self.channel) {
            return refuse("`minus` is the channel itself: the difference is zero".into());
        }
        match self.second_lag {
            Some(_) if self.lag.is_none() => return refuse("`second_lag` stands without `lag`".into()),
            Some(lag) if !lag.is_finite() || lag <= 0.0 => {
                return refuse(format!("`second_lag` has to be positive, not {lag}"));
            }
            None if self.second_lag_range.is_some() => {
                return refuse("`second_lag_range` stands without `second_lag`".into());
            }
            _ => {}
        }
        if self.grows == Some(Grows::Arm) {
            if self.spot != Spot::Frame(FrameId::BASE) || self.components.is_some() {
                return refuse(
                    "`grows = \"arm\"` belongs to `frame = \"base\"`, without `components`".into(),
                );
            }
        } else {
            self.grown(chain)?;
        }
        match self.lag {
            Some(lag) if !lag.is_finite() || lag <= 0.0 => {
                refuse(format!("`lag` has to be positive, not {lag}; leave it out to follow at once"))
            }
            None if self.lag_range.is_some() => refuse("`lag_range` stands without `lag`".into()),
            _ if !self.reference.is_finite() => refuse("`reference` has to be finite".into()),
            _ => Ok(()),
        }
    }

    fn shape(&self) -> Vec<NonlinearParameter> {
        let first = self.lag.map(|lag| free("lag", "s", lag, self.lag_range, Search::Smooth));
        let second =
            self.second_lag.map(|lag| free("second_lag", "s", lag, self.second_lag_range, Search::Smooth));
        first.into_iter().chain(second).flatten().collect()
    }

    fn with_nonlinear(&self, values: &[f64]) -> Self {
        let mut values = values.iter().copied();
        // Those with a range; where none has one, all in turn.
        let none = self.lag_range.is_none() && self.second_lag_range.is_none();
        let lag = if none || self.lag_range.is_some() { values.next() } else { None };
        let second = if none || self.second_lag_range.is_some() { values.next() } else { None };
        Thermal {
            lag: lag.or(self.lag),
            second_lag: second.filter(|_| self.second_lag.is_some()).or(self.second_lag),
            ..self.clone()
        }
    }
}

impl Thermal {
    /// Refuses what cannot grow at this place.
    fn grown(&self, chain: &Chain) -> Result<(), ModelError> {
        let refuse = |reason: String| Err(refused(Self::FAMILY, reason));
        match self.growth(chain) {
            None if self.grows.is_some() => {
                refuse("`grows` belongs to a joint; a frame has `components`".into())
            }
            Some((joint, Grows::Length)) if chain.link_length(joint) < 1e-6 => {
                let name = &chain.joint(joint).name;
                refuse(format!("the link behind joint `{name}` has no length that could grow"))
            }
            Some((joint, Grows::Scale)) if chain.joint(joint).kind != JointKind::Prismatic => {
                let name = &chain.joint(joint).name;
                refuse(format!("joint `{name}` turns; the scale that grows is a slide's"))
            }
            growth if self.offset && !matches!(growth, Some((_, Grows::Scale))) => {
                refuse("`offset` belongs to a slide's scale; elsewhere the constants have it".into())
            }
            _ => Ok(()),
        }
    }
}

#[cfg(test)]
mod tests;
