//! Mistakes of convention in a robot's description, each as a change that undoes it.

use std::f64::consts::PI;
use truepose_errormodel::Dataset;
use truepose_kinematics::{Chain, Joint, JointKind, Placement};

/// What was probably done. Joints are numbers among all joints, from 0; of couplings among the movable ones.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub enum Misreading {
    /// Parameters of the standard form (dh) were given as modified (mdh).
    MdhForDh,
    /// Parameters of the modified form (mdh) were given as standard (dh).
    DhForMdh,
    /// α and θ of the description are in another unit; the factor puts them right.
    AngleUnit {
        /// Of α and θ.
        factor: f64,
    },
    /// A parameter (`a`, `d`, `alpha`, `theta`) has the wrong sign, of one joint or of all.
    Sign {
        /// The joint; none: all joints.
        joint: Option<usize>,
        /// The parameter.
        parameter: &'static str,
    },
    /// A joint's value contains that of the joint before (FANUC, parallelograms): q_joint + sign · q_driver is meant.
    Coupling {
        /// The joint.
        joint: usize,
        /// The joint before.
        driver: usize,
        /// +1 or −1.
        sign: f64,
    },
    /// A length is wrong.
    Length {
        /// The joint.
        joint: usize,
        /// `a`, `d`, or `x`, `y`, `z` of an origin.
        parameter: &'static str,
        /// What has to be added, m.
        change: f64,
    },
    /// Orientations are in this convention, and were read as a rotation vector.
    Angles {
        /// Its word in files.
        convention: &'static str,
    },
    /// Orientations are angles of this convention, and were read as those of another one.
    OtherAngles {
        /// Its word in files.
        convention: &'static str,
    },
    /// Orientations are those of the measurement frame seen from the tool.
    InverseOrientation,
    /// Quaternions have their scalar last.
    ScalarLast,
}

/// Mistakes that are tried on this robot; those about orientations and lengths apart.
pub(super) fn readings(chain: &Chain) -> Vec<Misreading> {
    let mut list = Vec::new();
    let joints = chain.joints();
    let any = |is: fn(&Placement) -> bool| joints.iter().any(|joint| is(&joint.placement));
    let parameters = any(|p| matches!(p, Placement::Dh { .. } | Placement::Mdh { .. }));
    if any(|p| matches!(p, Placement::Mdh { .. })) {
        list.push(Misreading::MdhForDh);
    }
    if any(|p| matches!(p, Placement::Dh { .. })) {
        list.push(Misreading::DhForMdh);
    }
    if parameters {
        list.extend([PI / 180.0, 180.0 / PI].map(|factor| Misreading::AngleUnit { factor }));
        for parameter in ["a", "alpha", "d", "theta"] {
            list.push(Misreading::Sign { joint: None, parameter });
            for (k, joint) in joints.iter().enumerate() {
                if value(joint, parameter).is_some_and(|v| v.abs() > 1e-9) {
                    list.push(Misreading::Sign { joint: Some(k), parameter });
                }
            }
        }
    }
    let movable = chain.movable();
    for joint in 1..movable.len() {
        let turns = [joint - 1, joint].iter().all(|&k| chain.joint(movable[k]).kind == JointKind::Revolute);
        if turns {
            list.extend([1.0, -1.0].map(|sign| Misreading::Coupling { joint, driver: joint - 1, sign }));
        }
    }
    list
}

/// Joints and parameters of the lengths that may be wrong.
pub(super) fn lengths(chain: &Chain) -> Vec<(usize, &'static str)> {
    let of = |joint: &Joint| -> &'static [&'static str] {
        match joint.placement {
            Placement::Origin { .. } => &["x", "y", "z"],
            _ => &["a", "d"],
        }
    };
    let joints = chain.joints().iter().enumerate();
    joints.flat_map(|(k, joint)| of(joint).iter().map(move |&parameter| (k, parameter))).collect()
}

/// The robot with the mistake undone; none where the mistake is not in the robot.
pub(super) fn undone(what: &Misreading, chain: &Chain) -> Option<Chain> {
    let mut joints: Vec<Joint> = chain.joints().to_vec();
    for (k, joint) in joints.iter_mut().enumerate() {
        match (what, joint.placement) {
            (Misreading::MdhForDh, Placement::Mdh { alpha, a, theta, d }) => {
                joint.placement = Placement::Dh { theta, d, a, alpha };
            }
            (Misreading::DhForMdh, Placement::Dh { theta, d, a, alpha }) => {
                joint.placement = Placement::Mdh { alpha, a, theta, d };
            }
            (Misreading::AngleUnit { factor }, _) => {
                change(joint, "alpha", |v| v * factor);
                change(joint, "theta", |v| v * factor);
            }
            (Misreading::Sign { joint: which, parameter }, _) if which.is_none_or(|which| which == k) => {
                change(joint, parameter, |v| -v);
            }
            (Misreading::Length { joint: which, parameter, change: by }, _) if *which == k => {
                change(joint, parameter, |v| v + by);
            }
            (Misreading::Coupling { .. }, _) => return None,
            _ => {}
        }
    }
    let other = Chain::new(chain.name(), joints).ok()?;
    let other = other.with_base(*chain.base()).and_then(|c| c.with_tool(*chain.tool())).ok()?;
    other.with_targets(chain.targets().to_vec()).ok()
}

/// Joint values with the mistake undone.
pub(super) fn undo_joints(what: &Misreading, data: &mut Dataset) {
    if let Misreading::Coupling { joint, driver, sign } = *what {
        let before = data.joints[driver].clone();
        data.joints[joint].iter_mut().zip(before).for_each(|(q, driver)| *q += sign * driver);
    }
}

fn value(joint: &Joint, parameter: &str) -> Option<f64> {
    let mut copy = joint.clone();
    let mut found = None;
    change(&mut copy, parameter, |v| {
        found = Some(v);
        v
    });
    found
}

fn change(joint: &mut Joint, parameter: &str, to: impl FnOnce(f64) -> f64) {
    let slot = match &mut joint.placement {
        Placement::Dh { theta, d, a, alpha } | Placement::Mdh { alpha, a, theta, d } => match parameter {
            "theta" => theta,
            "d" => d,
            "a" => a,
            "alpha" => alpha,
            _ => return,
        },
        Placement::Origin { pose, .. } => match parameter {
            "x" => &mut pose.translation.x,
            "y" => &mut pose.translation.y,
            "z" => &mut pose.translation.z,
            _ => return,
        },
    };
    *slot = to(*slot);
}
