//! The trait, and what its kinds share.

use crate::Column;
use nalgebra::Vector3;
use std::any::Any;
use std::fmt::Debug;
use truepose_kinematics::Pose;

/// What a sensor reads at a pose, and how that changes. Memory is used again from row to row.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Reading {
    /// h: as many numbers as a row has of this kind.
    pub value: Vec<f64>,
    /// H, row by row.
    pub by_pose: Vec<[f64; 6]>,
    /// K, row by row.
    pub by_own: Vec<Vec<f64>>,
}

impl Reading {
    /// Becomes a reading of one number; `own` are its derivatives by the unknowns.
    pub fn one(&mut self, value: f64, by_position: Vector3<f64>, own: impl IntoIterator<Item = f64>) {
        self.value.clear();
        self.value.push(value);
        self.by_pose.clear();
        self.by_pose.push([by_position.x, by_position.y, by_position.z, 0.0, 0.0, 0.0]);
        self.by_own.resize_with(1, Vec::new);
        self.by_own[0].clear();
        self.by_own[0].extend(own);
    }
}

/// A point of a campaign at which a start is looked for: the tool at the target as the nominal robot has it, and what was measured.
pub type Seen = (Pose, Vec<f64>);

/// A sensor, or a thing of the surroundings that was observed: one for each name in the column `landmark`. Its unknowns are part of its value;
/// a fit asks for their derivatives and moves them.
///
/// ```
/// use truepose_errormodel::observation::{Observation, Reading};
/// use truepose_errormodel::{Column, testkit::check_observation};
/// use truepose_kinematics::{Pose, nalgebra::Vector3};
///
/// /// A height gauge of unknown zero.
/// #[derive(Debug, Clone)]
/// struct Height { zero: f64 }
///
/// impl Observation for Height {
///     fn kind(&self) -> &'static str { "acme/height" }
///     fn unknowns(&self, name: &str, length: f64) -> Vec<Column> {
///         vec![Column::new(format!("zero of {name}"), "m", 0.01 * length)]
///     }
///     fn read(&self, at: &Pose, out: &mut Reading) -> bool {
///         out.one(at.translation.z - self.zero, Vector3::z(), [-1.0]);
///         true
///     }
///     fn moved(&self, by: &[f64]) -> Box<dyn Observation> { Box::new(Height { zero: self.zero + by[0] }) }
///     fn boxed(&self) -> Box<dyn Observation> { Box::new(self.clone()) }
/// }
///
/// check_observation(&Height { zero: 0.1 });
/// ```
pub trait Observation: Any + Debug + Send + Sync {
    /// Its word in the column `kind`. Third parties prefix theirs: `acme/height`.
    fn kind(&self) -> &'static str;

    /// Unit of what it measures, SI, or `px`.
    fn unit(&self) -> &'static str {
        "m"
    }

    /// How many numbers a row has: 1 to 3.
    fn numbers(&self) -> usize {
        1
    }

    /// Its unknowns, those that are not known: names with `name` in them, SI units, and expected sizes on a robot of this length, m.
    fn unknowns(&self, name: &str, length: f64) -> Vec<Column>;

    /// What it reads with the tool at this pose (the measured target at its origin). `false` where it cannot see the target.
    fn read(&self, at: &Pose, out: &mut Reading) -> bool;

    /// The same with its unknowns moved, one number for each.
    fn moved(&self, by: &[f64]) -> Box<dyn Observation>;

    /// The same with its unknowns found from nothing, or from what is declared of them.
    ///
    /// # Errors
    /// Why these rows do not determine them, and what would.
    fn started(&self, _seen: &[Seen]) -> Result<Box<dyn Observation>, String> {
        Ok(self.boxed())
    }

    /// Whether it is said where it is, exactly or about: else its readings cannot be foretold before rows of it were measured.
    fn placed(&self) -> bool {
        true
    }

    /// What is known of it, found or declared, for people: name, value, SI unit.
    fn values(&self) -> Vec<(&'static str, f64, &'static str)> {
        Vec::new()
    }

    /// What it takes as given, in words, each with the observation of which that is further unknowns beside its own: its place where that is
    /// known, a lens, a gain, that a table is flat. Unknowns of the same name are the same.
    fn freed(&self) -> Vec<(&'static str, Box<dyn Observation>)> {
        Vec::new()
    }

    /// Whether what it reads is a known length: then it determines the scale.
    fn metric(&self) -> bool {
        true
    }

    /// Whether it is known where it stands: then it says something about the place of the robot's base.
    fn outside(&self) -> bool {
        false
    }

    /// A copy.
    fn boxed(&self) -> Box<dyn Observation>;
}

impl Clone for Box<dyn Observation> {
    fn clone(&self) -> Self {
        self.boxed()
    }
}

/// Share of the robot's length by which the place of a thing is expected to be off: it is found with the nominal robot.
pub(super) const OFF: f64 = 1e-2;
/// Likewise of a direction, rad, and of a gain.
pub(super) const TURNED: f64 = 1e-2;

/// Two unit vectors across a direction.
pub(super) fn across(direction: &Vector3<f64>) -> [Vector3<f64>; 2] {
    let first = direction.cross(&Vector3::ith(direction.iamin(), 1.0)).normalize();
    [first, direction.cross(&first)]
}

/// The place of a thing as three unknowns.
pub(super) fn place(name: &str, length: f64) -> Vec<Column> {
    ["x", "y", "z"].map(|axis| Column::new(format!("{axis}@{name}"), "m", OFF * length)).to_vec()
}

/// A point for people.
pub(super) fn shown(point: Vector3<f64>) -> [(&'static str, f64, &'static str); 3] {
    [("x", point.x, "m"), ("y", point.y, "m"), ("z", point.z, "m")]
}

/// A direction for people.
pub(super) fn shown_direction(direction: Vector3<f64>) -> [(&'static str, f64, &'static str); 3] {
    [("nx", direction.x, "1"), ("ny", direction.y, "1"), ("nz", direction.z, "1")]
}

/// What is taken as given, of what may be.
pub(super) fn taken<const N: usize>(
    all: [(bool, &'static str, Box<dyn Observation>); N],
) -> Vec<(&'static str, Box<dyn Observation>)> {
    all.into_iter().filter(|(taken, ..)| *taken).map(|(_, what, freed)| (what, freed)).collect()
}

/// The first three of some numbers as a step, where a place is unknown; the rest of them.
pub(super) fn split_place(by: &[f64], known: bool) -> (Vector3<f64>, &[f64]) {
    match by {
        [x, y, z, rest @ ..] if !known => (Vector3::new(*x, *y, *z), rest),
        _ => (Vector3::zeros(), by),
    }
}
