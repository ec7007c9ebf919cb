//! Requests to the compensator, and its commands.

use nalgebra::{Matrix3, Vector3};
use std::ops::{Deref, DerefMut};
use truepose_errormodel::Domain;
use truepose_kinematics::{Conditions, Load, TargetId};

/// Most movable joints, and most channels that a model reads: what a command has room for without allocating.
pub const MOST: usize = 16;

/// Up to [`MOST`] numbers on the stack; used like a slice.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Values {
    numbers: [f64; MOST],
    len: usize,
}

impl Values {
    /// So many zeros; at most [`MOST`].
    pub fn zeros(len: usize) -> Self {
        Values { numbers: [0.0; MOST], len: len.min(MOST) }
    }

    /// The first [`MOST`] of these.
    pub fn of(values: &[f64]) -> Self {
        let mut made = Values::zeros(values.len());
        made.iter_mut().zip(values).for_each(|(to, from)| *to = *from);
        made
    }
}

impl Deref for Values {
    type Target = [f64];
    fn deref(&self) -> &[f64] {
        &self.numbers[..self.len]
    }
}

impl DerefMut for Values {
    fn deref_mut(&mut self) -> &mut [f64] {
        &mut self.numbers[..self.len]
    }
}

/// Desired position of a point of the real robot, in the measurement frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Target {
    /// Position of the target point, m.
    pub position: Vector3<f64>,
    /// Orientation of the tool; none leaves it as it is at the seed, as far as the robot can.
    pub orientation: Option<Matrix3<f64>>,
    /// Which declared point of the tool is meant; none is the tool's origin.
    pub target: Option<TargetId>,
}

impl Target {
    /// The tool's origin at a position, m, whatever its orientation.
    pub fn at(position: Vector3<f64>) -> Self {
        Target { position, orientation: None, target: None }
    }

    /// With this orientation of the tool.
    pub fn turned(mut self, orientation: Matrix3<f64>) -> Self {
        self.orientation = Some(orientation);
        self
    }

    /// For a declared point of the tool.
    pub fn of(mut self, target: Option<TargetId>) -> Self {
        self.target = target;
        self
    }
}

/// One of many desired poses, for `Compensator::commands`.
#[derive(Debug, Clone, Copy)]
pub struct CommandRequest<'a> {
    /// The pose.
    pub target: Target,
    /// Under which conditions.
    pub conditions: &'a Conditions,
    /// Where the search begins, rad or m.
    pub seed: Option<&'a [f64]>,
}

/// What became of a desired pose.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Status {
    /// The command brings the real robot there, within the tolerances, as verified with the exact model.
    Ok,
    /// The pose is out of reach.
    Unreachable,
    /// Only joint values beyond their limits would reach it.
    Limit,
    /// The search did not converge, or the request has values that are not finite.
    NotConverged,
}

impl Status {
    /// Its word in files.
    pub fn word(self) -> &'static str {
        match self {
            Status::Ok => "ok",
            Status::Unreachable => "unreachable",
            Status::Limit => "limit",
            Status::NotConverged => "not_converged",
        }
    }
}

/// How far the inputs of a command lie beyond those on which the model was fitted; zero inside.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Extrapolation {
    /// Each movable joint, rad or m.
    pub joints: Values,
    /// Mass carried, kg. A measured wrench is not judged.
    pub payload: f64,
    /// Time, s; judged where the model reads it and the fit had one.
    pub time: f64,
    /// Each channel that the model reads, in its unit, in the order of `Compensator::channels`.
    pub channels: Values,
}

impl Extrapolation {
    /// True when anything lies beyond.
    pub fn any(&self) -> bool {
        let beyond = |v: &f64| *v > 0.0;
        self.joints.iter().any(beyond)
            || self.channels.iter().any(beyond)
            || beyond(&self.payload)
            || beyond(&self.time)
    }

    /// Nothing lies beyond.
    pub(crate) fn none(joints: usize, channels: usize) -> Self {
        let (joints, channels) = (Values::zeros(joints), Values::zeros(channels));
        Extrapolation { joints, payload: 0.0, time: 0.0, channels }
    }

