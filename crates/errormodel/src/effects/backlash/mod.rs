//! Play in a joint: an error that switches with the direction of the last move, or with the load.
//!
//! ```text
//! δq_j = w/2 · side        approach              side = −a_j            the link lags behind its motor
//!                          load                  side = sat(τ_j / τ_f)  the load lays the joint on one flank
//!                          load_then_approach    side = s − (1 − |s|) a_j,  s = sat(τ_j / τ_f)
//!                          by_load               side = −a_j, and w + w′ |τ_j| in place of w: friction in the gear grows with its load
//!                          presliding            side = −z_j             friction winds the drive up along the way
//!                          weight                side = sgn(a · (p − o) × g)   as load, where no weights are declared
//! dz_j/dq_j = (1 − z_j sgn(dq_j)) / d
//! ```
//!
//! | symbol | here | unit |
//! | --- | --- | --- |
//! | w | the unknown: the whole gap | rad or m |
//! | w′ | the second unknown of `by_load`: growth of the wind-up with the load | rad/(N·m) or m/N |
//! | a_j | the direction in which the joint last moved, −1, 0, +1 | 1 |
//! | τ_j | the load about or along the axis | N·m or N |
//! | τ_f | `flank_load`: from this load on the joint lies on its flank; zero switches at once | N·m or N |
//! | z_j | state of the joint's friction, −1 … 1: a derived channel ([`crate::presliding_channel`]), since effects have no memory | 1 |
//! | d | `width`: pre-sliding distance, over which z_j turns round after a reversal; short of all moves z_j = a_j | rad or m |
//!
//! | a, o, p, g | unit axis of the joint, a point on it, the assumed centre of mass, gravity | 1, m, m, m/s² |
//!
//! Where no weights are declared, p = o + n + λ (e − n) with λ = `center`: [`weight`].
//!
//! With `between` all of this holds in a part of the travel only: local wear.
//!
//! τ_f is its shape where `flank_range` is given, d where `width_range` is, λ where `center_range` is. Sources: Nordin and Gutman, *Controlling mechanical systems
//! with backlash – a survey* (2002), section 2; Dahl, *A solid friction model* (1968).

mod weight;

use super::checks::{joint_moves, refused};
use super::robot_size::robot_size;
use super::travel::{ascending, free, positive, within};
use crate::lanes::{LaneEmission, LanePosture};
use crate::{Column, Effect, Emission, ModelError, NonlinearParameter, Search, Signal, presliding_channel};
use serde::{Deserialize, Serialize};
use truepose_kinematics::{Chain, JointId, JointKind, Posture};

/// What decides on which side a joint with play lies.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Side {
    /// The direction of the last move.
    #[default]
    Approach,
    /// The load about or along the axis.
    Load,
    /// The load where it is heavy enough, else the last move.
    LoadThenApproach,
    /// The direction of the last move, by an angle that grows with the load: friction winds the drive up.
    ByLoad,
    /// Friction with memory: the way since the last reversals.
    Presliding,
    /// The weight of the links behind, none of which is declared: their centre of mass is assumed.
    Weight,
}

/// The gap of one joint.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Backlash {
    /// The joint.
    pub joint: JointId,
    /// What decides the side.
    #[serde(default)]
    pub side: Side,
    /// Load that presses the joint against its flank, N·m or N; zero when absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub flank_load: Option<f64>,
    /// Between which loads `flank_load` is to be found, N·m or N; it is known when absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub flank_range: Option<[f64; 2]>,
    /// Pre-sliding distance, rad or m; of the side `presliding` only, which needs it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub width: Option<f64>,
    /// Between which distances `width` is to be found, rad or m; it is known when absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub width_range: Option<[f64; 2]>,
    /// Where the centre of mass is taken to be, of the side `weight` only, which needs it: 0 at the end of the joint's own link, 1 at the
    /// end of the arm, more with a heavy tool beyond it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub center: Option<f64>,
    /// Between which values `center` is to be found; it is known when absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub center_range: Option<[f64; 2]>,
    /// The part of the travel that is worn, rad or m; all of it when absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub between: Option<[f64; 2]>,
}

