//! Requests are checked once: all code behind this may rely on finite numbers and matching lengths.

use super::Compensator;
use crate::command::{Command, Extrapolation, MOST, Status, Target, Values};
use crate::task::Task;
use nalgebra::{Matrix3, Vector3};
use truepose_kinematics::{Conditions, Load};

impl Compensator<'_> {
    /// Takes over load, time, channels and approach, and makes the task; none when something is no number or has
    /// the wrong length. Directions of approach may be left out; channels too, if the model reads none.
    pub(super) fn enter(
        &mut self,
        target: &Target,
        conditions: &Conditions,
        seed: Option<&[f64]>,
    ) -> Option<Task> {
        let chain = self.fitted.chain();
        let n = chain.movable().len();
        let finite = |list: &[f64]| list.iter().all(|v| v.is_finite());
        if seed.is_some_and(|joints| joints.len() != n || !finite(joints)) {
            return None;
        }
        if !finite(target.position.as_slice())
            || target
                .target
                .is_some_and(|t| chain.targets().get(t.0).is_none_or(|t| t.tool != self.options.tool))
            || !load_is_finite(&conditions.load)
            || !conditions.time.is_finite()
        {
            return None;
        }
        let rotation = match target.orientation {
            None => None,
            Some(r) => Some(orthonormal(&r)?),
        };
        let approach = &conditions.approach;
        if !(approach.is_empty() || approach.len() == n && finite(approach))
            || conditions.channels.len() != self.conditions.channels.len() && !self.read.is_empty()
        {
            return None;
        }
        self.take_over(conditions);
        if self.read.iter().any(|&(_, given)| !self.conditions.channels[given].is_finite()) {
            return None;
        }
        Some(Task {
            position: target.position,
            rotation,
            target: target.target,
            length: self.length,
            position_tolerance: self.options.position_tolerance,
            orientation_tolerance: self.options.orientation_tolerance,
        })
    }

    /// Load, time, channels and approach of conditions that were checked.
    pub(super) fn take_over(&mut self, conditions: &Conditions) {
        self.conditions.load = self.fitted.carried(conditions.load, conditions.time);
        self.conditions.time = conditions.time;
        if conditions.approach.is_empty() {
            self.conditions.approach.fill(0.0);
        } else {
            self.conditions.approach.copy_from_slice(&conditions.approach);
        }
        if conditions.channels.len() == self.conditions.channels.len() {
            self.conditions.channels.copy_from_slice(&conditions.channels);
        }
    }

    /// The command for an invalid request: the seed, if it is one, within the limits; else the middle of the ranges.
    pub(super) fn refused(&self, seed: Option<&[f64]>) -> Command {
        let n = self.nominal.joints();
        let sound = seed.filter(|joints| joints.len() == n && joints.iter().all(|q| q.is_finite()));
        let x = match sound {
            Some(joints) => self.seed(joints),
            None => self.starts.middle(),
        };
        let mut joints = Values::zeros(n);
        (0..n).for_each(|k| joints[k] = self.joint(k, x[k]));
        self.fitted.chain().follow(&mut joints);
        Command {
            joints,
            status: Status::NotConverged,
            position_error: f64::INFINITY,
            orientation_error: f64::INFINITY,
            rounds: 0,
            extrapolation: Extrapolation::none(n, self.read.len()),
            approach: Values::zeros(n),
            approach_holds: false,
        }
    }

    /// True when a straight move from the seed arrives from another side than the one computed for.
    pub(super) fn sides_differ(&self, seed: &[f64; MOST], x: &[f64; MOST]) -> bool {
        self.conditions.approach.iter().enumerate().any(|(k, &side)| {
            let coming = side_of(x[k] - seed[k]);
            coming != 0 && coming != side_of(side)
        })
    }

    /// Arrives as a straight move from the seed does; a joint that stays keeps its side.
    pub(super) fn take_sides(&mut self, seed: &[f64; MOST], x: &[f64; MOST]) {
        for (k, side) in self.conditions.approach.iter_mut().enumerate() {
            let coming = side_of(x[k] - seed[k]);
            if coming != 0 {
                *side = f64::from(coming);
            }
        }
    }
}

/// −1, 0 or +1; below a nanoradian a joint stays.
fn side_of(way: f64) -> i8 {
    if way > 1e-9 {
        1
    } else if way < -1e-9 {
        -1
    } else {
        0
    }
}

fn load_is_finite(load: &Load) -> bool {
    match load {
        Load::None => true,
        Load::Payload(p) => p.mass.is_finite() && p.com.iter().all(|v| v.is_finite()),
        Load::Wrench(w) => w.force.iter().chain(&w.moment).all(|v| v.is_finite()),
    }
}

/// A rotation, made exact (one step of Newton's polar iteration); none when it is none to six digits.
fn orthonormal(r: &Matrix3<f64>) -> Option<Matrix3<f64>> {
    let [x, y, z] = r.data.0.map(Vector3::from);
    let (xx, yy, zz) = (x.dot(&x) - 1.0, y.dot(&y) - 1.0, z.dot(&z) - 1.0);
    let (xy, xz, yz) = (x.dot(&y), x.dot(&z), y.dot(&z));
    let off = [xx, yy, zz, xy, xz, yz].iter().fold(0.0, |most: f64, v| most.max(v.abs()));
    // A NaN is no maximum: it shows in the determinant.
    let proper = off < 1e-6 && x.cross(&y).dot(&z) > 0.0;
    proper.then(|| {
        Matrix3::from_columns(&[
            x - (x * xx + y * xy + z * xz) * 0.5,
            y - (x * xy + y * yy + z * yz) * 0.5,
            z - (x * xz + y * yz + z * zz) * 0.5,
        ])
    })
}