    /// Of these conditions. `read` are the positions, in the domain and in the conditions, of the channels that the
    /// model reads, `timed` says whether it reads the time. A domain without joints was never recorded: nothing counts as extrapolation.
    pub(crate) fn of(
        domain: &Domain,
        joints: &[f64],
        conditions: &Conditions,
        read: &[(Option<usize>, usize)],
        timed: bool,
    ) -> Self {
        let mut beyond = Extrapolation::none(joints.len(), read.len());
        if domain.joints.is_empty() {
            return beyond;
        }
        for ((out, range), &q) in beyond.joints.iter_mut().zip(&domain.joints).zip(joints) {
            *out = range.beyond(q);
        }
        let mass = match conditions.load {
            Load::None => Some(0.0),
            Load::Payload(payload) => Some(payload.mass),
            Load::Wrench(_) => None,
        };
        beyond.payload = match (mass, &domain.payload) {
            (Some(mass), Some(range)) => range.beyond(mass),
            (Some(mass), None) => mass.abs(),
            (None, _) => 0.0,
        };
        if timed {
            beyond.time = domain.time.as_ref().map_or(0.0, |range| range.beyond(conditions.time));
        }
        for (out, &(fitted, given)) in beyond.channels.iter_mut().zip(read) {
            let range = fitted.and_then(|k| domain.channels.get(k));
            *out = range.map_or(0.0, |r| conditions.channels.get(given).map_or(0.0, |&v| r.beyond(v)));
        }
        beyond
    }
}

/// A command: joint values, and their accuracy.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Command {
    /// Variables of the movable joints, rad or m, always within their limits; [`Chain::joints_to_controller`](truepose_kinematics::Chain::joints_to_controller)
    /// makes of them the controller's values, where joints are coupled. Where the status is not ok: the nearest that was found.
    pub joints: Values,
    /// What became of the pose.
    pub status: Status,
    /// How far the real robot's point ends from the desired one according to the exact model, m.
    pub position_error: f64,
    /// How far its tool is turned from the desired orientation, rad; zero when none was requested.
    pub orientation_error: f64,
    /// Evaluations of the exact model.
    pub rounds: usize,
    /// Distance beyond the range of the data of the fit.
    pub extrapolation: Extrapolation,
    /// The direction in which each joint has to arrive, −1, 0, +1: what the command was computed for.
    pub approach: Values,
    /// False when a straight move from the seed would arrive from another side than `approach` (the joint is to end
    /// within its backlash): come in from the stated side instead.
    pub approach_holds: bool,
}

#[cfg(test)]
mod tests {
    use super::*;
    use truepose_errormodel::Interval;
    use truepose_kinematics::{Payload, samples};

    #[test]
    fn extrapolation_is_reported_with_its_size() {
        let chain = samples::scara();
        let domain = Domain {
            joints: vec![Interval { lower: -1.0, upper: 1.0 }; 4],
            payload: Some(Interval { lower: 0.0, upper: 5.0 }),
            time: Some(Interval { lower: 10.0, upper: 20.0 }),
            channels: vec![Interval { lower: 18.0, upper: 22.0 }, Interval { lower: 0.0, upper: 1.0 }],
            ..Domain::default()
        };
        let load = Load::Payload(Payload { mass: 7.5, com: Vector3::zeros() });
        let mut conditions = Conditions::at(&chain, &[0.0; 4]).with_load(load);
        conditions.time = 5.0;
        conditions.channels = vec![0.5, 25.0];
        let beyond = Extrapolation::of(&domain, &[0.0, -1.5, 1.0, 3.0], &conditions, &[(Some(0), 1)], true);
        assert_eq!(&beyond.joints[..], &[0.0, 0.5, 0.0, 2.0]);
        assert_eq!((beyond.payload, beyond.time, beyond.channels[0]), (2.5, 5.0, 3.0));
        assert!(beyond.any());
        let inside = Extrapolation::of(&Domain::default(), &[9.0; 4], &conditions, &[], true);
        assert!(!inside.any());
    }
}
