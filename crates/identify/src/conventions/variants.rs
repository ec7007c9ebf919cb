//! Mistakes of convention in a robot's description, each as a change that undoes it.

use super::misread::Misreading;
use nalgebra::{Matrix3, Vector3};
use std::f64::consts::PI;
use truepose_errormodel::Dataset;
use truepose_kinematics::{Chain, Joint, JointKind, Placement, Pose};

/// Mistakes that are tried on this robot, those about orientations and lengths apart; `oriented`: orientations were measured, too.
pub(super) fn readings(chain: &Chain, oriented: bool) -> Vec<Misreading> {
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
    if oriented {
        list.push(Misreading::InversePoses);
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
            (Misreading::Coupling { .. } | Misreading::InversePoses, _) => return None,
            _ => {}
        }
    }
    let other = Chain::new(chain.name(), joints).ok()?;
    let other = other.with_base(*chain.base()).and_then(|c| c.with_tool(*chain.tool())).ok()?;
    other.with_targets(chain.targets().to_vec()).ok()
}

/// Measurements with the mistake undone, where it is one of theirs.
pub(super) fn undo_rows(what: &Misreading, data: &mut Dataset) {
    match *what {
        Misreading::Coupling { joint, driver, sign } => {
            let before = data.joints[driver].clone();
            data.joints[joint].iter_mut().zip(before).for_each(|(q, driver)| *q += sign * driver);
        }
        Misreading::InversePoses => {
            for row in 0..data.len() {
                let Some(rotation) = data.measured_rotation(row) else {
                    data.position[row] = [f64::NAN; 3];
                    continue;
                };
                let inverse: Matrix3<f64> = rotation.transpose();
                data.position[row] = (-(inverse * data.measured_position(row))).into();
                data.orientation[row] = Some(Pose::new(inverse, Vector3::zeros()).quaternion());
            }
        }
        _ => (),
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
