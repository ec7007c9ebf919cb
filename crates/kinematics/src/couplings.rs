//! Joint values of the controller, and the variables of the joints.
//!
//! ```text
//! q_j = u_j + Σ_d f_jd u_d          q = C u,   C with ones on its diagonal, triangular where drivers come first
//! ```
//!
//! | symbol | name | shape | unit |
//! | --- | --- | --- | --- |
//! | u | values that the controller reports and takes | n | rad, m |
//! | q | variables of the joints, `A_i(q_i)` | n | rad, m |
//! | f | `factor` of a coupling | 1 | 1 |
//!
//! A joint turns by more than its own value where a drive acts through another joint (a parallelogram holds the direction of the forearm,
//! the drives of a wrist pass through its first joint), and where the controller counts an angle from the horizontal (J3 of FANUC).
//! Kinematics, data sets, models and commands are in q. Values u occur where tables are read and written, and at limits.

use crate::{ChainError, JointId};
use serde::{Deserialize, Serialize};

/// A joint that follows another one.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Mimic {
    /// The joint that follows.
    pub joint: JointId,
    /// The joint that it follows; it may follow a third one.
    pub driver: JointId,
    /// r: unit of the joint per unit of the driver.
    pub ratio: f64,
    /// o, rad or m.
    pub offset: f64,
}

/// A following joint by coordinates, with the joint at the end of its drivers.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Follower {
    /// The coordinate of the joint that follows.
    pub joint: usize,
    /// The coordinate of a joint that follows none.
    pub driver: usize,
    /// r.
    pub ratio: f64,
    /// o, rad or m.
    pub offset: f64,
}

/// The joint's variable contains `factor` times the driver's controller value, besides its own.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Coupling {
    /// The joint that turns by more than its own value.
    pub joint: JointId,
    /// The joint whose controller value is added.
    pub driver: JointId,
    /// f, rad/rad or m/m.
    pub factor: f64,
}

/// The couplings of a robot, by the coordinates of its movable joints.
#[derive(Debug, Clone, PartialEq, Default)]
pub(crate) struct Couplings {
    pub declared: Vec<Coupling>,
    /// Coordinates of joint and driver, and factor; a joint's rows stand behind those of its drivers.
    terms: Vec<(usize, usize, f64)>,
    /// Limits of the controller's value of each movable joint; empty without couplings.
    limits: Vec<Option<(f64, f64)>>,
    /// Joints that follow others.
    pub mimics: Vec<Mimic>,
    pub followers: Vec<Follower>,
}

impl Couplings {
    /// Of these couplings, which are the same by coordinates in `open`.
    pub fn new(
        declared: Vec<Coupling>,
        mut open: Vec<(usize, usize, f64)>,
        limits: Vec<Option<(f64, f64)>>,
    ) -> Result<Self, ChainError> {
        let mut terms: Vec<(usize, usize, f64)> = Vec::with_capacity(open.len());
        while !open.is_empty() {
            let follows = |joint: usize| open.iter().any(|(a, ..)| *a == joint);
            let free = |joint: usize| open.iter().all(|&(a, driver, _)| a != joint || !follows(driver));
            let Some(joint) = open.iter().map(|(joint, ..)| *joint).find(|&joint| free(joint)) else {
                return Err(ChainError::CouplingCircle);
            };
            terms.extend(open.iter().filter(|(a, ..)| *a == joint));
            open.retain(|(a, ..)| *a != joint);
        }
        let limits = if terms.is_empty() { Vec::new() } else { limits };
        Ok(Couplings { declared, terms, limits, ..Couplings::default() })
    }

    /// Controller's values into variables.
    #[inline]
    pub fn variables(&self, values: &mut [f64]) {
        // The last first: a driver still has its own value when it is added.
        for &(joint, driver, factor) in self.terms.iter().rev() {
            values[joint] += factor * values[driver];
        }
        self.follow(values);
    }

    /// Values of joints that follow others.
    #[inline]
    pub fn follow(&self, variables: &mut [f64]) {
        for follower in &self.followers {
            variables[follower.joint] = follower.ratio * variables[follower.driver] + follower.offset;
        }
    }

    /// Variables into controller's values.
    #[inline]
    pub fn values(&self, variables: &mut [f64]) {
        for &(joint, driver, factor) in &self.terms {
            variables[joint] -= factor * variables[driver];
        }
    }

    /// The controller's value of one joint, without memory for the others: couplings are few.
    pub fn value(&self, k: usize, variables: &[f64]) -> f64 {
        let own = self.terms.iter().filter(|(joint, ..)| *joint == k);
        variables[k] - own.map(|&(_, driver, factor)| factor * self.value(driver, variables)).sum::<f64>()
    }

    /// Limits of the controller's value of a movable joint; none where there are no couplings.
    pub fn limits(&self, k: usize) -> Option<Option<(f64, f64)>> {
        self.limits.get(k).copied()
    }

    /// Whether the controller's values of these variables are within their limits, to 1e-9.
    pub fn within(&self, variables: &[f64]) -> bool {
        self.limits.iter().enumerate().all(|(k, limits)| {
            limits.is_none_or(|(lower, upper)| {
                (lower - 1e-9..=upper + 1e-9).contains(&self.value(k, variables))
            })
        })
    }

    /// Between what ends a joint's variable can be, given the limits of the controller's values.
    pub fn extent(&self, k: usize) -> Option<(f64, f64)> {
        let mut extent = self.limits[k]?;
        for &(_, driver, factor) in self.terms.iter().filter(|(joint, ..)| *joint == k) {
            let (lower, upper) = self.limits[driver]?;
            let ends = (factor * lower, factor * upper);
            extent = (extent.0 + ends.0.min(ends.1), extent.1 + ends.0.max(ends.1));
        }
        Some(extent)
    }
}
