//! Sample robots, shared by tests and examples: published nominal dimensions, no measured data.

use crate::{
    Chain, ChainError, Gravity, GravityFrame, Joint, JointId, JointKind, Placed, Placement, Pose, Target,
    Tool, ToolId,
};
use nalgebra::{Unit, Vector3};
use std::f64::consts::{FRAC_PI_2, PI};

/// One of every kind below.
pub fn all() -> Vec<Chain> {
    vec![ur10(), heavy(), pps(), skewed(), scara(), seven()]
}

/// Universal Robots' UR10: 6R, standard DH (maker's published values), no tool.
pub fn ur10() -> Chain {
    let rows = [
        (0.1273, 0.0, FRAC_PI_2),
        (0.0, -0.612, 0.0),
        (0.0, -0.5723, 0.0),
        (0.163941, 0.0, FRAC_PI_2),
        (0.1157, 0.0, -FRAC_PI_2),
        (0.0922, 0.0, 0.0),
    ];
    let joints = rows.iter().enumerate().map(|(k, &(d, a, alpha))| {
        Joint::new(format!("j{}", k + 1), JointKind::Revolute, Placement::Dh { theta: 0.0, d, a, alpha })
            .with_limits(-2.0 * PI, 2.0 * PI)
    });
    made(Chain::new("ur10", joints.collect()))
}

/// A heavy 6R arm in Craig's convention, with link weights, an inclined base and three targets.
pub fn heavy() -> Chain {
    let rows: [(f64, f64, f64, f64, f64, [f64; 3]); 6] = [
        (0.0, 0.0, 0.0, 0.65, 380.0, [0.1, 0.02, -0.14]),
        (-FRAC_PI_2, 0.32, 0.0, 0.0, 260.0, [0.5, -0.03, 0.05]),
        (0.0, 1.1, -FRAC_PI_2, 0.0, 190.0, [0.02, 0.16, -0.04]),
        (-FRAC_PI_2, -0.05, 0.0, 1.15, 70.0, [0.0, 0.01, -0.33]),
        (FRAC_PI_2, 0.0, 0.0, 0.0, 40.0, [0.0, -0.05, 0.01]),
        (-FRAC_PI_2, 0.0, 0.0, 0.21, 15.0, [0.0, 0.0, -0.03]),
    ];
    let joints = rows.iter().enumerate().map(|(k, &(alpha, a, theta, d, mass, com))| {
        Joint::new(format!("a{}", k + 1), JointKind::Revolute, Placement::Mdh { alpha, a, theta, d })
            .with_limits(-2.0, 2.0)
            .with_link(mass, com)
    });
    let base = Placed { pose: Pose::from_xyz_rpy([1.4, 0.3, 0.5], [0.0, 0.1, 0.5]), known: true };
    let tool = Placed { pose: Pose::from_xyz_rpy([0.05, 0.0, 0.25], [0.0; 3]), known: true };
    made(
        Chain::new("heavy", joints.collect())
            .and_then(|c| c.with_base(base))
            .and_then(|c| c.with_tool(tool))
            .and_then(|c| {
                c.with_targets(vec![
                    target("T1", [0.15, 0.0, 0.05]),
                    target("T2", [-0.1, 0.14, 0.0]),
                    target("T3", [-0.1, -0.13, 0.1]),
                ])
            }),
    )
}

