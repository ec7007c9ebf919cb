//! What stands around the robot as it is: sockets, plates, balls, wires, gauges and cameras.
//!
//! A robot description states what is known of these; a cell is where they really are and what they really read. Each of them has formulas of
//! its own here, and none of the model's.

mod aim;
mod camera;
mod direction;
mod thing;

pub(crate) use aim::Aim;
pub use camera::Camera;
pub use thing::{Ball, Gauge, Move, Plate, Thing, What, Wire};

use truepose_kinematics::TargetId;

/// Everything around the robot.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Cell {
    /// Names of landmarks by their numbers: those of the robot description in its order, and behind them others.
    pub names: Vec<String>,
    /// What the robot is observed with.
    pub things: Vec<Thing>,
    /// Rows that name something else than what was observed.
    pub misnamed: Vec<Misnamed>,
}

/// A wrong association.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Misnamed {
    /// The row, from zero.
    pub row: usize,
    /// What it names.
    pub named: Name,
}

/// What a row can name.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Name {
    /// A landmark by its number; in a row of a camera on the robot, the point that it saw.
    Landmark(usize),
    /// A target.
    Target(TargetId),
}