impl Backlash {
    /// Of one joint, by what decides the side.
    pub fn of(joint: JointId, side: Side) -> Self {
        Backlash {
            joint,
            side,
            flank_load: None,
            flank_range: None,
            width: None,
            width_range: None,
            center: None,
            center_range: None,
            between: None,
        }
    }

    /// Friction with memory in one joint, with this pre-sliding distance, rad or m.
    pub fn presliding(joint: JointId, width: f64) -> Self {
        Backlash { width: Some(width), ..Backlash::of(joint, Side::Presliding) }
    }

    /// Of one joint that lies on the flank on which the weight behind it lays it, the centre of which is at `center`.
    pub fn by_weight(joint: JointId, center: f64) -> Self {
        Backlash { center: Some(center), ..Backlash::of(joint, Side::Weight) }
    }

    fn pressed(&self, load: f64) -> f64 {
        match self.flank_load {
            Some(flank) => (load / flank).clamp(-1.0, 1.0),
            None if load == 0.0 => 0.0,
            None => load.signum(),
        }
    }
}

impl Effect for Backlash {
    const FAMILY: &'static str = "backlash";
    const ABOUT: &'static str = "joint error that switches with the direction of approach or of the load, or winds up with friction (presliding)";

    fn load_dependent(&self) -> bool {
        !matches!(self.side, Side::Approach | Side::Presliding | Side::Weight)
    }

    fn columns(&self, chain: &Chain) -> Vec<Column> {
        let joint = chain.joint(self.joint);
        let scale = if joint.kind == JointKind::Prismatic { 2e-5 * robot_size(chain) } else { 1e-4 };
        let gap = Column::new(format!("gap {}", joint.name), joint.unit(), scale).within(0.0, f64::INFINITY);
        if self.side != Side::ByLoad {
            return vec![gap];
        }
        // A hundred newton metres (a thousand newton) double it.
        let (load, per) =
            if joint.kind == JointKind::Prismatic { ("N", 1e-3) } else { ("N*m", 1e-2 / robot_size(chain)) };
        let unit = format!("{}/({load})", joint.unit());
        let growing = Column::new(format!("gap {} by load", joint.name), unit, per * scale);
        vec![gap, growing.within(0.0, f64::INFINITY)]
    }

    fn eval(&self, at: &Posture<'_>, out: &mut Emission) {
        let Some(motion) = at.chain().joint_motion(self.joint) else { return };
        if !within(self.between, at.joint(self.joint)) {
            return;
        }
        let side = match self.side {
            Side::Approach | Side::ByLoad | Side::Presliding => -at.signal(0),
            Side::Load => self.pressed(at.joint_load(self.joint)),
            Side::Weight => {
                self.center.map_or(0.0, |center| self.pressed(weight::moment(at, self.joint, center)))
            }
            Side::LoadThenApproach => {
                let pressed = self.pressed(at.joint_load(self.joint));
                pressed - (1.0 - pressed.abs()) * at.signal(0)
            }
        };
        if side != 0.0 {
            out.along(0, &motion, 0.5 * side);
            if self.side == Side::ByLoad {
                out.along(1, &motion, 0.5 * side * at.joint_load(self.joint).abs());
            }
        }
    }

    fn eval_lanes(&self, at: &LanePosture<'_>, out: &mut LaneEmission) -> bool {
        let (Some(joint), Some(motion)) = (at.joint(self.joint), at.chain().joint_motion(self.joint)) else {
            return false;
        };
        let here = |row: usize| within(self.between, joint[row]);
        match self.side {
            Side::Approach | Side::ByLoad | Side::Presliding => {
                let from = at.signal(0);
                let half = out.each(at.rows(), |row| if here(row) { -0.5 * from[row] } else { 0.0 });
                out.along(0, &motion, half);
                if self.side == Side::ByLoad {
                    let load = at.joint_load(self.joint);
                    let load = out.each(at.rows(), |row| load[row].abs());
                    let by_load = out.product(half, load);
                    out.along(1, &motion, by_load);
                }
            }
            Side::Load | Side::LoadThenApproach => {
                let load = at.joint_load(self.joint);
                let from = (self.side == Side::LoadThenApproach).then(|| at.signal(0));
                let half = out.each(at.rows(), |row| {
                    let pressed = self.pressed(load[row]);
                    let free = from.map_or(0.0, |from| (1.0 - pressed.abs()) * from[row]);
                    if here(row) { 0.5 * (pressed - free) } else { 0.0 }
                });
                out.along(0, &motion, half);
            }
            Side::Weight => return false,
        }
        true
    }

