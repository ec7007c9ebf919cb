//! Kinds of robots: dimensions of real machines (`makes.txt`), 0.8 to 1.25 times, each length within a tenth, in three ways of describing them.

use crate::prelude::*;
use std::f64::consts::FRAC_PI_2;
use truepose_kinematics::nalgebra::Unit;

/// A kind of robot.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
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
    pub fn chain(self, draw: &mut Draw) -> Outcome<Chain> {
        let scale = draw.between(0.8, 1.25);
        let weighed = draw.chance(0.5);
        let mut length = |metres: f64| metres * scale * draw.between(0.9, 1.1);
        let mut joints = Vec::new();
        let rows = include_str!("makes.txt").lines().filter(|line| !line.starts_with('#'));
        for (k, row) in rows.filter_map(|row| row.strip_prefix(&self.word())).enumerate() {
            joints.push(joint(k, row, &mut length).ok_or_else(|| format!("makes.txt: {row}"))?);
        }
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

/// The joint of a row of `makes.txt`.
fn joint(k: usize, row: &str, length: &mut impl FnMut(f64) -> f64) -> Option<Joint> {
    let mut words = row.split_whitespace();
    let (kind, lower, upper, form) = (words.next()?, words.next()?, words.next()?, words.next()?);
    // A number with a star is a length that differs from robot to robot.
    let mut number = || -> Option<f64> {
        let word = words.next()?;
        match word.split_once('*') {
            Some((sign, metres)) => {
                let metres = length(metres.parse().ok()?);
                Some(if sign == "-" { -metres } else { metres })
            }
            None => word.parse().ok(),
        }
    };
    let [a, b, c, d] = [number()?, number()?, number()?, number()?];
    let right = |quarters: f64| quarters * FRAC_PI_2;
    let placement = match form {
        "dh" => Placement::Dh { theta: right(a), d: b, a: c, alpha: right(d) },
        "mdh" => Placement::Mdh { alpha: right(a), a: b, theta: right(c), d },
        // Position and the number of the axis, negative where it is opposed.
        _ => {
            let mut axis = Vector3::zeros();
            axis[d.abs() as usize - 1] = d.signum();
            let pose = Pose { translation: Vector3::new(a, b, c), ..Pose::IDENTITY };
            Placement::Origin { pose, axis: Unit::new_normalize(axis) }
        }
    };
    let kind = if kind == "slide" { JointKind::Prismatic } else { JointKind::Revolute };
    let name = format!("j{}", k + 1);
    Some(Joint::new(name, kind, placement).with_limits(lower.parse().ok()?, upper.parse().ok()?))
}
