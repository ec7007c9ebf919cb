//! Robots of random geometry: none of them is a sample of the library or a robot of another study.
//!
//! | make | geometry |
//! | --- | --- |
//! | `elbow` | six revolute joints by DH parameters: random lengths, shoulder, elbow and wrist offsets |
//! | `tree` | six revolute joints by origin and axis, each frame turned at random, as in a URDF |
//! | `scara` | two parallel joints, a slide, a turn |
//! | `gantry` | three slides, a wrist of two or three joints |

use crate::prelude::*;
use std::f64::consts::{FRAC_PI_2, PI};
use truepose_kinematics::nalgebra::{Point3, Rotation3, Unit, UnitQuaternion};

/// A make of robots.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Make {
    Elbow,
    Tree,
    Scara,
    Gantry,
}

/// Two in three have six revolute joints.
pub const MAKES: [Make; 6] = [Make::Elbow, Make::Elbow, Make::Tree, Make::Tree, Make::Scara, Make::Gantry];

/// A robot as it is described, and its size.
pub struct Robot {
    pub chain: Chain,
    /// Length that is typical of it, m.
    pub reach: f64,
    /// Heaviest payload, kg.
    pub payload: f64,
}

impl Robot {
    /// The same, as someone describes it who does not know the weights of its links.
    pub fn without_weights(self) -> Outcome<Self> {
        let joints = self.chain.joints().iter().map(|joint| Joint { link: None, ..joint.clone() });
        let chain = with_joints(&self.chain, joints.collect())?;
        Ok(Robot { chain, ..self })
    }
}

/// Draws a robot with this many targets.
pub fn robot(make: Make, targets: usize, draw: &mut Draw) -> Outcome<Robot> {
    let scale = draw.logarithmic(0.4, 1.6);
    let joints = match make {
        Make::Elbow => elbow(scale, draw),
        Make::Tree => Design::tree(scale, draw).joints(draw),
        Make::Scara => Design::scara(scale, draw).joints(draw),
        Make::Gantry => Design::gantry(scale, draw).joints(draw),
    };
    let turned = |draw: &mut Draw, size: f64| [0.0; 3].map(|_: f64| size * draw.normal());
    let base = Pose::from_xyz_rpy([0.0; 3].map(|_: f64| draw.between(-2.0, 2.0)), turned(draw, 0.03));
    let tool = Pose::from_xyz_rpy(
        [0.03 * scale * draw.normal(), 0.03 * scale * draw.normal(), scale * draw.between(0.05, 0.2)],
        turned(draw, 0.3),
    );
    let list = (0..targets)
        .map(|k| target(format!("T{}", k + 1), draw.direction() * scale * draw.between(0.05, 0.14)))
        .collect();
    let chain = Chain::new(make.word(), joints)?
        .with_base(known(base))?
        .with_tool(known(tool))?
        .with_targets(list)?;
    Ok(Robot { chain, reach: scale, payload: draw.between(4.0, 20.0) * scale * scale })
}