/// The paper's patient positioning system: three slides and three turns, gravity along −y, three targets.
pub fn pps() -> Chain {
    let joint = |name: &str, kind, xyz, axis, limit: (f64, f64)| {
        Joint::new(name, kind, origin(xyz, [0.0; 3], axis)).with_limits(limit.0, limit.1)
    };
    let (slide, turn, small) = (JointKind::Prismatic, JointKind::Revolute, (-PI / 60.0, PI / 60.0));
    let (x, y, z) = ([1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]);
    let joints = vec![
        joint("d1", slide, [0.0, -2.0, 0.0], x, (-1.125, 1.125)).with_link(900.0, [0.0, 0.2, 0.0]),
        joint("d2", slide, [0.0, 0.7, 0.0], y, (-0.28, 0.28)).with_link(420.0, [0.0, 0.2, 0.1]),
        joint("d3", slide, [0.0, 0.5, 0.0], z, (-1.17, 0.3)).with_link(310.0, [0.0, 0.15, 0.15]),
        joint("theta", turn, [0.0, 0.4, 0.0], y, (-FRAC_PI_2, FRAC_PI_2)).with_link(150.0, [0.0, 0.1, -0.1]),
        joint("roll", turn, [0.0, 0.2, 0.0], z, small).with_link(45.0, [0.01, 0.05, -0.1]),
        joint("pitch", turn, [0.0, 0.1, 0.0], x, small).with_link(85.0, [0.0, 0.06, -0.85]),
    ];
    let tool = Placed { pose: Pose::from_xyz_rpy([0.0, 0.1, 0.0], [0.0; 3]), known: true };
    made(
        Chain::new("pps", joints)
            .and_then(|c| c.with_tool(tool))
            .and_then(|c| {
                c.with_gravity(Gravity {
                    vector: Vector3::new(0.0, -9.81, 0.0),
                    frame: GravityFrame::Measurement,
                })
            })
            .and_then(|c| {
                c.with_targets(vec![
                    target("P1", [-0.22, 0.01, -0.55]),
                    target("P2", [0.22, 0.01, -0.62]),
                    target("P3", [0.03, 0.01, -1.25]),
                ])
            }),
    )
}

/// A made-up robot that has everything odd at once: negative and skew axes, a fixed joint, a slide, mixed conventions.
pub fn skewed() -> Chain {
    let joints = vec![
        Joint::new("s1", JointKind::Revolute, origin([0.1, 0.2, 0.3], [0.1, -0.2, 0.3], [0.0, 0.0, -1.0]))
            .with_link(5.0, [0.1, 0.2, 0.0]),
        Joint::new("flange", JointKind::Fixed, origin([0.0, 0.1, 0.2], [0.4, 0.0, 0.0], [0.0, 0.0, 1.0]))
            .with_link(1.0, [0.0, 0.0, 0.1]),
        Joint::new("s2", JointKind::Prismatic, origin([0.2, 0.0, 0.1], [0.0, 0.5, 0.2], [1.0, -2.0, 0.5]))
            .with_link(3.0, [0.0, 0.1, 0.0]),
        Joint::new("s3", JointKind::Revolute, origin([0.0, -0.2, 0.4], [0.3, 0.2, 0.1], [1.0, 1.0, 1.0]))
            .with_link(2.0, [0.05, 0.0, 0.2]),
        Joint::new("s4", JointKind::Prismatic, Placement::Dh { theta: 0.3, d: 0.1, a: 0.2, alpha: -1.1 }),
        Joint::new("s5", JointKind::Revolute, Placement::Dh { theta: -0.4, d: 0.2, a: 0.1, alpha: 0.7 })
            .with_link(1.5, [0.0, 0.0, 0.1]),
    ];
    let tool = Placed { pose: Pose::from_xyz_rpy([0.1, 0.05, 0.2], [0.2, -0.3, 0.4]), known: true };
    made(Chain::new("skewed", joints).and_then(|c| c.with_tool(tool)).and_then(|c| {
        c.with_gravity(Gravity { vector: Vector3::new(0.5, -1.0, -9.7), frame: GravityFrame::Base })
    }))
}

/// A SCARA: two parallel turns, a slide and a turn.
pub fn scara() -> Chain {
    let mdh = |alpha, a, d| Placement::Mdh { alpha, a, theta: 0.0, d };
    let joints = vec![
        Joint::new("r1", JointKind::Revolute, mdh(0.0, 0.0, 0.4)).with_limits(-2.2, 2.2),
        Joint::new("r2", JointKind::Revolute, mdh(0.0, 0.35, 0.0)).with_limits(-2.5, 2.5),
        Joint::new("slide", JointKind::Prismatic, mdh(PI, 0.3, 0.0)).with_limits(0.0, 0.25),
        Joint::new("r4", JointKind::Revolute, mdh(0.0, 0.0, 0.05)).with_limits(-PI, PI),
    ];
    made(Chain::new("scara", joints))
}

