//! An error that follows a temperature, at once or late: lengths that grow, joints and frames that move.
//!
//! ```text
//! length       t_j = c (T − T_ref) (tip − root)      link j grows by a strain c a kelvin       1/K
//! scale        δq_j = (c (T − T_ref) + c_ref) q_j    a slide's scale grows                     1/K, 1
//! motion       δq_j = c (T − T_ref)                  a joint moves beyond what it says         rad/K or m/K
//! (a frame)    ε_i = c (T − T_ref)                   components of E_i                         rad/K or m/K
//! ```
//!
//! Root and tip are those of [`truepose_kinematics::Span`]; T_ref only moves a share of the error into the constants. No constant
//! error is a slide's scale: where the slide is right at an unknown temperature, `offset` asks for c_ref as well (else it is zero).
//!
//! A body that follows the channel late, `lag · dT/dt = T_channel − T`, asks for a derived column: effects have no
//! memory. Its name is the channel's with the lag in seconds, `temperature~lag=600`, at fit time and in the controller
//! alike; [`crate::Dataset::derived_for`] makes it. The lag is its shape where `lag_range` is given: other values ask
//! for other columns.

use super::checks::refused;
use super::spot::Part;
use super::spot::Spot;
use super::travel::{ascending, free};
use crate::{Column, Effect, Emission, ModelError, NonlinearParameter, Search, Signal, late_channel};
use serde::{Deserialize, Serialize};
use truepose_kinematics::{Axis, Chain, JointId, JointKind, Posture, Site};

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
        let name = |joint: JointId| &chain.joint(joint).name;
        match self.growth(chain) {
            Some((joint, Grows::Length)) => {
                vec![Column::new(format!("growth {}", name(joint)), "1/K", STRAIN)]
            }
            Some((joint, Grows::Scale)) => {
                let growing = Column::new(format!("scale {}", name(joint)), "1/K", STRAIN);
                let constant = Column::new(format!("scale {} at reference", name(joint)), "1", SCALE);
                if self.offset { vec![growing, constant] } else { vec![growing] }
            }
            _ => {
                // Ten kelvin move a place by a tenth of what its constant errors are.
                let column = |part: Part| {
                    let unit = format!("{}/K", part.unit());
                    Column::new(format!("thermal {}", part.word), unit, 1e-2 * part.expected(chain))
                };
                let parts = self.spot.parts(self.components.as_deref(), chain);
                parts.into_iter().map(column).collect()
            }
        }
    }

    fn eval(&self, at: &Posture<'_>, out: &mut Emission) {
        let warmer = at.signal(0) - self.reference;
        match self.growth(at.chain()) {
            Some((joint, Grows::Length)) => {
                let (span, frame) = (at.span(joint), at.chain().frame_after(joint));
                let longer = at.frame(frame).rotation.tr_mul(&(span.tip - span.root)) * warmer;
                for axis in Axis::TRANSLATIONS {
                    out.push(0, Site::Frame(frame, axis), longer[axis.direction()]);
                }
            }
            Some((joint, Grows::Scale)) => {
                if let Some(motion) = at.chain().joint_motion(joint) {
                    out.along(0, &motion, at.joint(joint) * warmer);
                    if self.offset {
                        out.along(1, &motion, at.joint(joint));
                    }
                }
            }
            _ => self.spot.put(self.components.as_deref(), (0, 1), warmer, at, out),
        }
    }

    fn needs(&self) -> Vec<Signal> {
        let name = match self.lag {
            Some(lag) => late_channel(&self.channel, lag),
            None => self.channel.clone(),
        };
        vec![Signal::Channel(name)]
    }

    fn validate(&self, chain: &Chain) -> Result<(), ModelError> {
        self.spot.check(Self::FAMILY, self.components.as_deref(), chain)?;
        ascending(Self::FAMILY, "lag_range", self.lag_range)?;
        let refuse = |reason: String| Err(refused(Self::FAMILY, reason));
        match self.growth(chain) {
            None if self.grows.is_some() => {
                return refuse("`grows` belongs to a joint; a frame has `components`".into());
            }
            Some((joint, Grows::Length)) if chain.link_length(joint) < 1e-6 => {
                let name = &chain.joint(joint).name;
                return refuse(format!("the link behind joint `{name}` has no length that could grow"));
            }
            Some((joint, Grows::Scale)) if chain.joint(joint).kind != JointKind::Prismatic => {
                let name = &chain.joint(joint).name;
                return refuse(format!("joint `{name}` turns; the scale that grows is a slide's"));
            }
            growth if self.offset && !matches!(growth, Some((_, Grows::Scale))) => {
                return refuse("`offset` belongs to a slide's scale; elsewhere the constants have it".into());
            }
            _ => {}
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
        self.lag.map_or_else(Vec::new, |lag| free("lag", "s", lag, self.lag_range, Search::Smooth))
    }

    fn with_nonlinear(&self, values: &[f64]) -> Self {
        Thermal { lag: values.first().copied().or(self.lag), ..self.clone() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testkit::{check_effect, emitted};
    use truepose_kinematics::{Conditions, FrameId, samples};

    #[test]
    fn conforms() {
        for chain in samples::all() {
            for spot in [Spot::Frame(FrameId::BASE), Spot::Frame(chain.tool_frame())] {
                check_effect(&Thermal::of(spot, "t"), &chain);
            }
            for &joint in chain.movable().iter().filter(|&&j| chain.link_length(j) > 0.01) {
                check_effect(&Thermal::of(Spot::Joint(joint), "t"), &chain);
                let (lag, lag_range) = (Some(600.0), Some([60.0, 7200.0]));
                let grows = Some(Grows::Motion);
                let late = Thermal { lag, lag_range, grows, ..Thermal::of(Spot::Joint(joint), "t") };
                check_effect(&late, &chain);
            }
            let slides = |joint: &&JointId| chain.joint(**joint).kind == JointKind::Prismatic;
            for &joint in chain.movable().iter().filter(slides) {
                check_effect(&Thermal { offset: true, ..Thermal::of(Spot::Joint(joint), "t") }, &chain);
            }
        }
    }

    #[test]
    fn an_upper_arm_grows_along_itself_in_every_convention() {
        for (chain, along) in [(samples::ur10(), -0.612), (samples::heavy(), 1.1)] {
            let effect = Thermal::of(Spot::Joint(JointId(2)), "t");
            let mut conditions = Conditions::at(&chain, &[0.2; 6]);
            conditions.channels = vec![23.0];
            let entries = emitted(&effect, &chain, &conditions);
            assert_eq!(entries[0].site, Site::Frame(FrameId(2), Axis::Tx));
            assert!((entries[0].value - 3.0 * along).abs() < 1e-12, "{}", entries[0].value);
            assert!(entries[1].value.abs() < 1e-12 && entries[2].value.abs() < 1e-12);
        }
    }

    #[test]
    fn a_late_body_asks_for_a_derived_column() {
        let late = Thermal { lag: Some(600.0), ..Thermal::of(Spot::Frame(FrameId::BASE), "temperature") };
        assert_eq!(Effect::needs(&late), [Signal::Channel("temperature~lag=600".into())]);
    }

    #[test]
    fn what_makes_no_sense_is_refused() {
        let error = |effect: Thermal| Effect::validate(&effect, &samples::pps()).unwrap_err().to_string();
        let scale = Thermal { grows: Some(Grows::Scale), ..Thermal::of(Spot::Joint(JointId(4)), "t") };
        assert_eq!(error(scale), "effect `thermal`: joint `theta` turns; the scale that grows is a slide's");
        let frame = Thermal { grows: Some(Grows::Length), ..Thermal::of(Spot::Frame(FrameId(0)), "t") };
        assert!(error(frame).contains("`components`"));
        let base = Thermal { offset: true, ..Thermal::of(Spot::Frame(FrameId(0)), "t") };
        assert_eq!(
            error(base),
            "effect `thermal`: `offset` belongs to a slide's scale; elsewhere the constants have it"
        );
    }

    #[test]
    fn a_slide_may_be_wrong_before_it_grows() {
        let chain = samples::pps();
        let joint = JointId(1);
        let effect = Thermal { offset: true, ..Thermal::of(Spot::Joint(joint), "t") };
        let mut conditions = Conditions::at(&chain, &[0.4, 0.4, 0.4, 0.0, 0.0, 0.0]);
        conditions.channels = vec![25.0];
        let size = |column: usize| -> f64 {
            let entries = emitted(&effect, &chain, &conditions);
            entries.iter().filter(|e| e.column == column).map(|e| e.value.powi(2)).sum::<f64>().sqrt()
        };
        // Five kelvin above the room, 0.4 m from zero.
        assert!((size(0) - 5.0 * 0.4).abs() < 1e-12 && (size(1) - 0.4).abs() < 1e-12);
    }
}