/// An articulated arm by its DH parameters.
fn elbow(s: f64, draw: &mut Draw) -> Vec<Joint> {
    let side = draw.sign();
    let (upper, fore) = (s * draw.between(0.5, 1.1), s * draw.between(0.4, 1.1));
    let elbow = s * draw.between(-0.05, 0.25);
    let wrist = if draw.chance(0.5) { 0.0 } else { s * draw.between(0.02, 0.1) };
    // θ at zero, d, a, α.
    let rows = [
        [0.0, s * draw.between(0.3, 0.7), s * draw.between(0.0, 0.35), side * FRAC_PI_2],
        [FRAC_PI_2, s * draw.between(-0.08, 0.08), upper, 0.0],
        [0.0, 0.0, elbow, side * FRAC_PI_2],
        [0.0, fore, 0.0, -side * FRAC_PI_2],
        [0.0, wrist, 0.0, side * FRAC_PI_2],
        [0.0, s * draw.between(0.06, 0.2), 0.0, 0.0],
    ];
    let weight = draw.between(25.0, 60.0) * s * s;
    let parts = [1.0, 0.55, 0.4, 0.25, 0.1, 0.04];
    let half = [2.6, 0.9, 1.0, 2.6, 1.7, 2.9];
    let middle = [0.0, 0.0, -0.2, 0.0, 0.3, 0.0];
    let one = |k: usize, draw: &mut Draw| {
        let [theta, d, a, alpha] = rows[k];
        // Middle of the link seen from its far end: −(a, d sin α, d cos α)/2.
        let part = -draw.between(0.4, 0.6);
        let centre = [a, d * alpha.sin(), d * alpha.cos()].map(|v| part * v + 0.01 * s * draw.normal());
        let reach = half[k] * draw.between(0.6, 1.0);
        Joint::new(format!("j{}", k + 1), JointKind::Revolute, Placement::Dh { theta, d, a, alpha })
            .with_limits(middle[k] - reach, middle[k] + reach)
            .with_link(weight * parts[k] * draw.between(0.7, 1.3), centre)
    };
    (0..6).map(|k| one(k, draw)).collect()
}

/// A robot at its zero, in the axes of its base: what a designer draws.
struct Design {
    parts: Vec<Designed>,
}

/// A joint: its kind, a point of its axis, its axis, half its range, and mass and centre of the link behind it.
type Designed = (JointKind, Vector3<f64>, Vector3<f64>, f64, f64, Vector3<f64>);

impl Design {
    fn tree(s: f64, draw: &mut Draw) -> Self {
        let (x, y, z) = (Vector3::x(), Vector3::y(), Vector3::z());
        let mut at = Vector3::new(0.0, 0.0, s * draw.between(0.2, 0.4));
        let axes = [z, y, y, x, y, x];
        let steps = [
            Vector3::new(
                s * draw.between(0.0, 0.3),
                s * draw.between(-0.15, 0.15),
                s * draw.between(0.1, 0.3),
            ),
            Vector3::new(0.0, s * draw.between(-0.1, 0.1), s * draw.between(0.5, 1.1)),
            Vector3::new(s * draw.between(0.1, 0.4), 0.0, s * draw.between(-0.05, 0.2)),
            Vector3::new(s * draw.between(0.3, 0.7), 0.0, 0.0),
            Vector3::new(s * draw.between(0.05, 0.15), s * draw.one(&[0.0, 0.06]), 0.0),
            Vector3::new(s * draw.between(0.03, 0.1), 0.0, 0.0),
        ];
        let weight = draw.between(20.0, 50.0) * s * s;
        let half = [2.7, 0.9, 1.0, 2.6, 1.6, 2.9];
        let masses = [1.0, 0.6, 0.45, 0.25, 0.1, 0.04];
        let mut parts = Vec::new();
        for k in 0..6 {
            let centre = at + steps[k] * draw.between(0.35, 0.6);
            let reach = half[k] * draw.between(0.6, 1.0);
            parts.push((JointKind::Revolute, at, axes[k], reach, weight * masses[k], centre));
            at += steps[k];
        }
        Design { parts }
    }

    fn scara(s: f64, draw: &mut Draw) -> Self {
        let (one, two) = (s * draw.between(0.25, 0.5), s * draw.between(0.2, 0.45));
        let high = s * draw.between(0.3, 0.5);
        let (z, down) = (Vector3::z(), -Vector3::z());
        let weight = draw.between(10.0, 25.0) * s * s;
        let at = |x: f64| Vector3::new(x, 0.0, high);
        let turn = JointKind::Revolute;
        let parts = vec![
            (turn, at(0.0), z, draw.between(1.8, 2.4), weight, at(one * 0.5)),
            (turn, at(one), z, draw.between(1.8, 2.5), 0.6 * weight, at(one + 0.5 * two)),
            (
                JointKind::Prismatic,
                at(one + two),
                down,
                s * draw.between(0.08, 0.2),
                0.15 * weight,
                at(one + two),
            ),
            (turn, at(one + two), down, 3.0, 0.05 * weight, at(one + two)),
        ];
        Design { parts }
    }