/// A 7R arm with spherical shoulder and wrist, in Craig's convention.
pub fn seven() -> Chain {
    let rows = [
        (0.0, 0.34),
        (-FRAC_PI_2, 0.0),
        (FRAC_PI_2, 0.4),
        (FRAC_PI_2, 0.0),
        (-FRAC_PI_2, 0.4),
        (-FRAC_PI_2, 0.0),
        (FRAC_PI_2, 0.126),
    ];
    let joints = rows.iter().enumerate().map(|(k, &(alpha, d))| {
        Joint::new(
            format!("k{}", k + 1),
            JointKind::Revolute,
            Placement::Mdh { alpha, a: 0.0, theta: 0.0, d },
        )
        .with_limits(-2.9, 2.9)
        .with_link(4.0, [0.0, 0.01, 0.1])
    });
    made(Chain::new("seven", joints.collect()))
}

/// Two arms of three joints on a torso that turns and nods, with link weights and a tool each.
pub fn dual() -> Chain {
    let turn = |name: String, xyz: [f64; 3], rpy: [f64; 3], axis: [f64; 3], mass: f64| {
        Joint::new(name, JointKind::Revolute, origin(xyz, rpy, axis))
            .with_link(mass, [0.02, -0.01, 0.5 * xyz[2] + 0.05])
            .with_limits(-2.5, 2.5)
    };
    let mut joints = vec![
        turn("torso_yaw".into(), [0.0, 0.0, 0.3], [0.0; 3], [0.0, 0.0, 1.0], 20.0),
        turn("torso_pitch".into(), [0.05, 0.0, 0.25], [0.0; 3], [0.0, 1.0, 0.0], 12.0),
    ];
    let mut parents = vec![None, Some(JointId(1))];
    for (side, y) in [("left", 0.22), ("right", -0.22)] {
        joints.push(Joint::new(
            format!("{side}_shoulder"),
            JointKind::Fixed,
            origin([0.0, y, 0.35], [0.3 * y.signum(), 0.0, 0.0], [0.0, 0.0, 1.0]),
        ));
        joints.push(turn(format!("{side}_1"), [0.0, 0.0, 0.05], [0.0; 3], [0.0, 0.0, 1.0], 4.0));
        joints.push(turn(format!("{side}_2"), [0.03, 0.0, 0.12], [0.0; 3], [0.0, 1.0, 0.0], 3.0));
        joints.push(turn(format!("{side}_3"), [0.30, 0.0, 0.02], [0.0; 3], [0.0, 1.0, 0.0], 1.5));
        let first = joints.len() - 3;
        parents.extend([
            Some(JointId(2)),
            Some(JointId(first)),
            Some(JointId(first + 1)),
            Some(JointId(first + 2)),
        ]);
    }
    let hand = |x: f64| Placed { pose: Pose::from_xyz_rpy([x, 0.02, 0.0], [0.0, 0.2, 0.0]), known: true };
    made(Chain::new("dual", joints).and_then(|c| c.with_parents(&parents)).and_then(|c| {
        c.with_tools(vec![
            Tool::on("left", Some(JointId(6)), hand(0.25)),
            Tool::on("right", Some(JointId(10)), hand(0.28)),
        ])
        .and_then(|c| {
            c.with_targets(vec![
                target("L", [0.05, 0.0, 0.02]),
                Target { tool: ToolId(1), ..target("R", [0.0, 0.04, 0.03]) },
            ])
        })
    }))
}

fn origin(xyz: [f64; 3], rpy: [f64; 3], axis: [f64; 3]) -> Placement {
    Placement::Origin { pose: Pose::from_xyz_rpy(xyz, rpy), axis: Unit::new_normalize(Vector3::from(axis)) }
}

fn target(name: &str, position: [f64; 3]) -> Target {
    Target { name: name.into(), position: Vector3::from(position), known: true, tool: ToolId::FIRST }
}

/// The descriptions above are constants; an error in one of them is a defect of this file, which its tests show.
fn made(chain: Result<Chain, ChainError>) -> Chain {
    match chain {
        Ok(chain) => chain,
        Err(error) => panic!("a sample robot is described wrongly: {error}"),
    }
}