    fn needs(&self) -> Vec<Signal> {
        match (self.side, self.width) {
            (Side::Load | Side::Weight, _) => Vec::new(),
            (Side::Presliding, Some(width)) => {
                vec![Signal::Channel(presliding_channel(self.joint, width))]
            }
            _ => vec![Signal::Approach(self.joint)],
        }
    }

    fn validate(&self, chain: &Chain) -> Result<(), ModelError> {
        joint_moves(Self::FAMILY, self.joint, chain)?;
        ascending(Self::FAMILY, "between", self.between)?;
        match self.width {
            Some(width) if self.side == Side::Presliding => {
                positive(Self::FAMILY, "width", width, self.width_range)?;
            }
            Some(_) => return Err(refused(Self::FAMILY, "`width` belongs to the side `presliding`")),
            None if self.side == Side::Presliding => {
                return Err(refused(
                    Self::FAMILY,
                    "the side `presliding` needs `width`, the pre-sliding distance in rad or m",
                ));
            }
            None if self.width_range.is_some() => {
                return Err(refused(Self::FAMILY, "`width_range` stands without `width`"));
            }
            None => {}
        }
        match self.center {
            Some(center) if self.side == Side::Weight => {
                positive(Self::FAMILY, "center", center, self.center_range)?;
            }
            Some(_) => return Err(refused(Self::FAMILY, "`center` belongs to the side `weight`")),
            None if self.side == Side::Weight => {
                return Err(refused(
                    Self::FAMILY,
                    "the side `weight` needs `center`, 0 (end of the joint's own link) to 1 (end of the arm)",
                ));
            }
            None if self.center_range.is_some() => {
                return Err(refused(Self::FAMILY, "`center_range` stands without `center`"));
            }
            None => {}
        }
        match self.flank_load {
            Some(_) if !matches!(self.side, Side::Load | Side::LoadThenApproach) => Err(refused(
                Self::FAMILY,
                "`flank_load` belongs to the sides `load` and `load_then_approach`",
            )),
            Some(load) => positive(Self::FAMILY, "flank_load", load, self.flank_range),
            None if self.flank_range.is_some() => {
                Err(refused(Self::FAMILY, "`flank_range` stands without `flank_load`"))
            }
            None => Ok(()),
        }
    }

    fn shape(&self) -> Vec<NonlinearParameter> {
        if let Some(width) = self.width {
            return free("width", "rad or m", width, self.width_range, Search::Smooth);
        }
        if let Some(center) = self.center {
            return free("center", "1", center, self.center_range, Search::Smooth);
        }
        let shape = |load| free("flank_load", "N*m or N", load, self.flank_range, Search::Smooth);
        self.flank_load.map_or_else(Vec::new, shape)
    }

