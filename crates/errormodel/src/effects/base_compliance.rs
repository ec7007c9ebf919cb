//! The base tilts and sinks under what it carries.
//!
//! ```text
//! φ_0 = c_t (M − u (u·M))            t_0 = c_s u (u·F)             E_0, in the axes of frame 0
//! ```
//!
//! | symbol | here | unit | frame |
//! | --- | --- | --- | --- |
//! | F, M | the wrench that frame 0 carries, about its origin | N, N·m | 0 |
//! | u | up, against gravity | 1 | 0 |
//! | c_t, c_s | the unknowns | rad/(N·m), m/N | |
//!
//! Weights have no moment about the vertical and no horizontal force: tilt about two horizontal axes (alike, or each with
//! its own unknown) and sinking are all that they can show, whichever way the base leans. `separate` axes are the two of
//! the base that are nearest to the horizontal, made level.
//!
//! Weights of links that nobody declared are left out of F and M. With `own_weight = "free"` their moments are unknowns beside c_t:
//!
//! ```text
//! φ_0 += Σ_k (c_t h_k) · (a_k × g)       links k = the first `links` ones that move, a_k across the axis of joint k
//! ```
//!
//! with c_t h_k the compliance times the first moment of link k and of what it carries, two numbers a turning link (one a slide), as in
//! [`super::JointCompliance`].

use super::checks::refused;
use super::free_weight;
use super::geometric::EXPECTED_ANGLE;
use super::link_compliance::OwnWeight;
use super::robot_size::robot_size;
use crate::lanes::{LANES, LaneEmission, LanePosture};
use crate::{Column, Effect, Emission, ModelError};
use serde::{Deserialize, Serialize};
use truepose_kinematics::nalgebra::{Matrix3, Vector3};
use truepose_kinematics::{Axis, Chain, FrameId, Joint, JointId, Posture, Site};

/// Which tilts of a base are told apart.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Tilt {
    /// One unknown for every horizontal axis.
    #[default]
    Isotropic,
    /// One unknown for each of two.
    Separate,
}

/// Compliance of what the robot stands on.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct BaseCompliance {
    /// Which tilts are told apart.
    #[serde(default)]
    pub tilt: Tilt,
    /// Whether the base sinks along gravity as well.
    #[serde(default = "yes")]
    pub sink: bool,
    /// Where the weight of the links comes from.
    #[serde(default, skip_serializing_if = "OwnWeight::is_declared")]
    pub own_weight: OwnWeight,
    /// How many links, the first that moves and those behind it, have a free weight.
    #[serde(default = "three", skip_serializing_if = "is_three")]
    pub links: usize,
}

fn three() -> usize {
    3
}

fn is_three(links: &usize) -> bool {
    *links == three()
}

fn yes() -> bool {
    true
}

impl Default for BaseCompliance {
    fn default() -> Self {
        BaseCompliance { tilt: Tilt::Isotropic, sink: true, own_weight: OwnWeight::Declared, links: three() }
    }
}

/// Up, in the axes of frame 0; z where there is no gravity.
fn up(chain: &Chain) -> Vector3<f64> {
    let gravity = chain.base().pose.rotation.tr_mul(&chain.gravity_in_measurement_frame());
    gravity.try_normalize(1e-12).map_or_else(Vector3::z, |down| -down)
}

/// The axis of the base that is nearest to the vertical, 0…2.
fn vertical(up: &Vector3<f64>) -> usize {
    up.iamax()
}

impl Effect for BaseCompliance {
    const FAMILY: &'static str = "base_compliance";
    const ABOUT: &'static str = "the base tilts and sinks under the load that it carries";

    fn columns(&self, chain: &Chain) -> Vec<Column> {
        let tilt = |name: String| {
            Column::new(name, "rad/(N*m)", 1e-7 / robot_size(chain)).within(0.0, f64::INFINITY)
        };
        let mut columns = match self.tilt {
            Tilt::Isotropic => vec![tilt("tilt base".into())],
            Tilt::Separate => {
                let v = vertical(&up(chain));
                [1, 2].map(|k| tilt(format!("tilt base about {}", ["x", "y", "z"][(v + k) % 3]))).into()
            }
        };
        if self.sink {
            columns
                .push(Column::new("sink base", "m/N", 1e-8 * robot_size(chain)).within(0.0, f64::INFINITY));
        }
        for tilt in 0..self.tilts() {
            for (joint, numbers) in self.free(chain) {
                let (name, slides) = (&joint.name, numbers == 1);
                let unit = if slides { "rad*kg/(N*m)" } else { "rad*kg*m/(N*m)" };
                for number in 1..=numbers {
                    let which = if self.tilt == Tilt::Separate { ["a", "b"][tilt] } else { "" };
                    let name = format!("weight of {name} on base {number}{which}");
                    columns.push(Column::new(name, unit, EXPECTED_ANGLE / 9.81));
                }
            }
        }
        columns
    }

