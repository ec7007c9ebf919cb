//! The gantry's description: three slides over a hall, a turning head, three targets.

use crate::SimulateError;
use nalgebra::{Unit, Vector3};
use std::f64::consts::PI;
use truepose_kinematics::{Chain, Joint, JointKind, Placed, Placement, Pose, Target};

/// A gantry of 3 × 2 × 1 m with a head that turns about the vertical.
///
/// # Errors
/// None in practice: the description is a constant, held by this crate's tests.
pub fn gantry() -> Result<Chain, SimulateError> {
    let joint = |name: &str, kind, xyz: [f64; 3], axis: [f64; 3], limit: (f64, f64), mass, com| {
        let pose = Pose { translation: Vector3::from(xyz), ..Pose::IDENTITY };
        let axis = Unit::new_normalize(Vector3::from(axis));
        Joint::new(name, kind, Placement::Origin { pose, axis })
            .with_limits(limit.0, limit.1)
            .with_link(mass, com)
    };
    let (slide, turn) = (JointKind::Prismatic, JointKind::Revolute);
    let (x, y, down, up) = ([1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, -1.0], [0.0, 0.0, 1.0]);
    let joints = vec![
        joint("gx", slide, [0.0, 0.0, 2.2], x, (0.0, 3.0), 600.0, [0.0, 0.0, 0.2]),
        joint("gy", slide, [0.0, 0.0, 0.15], y, (0.0, 2.0), 180.0, [0.05, 0.0, 0.0]),
        joint("gz", slide, [0.1, 0.0, -0.2], down, (0.0, 1.0), 90.0, [0.0, 0.02, 0.3]),
        joint("gw", turn, [0.0, 0.0, -0.35], up, (-PI, PI), 25.0, [0.05, 0.0, -0.08]),
    ];
    let target = |name: &str, xyz: [f64; 3]| Target {
        name: name.into(),
        position: Vector3::from(xyz),
        known: true,
        tool: truepose_kinematics::ToolId::FIRST,
    };
    let targets = vec![
        target("G1", [0.25, 0.0, 0.0]),
        target("G2", [-0.05, 0.2, -0.03]),
        target("G3", [-0.05, -0.2, 0.05]),
    ];
    let tool = Pose { translation: Vector3::new(0.12, 0.0, -0.2), ..Pose::IDENTITY };
    Chain::new("gantry", joints)
        .and_then(|chain| chain.with_tool(Placed { pose: tool, known: true }))
        .and_then(|chain| chain.with_targets(targets))
        .map_err(SimulateError::from)
}
