//! Kinds of robots: dimensions of real machines, 0.8 to 1.25 times, each length within a tenth, in three ways of describing them.

use super::draw::Draw;
use std::error::Error;
use std::f64::consts::{FRAC_PI_2, PI};
use truepose_kinematics::nalgebra::{Unit, Vector3};
use truepose_kinematics::{Chain, Joint, JointKind, Placement, Pose};

/// A kind of robot.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Make {
    /// A collaborative 6R arm: three parallel axes, offset wrist; standard DH.
    Collaborative,
    /// A 6R arm of 0.7 to 1 m with a spherical wrist; standard DH.
    Medium,
    /// A table-top 6R arm of 0.3 m; origin and axis.
    Small,
    /// A 6R arm of two metres that carries a hundred kilograms; modified DH.
    Heavy,
    Scara,
    Gantry,
    /// A 7R arm; modified DH.
    Seven,
}

pub const MAKES: [Make; 7] =
    [Make::Collaborative, Make::Medium, Make::Small, Make::Heavy, Make::Scara, Make::Gantry, Make::Seven];

/// What else goes with a kind.
pub struct Class {
    /// m.
    pub reach: f64,
    /// Heaviest payload, kg.
    pub payload: f64,
    /// All links together, kg.
    pub weight: f64,
}

impl Make {
    pub fn word(self) -> &'static str {
        match self {
            Make::Collaborative => "collaborative",
            Make::Medium => "medium",
            Make::Small => "small",
            Make::Heavy => "heavy",
            Make::Scara => "scara",
            Make::Gantry => "gantry",
            Make::Seven => "seven",
        }
    }

    pub fn class(self) -> Class {
        let (reach, payload, weight) = match self {
            Make::Collaborative => (1.0, 8.0, 28.0),
            Make::Medium => (0.9, 6.0, 50.0),
            Make::Small => (0.3, 0.5, 4.5),
            Make::Heavy => (2.3, 120.0, 950.0),
            Make::Scara => (0.65, 3.0, 17.0),
            Make::Gantry => (1.5, 20.0, 300.0),
            Make::Seven => (0.9, 6.0, 28.0),
        };
        Class { reach, payload, weight }
    }

    /// One of its kind, without base, tool and targets; with its weights where the maker publishes them.
    pub fn chain(self, draw: &mut Draw) -> Result<Chain, Box<dyn Error>> {
        let scale = draw.between(0.8, 1.25);
        let weighed = draw.chance(0.5);
        let mut length = |metres: f64| metres * scale * draw.between(0.9, 1.1);
        let mut joints = match self {
            Make::Collaborative => collaborative(&mut length),
            Make::Medium => medium(&mut length),
            Make::Small => small(&mut length),
            Make::Heavy => heavy(&mut length),
            Make::Scara => scara(&mut length),
            Make::Gantry => gantry(&mut length),
            Make::Seven => seven(&mut length),
        };
        if weighed {
            let class = self.class();
            let n = joints.len();
            let all: f64 = (1..=n).map(|k| (k * k) as f64).sum();
            for (k, joint) in joints.iter_mut().enumerate() {
                // The first links are the heaviest.
                let mass = class.weight * ((n - k) * (n - k)) as f64 / all;
                let com = [0.1, 0.03, 0.05].map(|share| share * class.reach * draw.normal());
                *joint = joint.clone().with_link(mass, com);
            }
        }
        Ok(Chain::new(self.word(), joints)?)
    }
}

fn dh(rows: &[(f64, f64, f64, f64)], limits: &[f64]) -> Vec<Joint> {
    named(rows.iter().map(|&(theta, d, a, alpha)| Placement::Dh { theta, d, a, alpha }), limits)
}

fn mdh(rows: &[(f64, f64, f64, f64)], limits: &[f64]) -> Vec<Joint> {
    named(rows.iter().map(|&(alpha, a, theta, d)| Placement::Mdh { alpha, a, theta, d }), limits)
}

fn named(placements: impl Iterator<Item = Placement>, limits: &[f64]) -> Vec<Joint> {
    let joint = |(k, (placement, &limit)): (usize, (_, &f64))| {
        Joint::new(format!("j{}", k + 1), JointKind::Revolute, placement).with_limits(-limit, limit)
    };
    placements.zip(limits).enumerate().map(joint).collect()
}

fn collaborative(length: &mut impl FnMut(f64) -> f64) -> Vec<Joint> {
    dh(
        &[
            (0.0, length(0.128), 0.0, FRAC_PI_2),
            (0.0, 0.0, -length(0.52), 0.0),
            (0.0, 0.0, -length(0.48), 0.0),
            (0.0, length(0.142), 0.0, FRAC_PI_2),
            (0.0, length(0.116), 0.0, -FRAC_PI_2),
            (0.0, length(0.092), 0.0, 0.0),
        ],
        &[3.1, 2.4, 2.6, 3.1, 3.1, 3.1],
    )
}