    fn validate(&self, _: &Chain) -> Result<(), ModelError> {
        match self.links {
            0 => Err(refused(Self::FAMILY, "`links` counts the first link that moves: it is 1 or more")),
            _ => Ok(()),
        }
    }

    fn eval(&self, at: &Posture<'_>, out: &mut Emission) {
        let up = up(at.chain());
        let carried = at.wrench(FrameId::BASE);
        for (column, yields) in self.yields(&up).enumerate() {
            let (axes, value) = match yields {
                Yields::Turns(matrix) => (Axis::ROTATIONS, matrix * carried.moment),
                Yields::Sinks => (Axis::TRANSLATIONS, up * up.dot(&carried.force)),
            };
            for axis in axes {
                out.push(column, Site::Frame(FrameId::BASE, axis), value[axis.direction()]);
            }
        }
        if self.own_weight == OwnWeight::Free {
            self.eval_free(&up, at, out);
        }
    }

    fn eval_lanes(&self, at: &LanePosture<'_>, out: &mut LaneEmission) -> bool {
        if self.own_weight == OwnWeight::Free {
            return false;
        }
        let up = up(at.chain());
        let mut carried = vec![0.0; 6 * LANES];
        carried.chunks_exact_mut(LANES).enumerate().for_each(|(k, into)| at.wrench(FrameId::BASE, k, into));
        for (column, yields) in self.yields(&up).enumerate() {
            let (axes, matrix, part) = match yields {
                Yields::Turns(matrix) => (Axis::ROTATIONS, matrix, &carried[3 * LANES..]),
                Yields::Sinks => (Axis::TRANSLATIONS, up * up.transpose(), &carried[..3 * LANES]),
            };
            for axis in axes {
                let row = matrix.row(axis.direction()).into_owned();
                let value = out.value(|into| {
                    for (by, of) in row.iter().zip(part.chunks_exact(LANES)) {
                        into.iter_mut().zip(of).for_each(|(into, of)| *into += by * of);
                    }
                });
                out.push(column, Site::Frame(FrameId::BASE, axis), value);
            }
        }
        true
    }
}

/// What one unknown of a base does.
enum Yields {
    /// It turns by this matrix times the moment.
    Turns(Matrix3<f64>),
    /// It sinks along gravity.
    Sinks,
}

impl BaseCompliance {
    fn tilts(&self) -> usize {
        if self.tilt == Tilt::Separate { 2 } else { 1 }
    }