    fn gantry(s: f64, draw: &mut Draw) -> Self {
        let (x, y, z) = (Vector3::x(), Vector3::y(), Vector3::z());
        let high = Vector3::z() * s * draw.between(0.8, 1.5);
        let ram = -z * s * draw.between(0.3, 0.6);
        let weight = draw.between(60.0, 150.0) * s * s;
        let slide = JointKind::Prismatic;
        let mut travel = || s * draw.between(0.4, 0.9);
        let mut parts = vec![
            (slide, high, x, travel(), weight, high + y * 0.1 * s),
            (slide, high, y, travel(), 0.4 * weight, high + x * 0.05 * s),
            (slide, high, -z, 0.5 * travel(), 0.2 * weight, high + ram * 0.5),
            (JointKind::Revolute, high + ram, z, 2.8, 0.06 * weight, high + ram),
            (JointKind::Revolute, high + ram - z * 0.1 * s, y, 1.6, 0.04 * weight, high + ram - z * 0.15 * s),
        ];
        if draw.chance(0.5) {
            let tip = high + ram - z * 0.2 * s;
            parts.push((JointKind::Revolute, tip, z, 2.8, 0.02 * weight, tip));
        }
        Design { parts }
    }

    /// Joints by origin and axis; each frame has a turn of its own, which a designer's CAD would give it.
    fn joints(&self, draw: &mut Draw) -> Vec<Joint> {
        let mut before = (Vector3::zeros(), Matrix3::identity());
        let mut one = |(k, part): (usize, &Designed)| {
            let (kind, at, axis, half, mass, centre) = *part;
            let turned = Rotation3::from(UnitQuaternion::from_scaled_axis(
                Vector3::from_fn(|_, _| draw.between(-1.0, 1.0)) * PI / 2.0,
            ));
            let turned = if draw.chance(0.5) { turned.into_inner() } else { Matrix3::identity() };
            let pose = Pose::new(before.1.transpose() * turned, before.1.transpose() * (at - before.0));
            before = (at, turned);
            let axis = Unit::new_normalize(turned.transpose() * axis);
            let centre = Point3::from(turned.transpose() * (centre - at)).coords;
            Joint {
                link: Some(Link { mass: mass * draw.between(0.8, 1.2), com: centre }),
                ..Joint::new(format!("q{}", k + 1), kind, Placement::Origin { pose, axis })
                    .with_limits(-half, half)
            }
        };
        self.parts.iter().enumerate().map(&mut one).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::super::stream::{Key, Part};
    use super::*;

    #[test]
    fn every_robot_reaches_places_apart_and_no_two_are_alike() {
        let mut seen = Vec::new();
        for number in 0..24 {
            let key = Key { half: Half::Tuning, series: 1, kind: 0, cell: 0, number };
            let make = MAKES[number as usize % 6];
            let robot = robot(make, 2, &mut key.draw(Part::Robot)).expect("a robot");
            let plant = Plant::perfect(&robot.chain).expect("a plant");
            let campaign = Campaign::random(&robot.chain, 30, 1).expect("a campaign");
            let place = |joints: &[f64]| {
                plant.true_position(&Conditions::at(&robot.chain, joints), None).expect("a place")
            };
            let places: Vec<Vector3<f64>> = campaign.visits.iter().map(|v| place(&v.joints)).collect();
            let widest = places.iter().map(|p| (p - places[0]).norm()).fold(0.0, f64::max);
            assert!(widest > 0.3 * robot.reach && widest < 8.0 * robot.reach, "{} {widest}", make.word());
            seen.push(places[3].x.to_bits());
        }
        seen.sort_unstable();
        seen.dedup();
        assert_eq!(seen.len(), 24);
    }
}
