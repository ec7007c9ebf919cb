//! A joint and its nominal transform `A_i(q_i)`, in three conventions.
//!
//! ```text
//! dh       Rz(θ) Tz(d) Tx(a) Rx(α)      the axis is z of frame i-1
//! mdh      Rx(α) Tx(a) Rz(θ) Tz(d)      the axis is z of frame i        (Craig)
//! origin   pose · motion(axis, q)       the axis is `axis` in frame i   (URDF)
//! ```

use crate::{ChainError, Pose};
use nalgebra::{Unit, Vector3};
use serde::{Deserialize, Serialize};

/// How a joint moves.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum JointKind {
    /// Turns about its axis; the variable is an angle in rad.
    Revolute,
    /// Slides along its axis; the variable is a length in m.
    Prismatic,
    /// Does not move and has no variable.
    Fixed,
}

/// Where a joint sits and along or about which line it moves.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Placement {
    /// Denavit and Hartenberg: `Rz(θ) Tz(d) Tx(a) Rx(α)`; the variable adds to θ or d.
    Dh {
        /// θ, rad.
        theta: f64,
        /// d, m.
        d: f64,
        /// a, m.
        a: f64,
        /// α, rad.
        alpha: f64,
    },
    /// Craig's modified form: `Rx(α) Tx(a) Rz(θ) Tz(d)`; the variable adds to θ or d.
    Mdh {
        /// α, rad.
        alpha: f64,
        /// a, m.
        a: f64,
        /// θ, rad.
        theta: f64,
        /// d, m.
        d: f64,
    },
    /// URDF: a fixed origin, then the motion along or about a unit axis given in the joint's frame.
    Origin {
        /// Pose of the joint's frame in the one before, at q = 0.
        pose: Pose,
        /// Unit direction in the joint's own frame.
        axis: Unit<Vector3<f64>>,
    },
}

/// The body that a joint moves.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Link {
    /// kg.
    pub mass: f64,
    /// Centre of mass in the frame after the joint, m.
    pub com: Vector3<f64>,
}

/// One joint of a chain, with the link that it moves.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Joint {
    /// Its name, which is the name of its column in the data.
    pub name: String,
    /// How it moves.
    pub kind: JointKind,
    /// Where it sits.
    pub placement: Placement,
    /// Lower and upper limit of the variable, rad or m; of a coupled joint what the controller's values can add up to.
    pub limits: Option<(f64, f64)>,
    /// Mass and centre of mass of the link behind it, where known.
    pub link: Option<Link>,
}

impl Joint {
    /// A joint without limits and without a known link.
    pub fn new(name: impl Into<String>, kind: JointKind, placement: Placement) -> Self {
        Joint { name: name.into(), kind, placement, limits: None, link: None }
    }

    /// With limits of its variable, rad or m.
    pub fn with_limits(mut self, lower: f64, upper: f64) -> Self {
        self.limits = Some((lower, upper));
        self
    }

    /// With the mass (kg) and centre of mass (m, in the frame after the joint) of its link.
    pub fn with_link(mut self, mass: f64, com: [f64; 3]) -> Self {
        self.link = Some(Link { mass, com: Vector3::from(com) });
        self
    }

    /// True unless the joint is fixed.
    pub fn moves(&self) -> bool {
        self.kind != JointKind::Fixed
    }

    /// SI unit of the joint's variable.
    pub fn unit(&self) -> &'static str {
        match self.kind {
            JointKind::Prismatic => "m",
            _ => "rad",
        }
    }

    pub(crate) fn validate(&self) -> Result<(), ChainError> {
        let not_finite = |what| ChainError::NotFinite { what, name: self.name.clone() };
        let numbers = match &self.placement {
            Placement::Dh { theta, d, a, alpha } | Placement::Mdh { theta, d, a, alpha } => {
                [theta, d, a, alpha].iter().all(|v| v.is_finite())
            }
            Placement::Origin { pose, axis } => {
                let length = axis.norm();
                if self.moves() && (length.is_nan() || (length - 1.0).abs() > 1e-9) {
                    return Err(ChainError::NoAxis { name: self.name.clone() });
                }
                pose.is_finite()
            }
        };
        if !numbers {
            return Err(not_finite("the placement"));
        }
        if let Some((lower, upper)) = self.limits {
            if lower.is_nan() || upper.is_nan() {
                return Err(not_finite("a limit"));
            }
            if lower > upper {
                return Err(ChainError::Limits { name: self.name.clone(), lower, upper });
            }
        }
        if let Some(link) = &self.link {
            if !link.mass.is_finite() || !link.com.iter().all(|v| v.is_finite()) {
                return Err(not_finite("the link's mass or centre"));
            }
            if link.mass < 0.0 {
                return Err(ChainError::NegativeMass { name: self.name.clone(), mass_kg: link.mass });
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn negative_axis_turns_the_other_way() {
        let origin = |z: f64| Placement::Origin {
            pose: Pose::IDENTITY,
            axis: Unit::new_normalize(Vector3::new(0.0, 0.0, z)),
        };
        let plus = Joint::new("a", JointKind::Revolute, origin(1.0));
        let minus = Joint::new("a", JointKind::Revolute, origin(-1.0));
        assert_eq!(plus.transform(0.3), minus.transform(-0.3));
    }

    #[test]
    fn dh_and_mdh_agree_when_shifted() {
        // DH of joints i and i+1 seen from between: Rz Tz | Tx Rx is MDH shifted by half a joint.
        let dh =
            Joint::new("a", JointKind::Revolute, Placement::Dh { theta: 0.2, d: 0.3, a: 0.4, alpha: 0.5 });
        let screw =
            Joint::new("a", JointKind::Revolute, Placement::Mdh { alpha: 0.0, a: 0.0, theta: 0.2, d: 0.3 });
        let rest =
            Joint::new("b", JointKind::Fixed, Placement::Mdh { alpha: 0.5, a: 0.4, theta: 0.0, d: 0.0 });
        let joined = screw.transform(0.7) * rest.transform(0.0);
        assert!((dh.transform(0.7).rotation - joined.rotation).amax() < 1e-15);
        assert!((dh.transform(0.7).translation - joined.translation).amax() < 1e-15);
    }
}