    /// The joints whose links have a free weight, and how many numbers each has.
    fn free<'a>(&self, chain: &'a Chain) -> impl Iterator<Item = (&'a Joint, usize)> + use<'a> {
        let of = |joint: &'a Joint| (joint, free_weight::numbers(joint));
        self.free_joints(chain).map(move |joint| of(chain.joint(joint)))
    }

    fn free_joints<'a>(&self, chain: &'a Chain) -> impl Iterator<Item = JointId> + use<'a> {
        let count = if self.own_weight == OwnWeight::Free { self.links } else { 0 };
        chain.movable().iter().copied().take(count)
    }

    /// Tilts by the free weights.
    fn eval_free(&self, up: &Vector3<f64>, at: &Posture<'_>, out: &mut Emission) {
        let chain = at.chain();
        let home = at.frame(FrameId::BASE).rotation;
        let gravity = home.tr_mul(&chain.gravity_in_measurement_frame());
        let mut column = self.tilts() + usize::from(self.sink);
        for yields in self.yields(up) {
            let Yields::Turns(matrix) = yields else { continue };
            for id in self.free_joints(chain) {
                for arm in free_weight::arms(at, id).into_iter().flatten() {
                    let turn = matrix * home.tr_mul(&arm).cross(&gravity);
                    for axis in Axis::ROTATIONS {
                        out.push(column, Site::Frame(FrameId::BASE, axis), turn[axis.direction()]);
                    }
                    column += 1;
                }
            }
        }
    }

    /// What each unknown does.
    fn yields(&self, up: &Vector3<f64>) -> impl Iterator<Item = Yields> {
        let level = Matrix3::identity() - up * up.transpose();
        let turns = match self.tilt {
            Tilt::Isotropic => [Some(level), None],
            Tilt::Separate => {
                let mut first = Vector3::zeros();
                first[(vertical(up) + 1) % 3] = 1.0;
                let first = (first - up * up.dot(&first)).normalize();
                let about_first = first * first.transpose();
                [Some(about_first), Some(level - about_first)]
            }
        };
        turns.into_iter().flatten().map(Yields::Turns).chain(self.sink.then_some(Yields::Sinks))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testkit::{check_effect, emitted};
    use truepose_kinematics::nalgebra::DMatrix;
    use truepose_kinematics::{Conditions, Load, Payload, Placed, Pose, samples};

    #[test]
    fn conforms() {
        for chain in samples::all() {
            for tilt in [Tilt::Isotropic, Tilt::Separate] {
                for sink in [true, false] {
                    let base = BaseCompliance { tilt, sink, ..BaseCompliance::default() };
                    check_effect(&base, &chain);
                    for links in [1, 3, 9] {
                        let own_weight = OwnWeight::Free;
                        check_effect(&BaseCompliance { own_weight, links, ..base.clone() }, &chain);
                    }
                }
            }
        }
    }

    /// Displacement `[tx ty tz rx ry rz]` of the base per unit of every unknown, in the measurement frame's axes.
    fn settled(tilt: Tilt, base: Pose) -> [Vector3<f64>; 2] {
        let chain = samples::ur10().with_base(Placed { pose: base, known: true }).unwrap();
        let load = Load::Payload(Payload { mass: 10.0, com: Vector3::zeros() });
        let conditions = Conditions::at(&chain, &[0.4, 0.2, -0.6, 0.3, 0.8, 0.1]).with_load(load);
        let mut e = [0.0; 6];
        for entry in emitted(&BaseCompliance { tilt, ..BaseCompliance::default() }, &chain, &conditions) {
            e[entry.site.axis().index()] += entry.value;
        }
        [base.rotation * Vector3::new(e[0], e[1], e[2]), base.rotation * Vector3::new(e[3], e[4], e[5])]
    }

    #[test]
    fn it_sinks_down_and_tips_towards_the_load_however_the_base_leans() {
        for rpy in [[0.0; 3], [0.5, 0.2, 0.9], [1.5, 0.0, 0.0], [3.1, 0.3, 0.0]] {
            for tilt in [Tilt::Isotropic, Tilt::Separate] {
                let base = Pose::from_xyz_rpy([0.3, 0.2, 0.5], rpy);
                let [shift, turn] = settled(tilt, base);
                assert!((shift + Vector3::z() * 98.1).norm() < 1e-9, "{shift}");
                // Moment of the weight about the base: horizontal, and square to the arm.
                let chain = samples::ur10().with_base(Placed { pose: base, known: true }).unwrap();
                let arm = chain.forward(&[0.4, 0.2, -0.6, 0.3, 0.8, 0.1]).translation - base.translation;
                let moment = arm.cross(&(-Vector3::z() * 98.1));
                assert!((turn - moment).norm() < 1e-9, "{turn} {moment}");
            }
        }
    }

    /// The tilt by the declared weights of a robot without payload lies in the span of the free ones.
    #[test]
    fn free_weights_span_what_declared_ones_do() {
        let postures = 40;
        for (chain, tilt) in [(samples::heavy(), Tilt::Isotropic), (samples::seven(), Tilt::Separate)] {
            let declared = BaseCompliance { tilt, sink: false, ..BaseCompliance::default() };
            let free = BaseCompliance { own_weight: OwnWeight::Free, links: 9, ..declared.clone() };
            let (first, width) = (declared.tilts(), free.columns(&chain).len());
            let mut table = DMatrix::zeros(3 * postures, width - first + 3);
            let mut wanted = DMatrix::zeros(3 * postures, first);
            for row in 0..postures {
                let angle = |k: usize| ((row * (7 + 4 * k)) as f64 * 0.37 + k as f64).sin();
                let q: Vec<f64> = (0..chain.movable().len()).map(angle).collect();
                for entry in emitted(&free, &chain, &Conditions::at(&chain, &q)) {
                    let at = 3 * row + entry.site.axis().direction();
                    match entry.column.checked_sub(first) {
                        Some(column) => table[(at, column)] += entry.value,
                        None => wanted[(at, entry.column)] += entry.value,
                    }
                }
                // A constant tilt is an error of the base.
                (0..3).for_each(|k| table[(3 * row + k, width - first + k)] = 1.0);
            }
            let scale = wanted.norm();
            let solved = table.clone().svd(true, true).solve(&wanted, 1e-9 * table.norm()).unwrap();
            assert!((table * solved - &wanted).norm() < 1e-9 * scale, "{}", chain.name());
        }
    }

    #[test]
    fn no_link_is_refused() {
        let none = BaseCompliance { own_weight: OwnWeight::Free, links: 0, ..BaseCompliance::default() };
        assert!(none.validate(&samples::heavy()).is_err());
    }
}
