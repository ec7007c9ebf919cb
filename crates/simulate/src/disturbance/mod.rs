//! What disturbs a campaign and is no error of the robot: noise between poses that is not white, an instrument that moves,
//! poses that were not settled, encoders that flicker, deviations that are stated wrongly.
//!
//! | disturbance | acts on | module |
//! | --- | --- | --- |
//! | joint repeatability: each joint ends with its own deviation | all targets of a pose measurement, through the robot | here |
//! | wander: an autoregressive deviation from pose to pose | all targets of a pose measurement | [`Wander`] |
//! | station: the instrument drifts and is bumped | everything that is measured, as a rigid motion | [`StationMotion`] |
//! | bad poses: not settled, or stale joint values | all targets of a pose measurement | here |
//! | flicker of the encoders | the recorded joint values of each row | here |
//! | lag of the log: filtered joint values, read too early | the recorded joint values | [`LogLag`] |
//! | beam: layers of air, a prism | what is measured, by distance and direction | [`Beam`] |
//! | wrongly stated deviations | the stated deviations | here |
//!
//! Joint repeatability is drawn in joint space and goes through the plant: its covariance at a pose is J Σ_q Jᵀ, which is
//! nowhere computed here. Source: ISO 9283, 7.2 (pose repeatability); Brethé, *Granular stochastic modeling of robot
//! micrometric precision* (2011), for repeatability that comes from the joints.

mod beam;
mod log;
mod station;
mod wander;

pub use beam::Beam;
pub use log::LogLag;
pub use station::StationMotion;
pub(crate) use station::StationPath;
pub use wander::Wander;
use wander::normal;

use crate::SimulateError;
use nalgebra::Vector3;
use rand::seq::index::sample;
use rand::{Rng, RngExt};

/// Everything that disturbs a campaign. The default disturbs nothing.
#[derive(Debug, Clone, PartialEq)]
pub struct Disturbances {
    /// Standard deviation of each movable joint from pose to pose, rad or m; empty: none.
    pub joint_sd: Vec<f64>,
    /// Noise between poses with a memory.
    pub wander: Option<Wander>,
    /// Motion of the instrument.
    pub station: Option<StationMotion>,
    /// How many pose measurements are displaced as a whole.
    pub bad_poses: usize,
    /// Least and largest displacement of those, m.
    pub bad_size: [f64; 2],
    /// Largest deviation of a recorded joint value, rad or m; uniform, in each row.
    pub flicker: f64,
    /// A log of joint values that lags.
    pub log: Option<LogLag>,
    /// A beam that bends or has an offset.
    pub beam: Option<Beam>,
    /// Stated over true standard deviation.
    pub stated_factor: f64,
}

impl Default for Disturbances {
    fn default() -> Self {
        Disturbances {
            joint_sd: Vec::new(),
            wander: None,
            station: None,
            bad_poses: 0,
            bad_size: [0.0; 2],
            flicker: 0.0,
            log: None,
            beam: None,
            stated_factor: 1.0,
        }
    }
}

impl Disturbances {
    /// Checks them against a robot and a campaign.
    ///
    /// # Errors
    /// For deviations of another number of joints, and more bad poses than there are poses.
    pub(crate) fn fits(&self, movable: usize, poses: usize) -> Result<(), SimulateError> {
        if !self.joint_sd.is_empty() && self.joint_sd.len() != movable {
            let what = "joint deviations";
            return Err(SimulateError::Shape { what, have: self.joint_sd.len(), need: movable });
        }
        if self.bad_poses > poses {
            let what = "the number of bad poses";
            return Err(SimulateError::Size {
                what,
                value: self.bad_poses as f64,
                need: "at most that of poses",
            });
        }
        self.wander.as_ref().map_or(Ok(()), Wander::checked)
    }

    /// Deviation of each joint at one pose, rad or m.
    pub(crate) fn joints(&self, rng: &mut impl Rng) -> Vec<f64> {
        self.joint_sd.iter().map(|sd| sd * normal(rng)).collect()
    }

    /// The displacement of each pose as a whole, m; none of most.
    pub(crate) fn displaced_poses(&self, poses: usize, rng: &mut impl Rng) -> Vec<Option<Vector3<f64>>> {
        let mut all = vec![None; poses];
        for pose in sample(rng, poses, self.bad_poses) {
            let size = self.bad_size[0] + (self.bad_size[1] - self.bad_size[0]) * rng.random::<f64>();
            let direction = Vector3::from_fn(|_, _| normal(rng));
            all[pose] = Some(direction.normalize() * size);
        }
        all
    }

    /// A joint value as it is recorded, rad or m.
    pub(crate) fn recorded(&self, q: f64, rng: &mut impl Rng) -> f64 {
        q + self.flicker * (2.0 * rng.random::<f64>() - 1.0)
    }
}