fn medium(length: &mut impl FnMut(f64) -> f64) -> Vec<Joint> {
    dh(
        &[
            (0.0, length(0.40), length(0.025), -FRAC_PI_2),
            (0.0, 0.0, length(0.455), 0.0),
            (-FRAC_PI_2, 0.0, length(0.035), -FRAC_PI_2),
            (0.0, length(0.42), 0.0, FRAC_PI_2),
            (0.0, 0.0, 0.0, -FRAC_PI_2),
            (0.0, length(0.08), 0.0, 0.0),
        ],
        &[2.9, 1.7, 1.9, 3.0, 2.0, 3.1],
    )
}

fn small(length: &mut impl FnMut(f64) -> f64) -> Vec<Joint> {
    let (x, y, z) = ([1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]);
    let parts = [
        ([0.0; 3], z),
        ([0.0, 0.0, length(0.135)], y),
        ([0.0, 0.0, length(0.135)], y),
        ([length(0.06), 0.0, length(0.038)], x),
        ([length(0.06), 0.0, 0.0], y),
        ([length(0.07), 0.0, 0.0], x),
    ];
    let limits = [2.9, 1.2, 1.2, 2.9, 1.9, 3.1];
    named(parts.into_iter().map(|(xyz, axis)| origin(xyz, axis)), &limits)
}

fn heavy(length: &mut impl FnMut(f64) -> f64) -> Vec<Joint> {
    mdh(
        &[
            (0.0, 0.0, 0.0, length(0.65)),
            (-FRAC_PI_2, length(0.32), 0.0, 0.0),
            (0.0, length(1.1), -FRAC_PI_2, 0.0),
            (-FRAC_PI_2, -length(0.05), 0.0, length(1.15)),
            (FRAC_PI_2, 0.0, 0.0, 0.0),
            (-FRAC_PI_2, 0.0, 0.0, length(0.21)),
        ],
        &[2.6, 1.2, 1.4, 3.0, 2.0, 3.1],
    )
}

fn scara(length: &mut impl FnMut(f64) -> f64) -> Vec<Joint> {
    let mut joints = mdh(
        &[
            (0.0, 0.0, 0.0, length(0.4)),
            (0.0, length(0.35), 0.0, 0.0),
            (PI, length(0.3), 0.0, 0.0),
            (0.0, 0.0, 0.0, length(0.05)),
        ],
        &[2.2, 2.4, 0.25, 3.0],
    );
    joints[2].kind = JointKind::Prismatic;
    joints[2].limits = Some((0.0, 0.25));
    joints
}

fn gantry(length: &mut impl FnMut(f64) -> f64) -> Vec<Joint> {
    let (x, y, down, up) = ([1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, -1.0], [0.0, 0.0, 1.0]);
    let parts = [
        ([0.0, 0.0, length(2.0)], x),
        ([0.0, 0.0, length(0.15)], y),
        ([length(0.1), 0.0, -0.2], down),
        ([0.0, 0.0, -length(0.35)], up),
    ];
    let mut joints = named(parts.into_iter().map(|(xyz, axis)| origin(xyz, axis)), &[3.0; 4]);
    for (joint, travel) in joints.iter_mut().zip([2.5, 1.6, 0.8]) {
        joint.kind = JointKind::Prismatic;
        joint.limits = Some((0.0, travel));
    }
    joints
}

fn seven(length: &mut impl FnMut(f64) -> f64) -> Vec<Joint> {
    mdh(
        &[
            (0.0, 0.0, 0.0, length(0.34)),
            (-FRAC_PI_2, 0.0, 0.0, 0.0),
            (FRAC_PI_2, 0.0, 0.0, length(0.4)),
            (FRAC_PI_2, 0.0, 0.0, 0.0),
            (-FRAC_PI_2, 0.0, 0.0, length(0.4)),
            (-FRAC_PI_2, 0.0, 0.0, 0.0),
            (FRAC_PI_2, 0.0, 0.0, length(0.126)),
        ],
        &[2.9, 2.0, 2.9, 2.0, 2.9, 2.0, 3.0],
    )
}

fn origin(xyz: [f64; 3], axis: [f64; 3]) -> Placement {
    let pose = Pose { translation: Vector3::from(xyz), ..Pose::IDENTITY };
    Placement::Origin { pose, axis: Unit::new_normalize(Vector3::from(axis)) }
}