    fn with_nonlinear(&self, values: &[f64]) -> Self {
        let value = values.first().copied();
        match self.side {
            Side::Presliding => Backlash { width: value.or(self.width), ..self.clone() },
            Side::Weight => Backlash { center: value.or(self.center), ..self.clone() },
            _ => Backlash { flank_load: value.or(self.flank_load), ..self.clone() },
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testkit::{check_effect, emitted};
    use truepose_kinematics::nalgebra::Vector3;
    use truepose_kinematics::{Conditions, Load, Payload, samples};

    #[test]
    fn conforms() {
        for chain in samples::all() {
            for &joint in chain.movable() {
                for side in [Side::Approach, Side::Load, Side::LoadThenApproach, Side::ByLoad] {
                    check_effect(&Backlash::of(joint, side), &chain);
                }
                let (flank_load, flank_range) = (Some(30.0), Some([5.0, 200.0]));
                let effect = Backlash { flank_load, flank_range, ..Backlash::of(joint, Side::Load) };
                check_effect(&effect, &chain);
                let wound = Backlash { width_range: Some([0.01, 0.2]), ..Backlash::presliding(joint, 0.05) };
                check_effect(&wound, &chain);
                let center_range = Some([0.1, 0.9]);
                check_effect(&Backlash { center_range, ..Backlash::by_weight(joint, 0.3) }, &chain);
                let worn = Backlash { between: Some([-0.2, 0.4]), ..Backlash::of(joint, Side::Approach) };
                check_effect(&worn, &chain);
            }
        }
    }

    #[test]
    fn friction_reads_its_wind_up_and_needs_a_distance() {
        let chain = samples::ur10();
        let effect = Backlash::presliding(JointId(2), 0.05);
        assert_eq!(Effect::needs(&effect), [Signal::Channel("z_2~w=0.05".into())]);
        let mut conditions = Conditions::at(&chain, &[0.3; 6]);
        conditions.channels = vec![0.4];
        let sum: f64 = emitted(&effect, &chain, &conditions).iter().map(|e| e.value).sum();
        assert!((sum + 0.2).abs() < 1e-15);
        let refused = |effect: Backlash| Effect::validate(&effect, &chain).unwrap_err().to_string();
        assert!(refused(Backlash { width: None, ..effect.clone() }).contains("needs `width`"));
        assert!(refused(Backlash { side: Side::Approach, ..effect.clone() }).contains("belongs to the side"));
        assert!(refused(Backlash { width: Some(0.0), ..effect }).contains("`width` has to be positive"));
    }

    #[test]
    fn local_wear_acts_in_its_part_of_the_travel() {
        let chain = samples::ur10();
        let worn = Backlash { between: Some([0.2, 0.5]), ..Backlash::of(JointId(2), Side::Approach) };
        let at = |q: f64| {
            let mut conditions = Conditions::at(&chain, &[0.0, q, 0.0, 0.0, 0.0, 0.0]);
            conditions.approach[1] = -1.0;
            emitted(&worn, &chain, &conditions).iter().map(|e| e.value).sum::<f64>()
        };
        let halves = [0.1, 0.2, 0.49, 0.5].map(|q| (2.0 * at(q)).round() as i32);
        assert_eq!(halves, [0, 1, 1, 0]);
        let none = Backlash { between: Some([0.5, 0.2]), ..worn };
        assert!(Effect::validate(&none, &chain).unwrap_err().to_string().contains("`between`"));
    }

    #[test]
    fn it_lags_behind_the_move_and_hangs_with_the_load() {
        let chain = samples::ur10();
        let value = |side, approach, mass: f64| {
            let load = Load::Payload(Payload { mass, com: Vector3::zeros() });
            let mut conditions = Conditions::at(&chain, &[0.3; 6]).with_load(load);
            conditions.approach[1] = approach;
            let effect = Backlash { flank_load: None, ..Backlash::of(JointId(2), side) };
            emitted(&effect, &chain, &conditions).iter().map(|e| e.value).sum::<f64>()
        };
        let growing = |approach, mass: f64| {
            let load = Load::Payload(Payload { mass, com: Vector3::zeros() });
            let mut conditions = Conditions::at(&chain, &[0.3; 6]).with_load(load);
            conditions.approach[1] = approach;
            let entries = emitted(&Backlash::of(JointId(2), Side::ByLoad), &chain, &conditions);
            [0, 1].map(|k| entries.iter().filter(|e| e.column == k).map(|e| e.value).sum::<f64>())
        };
        let ([gap, light], [_, heavy]) = (growing(1.0, 5.0), growing(-1.0, 10.0));
        assert!(
            (gap + 0.5).abs() < 1e-15 && light < 0.0 && (heavy + 2.0 * light).abs() < 1e-9 * heavy,
            "{light} {heavy}"
        );
        let check = |got: f64, expected: f64| assert!((got - expected).abs() < 1e-15, "{got} {expected}");
        check(value(Side::Approach, 1.0, 0.0), -0.5);
        check(value(Side::Approach, 0.0, 0.0), 0.0);
        // A stretched UR10 at positive q2 points along −x: its weight turns j2 in the positive sense.
        check(value(Side::Load, 1.0, 10.0), 0.5);
        check(value(Side::LoadThenApproach, 1.0, 0.0), -0.5);
        check(value(Side::LoadThenApproach, 1.0, 10.0), 0.5);
    }
}
