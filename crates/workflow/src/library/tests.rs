use super::*;
use truepose_io::{RobotOptions, read_robot};
use truepose_kinematics::{Chain, Placed, Pose};

fn robot(name: &str) -> Chain {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("r.toml");
    std::fs::write(&path, Known::named(name).unwrap().text).unwrap();
    let (chain, warnings) = read_robot(&path, &RobotOptions::default()).unwrap();
    assert_eq!(warnings, []);
    chain.with_base(Placed::default()).and_then(|chain| chain.with_tool(Placed::default())).unwrap()
}

/// The flange at the controller's values, degrees.
fn flange(chain: &Chain, degrees: &[f64]) -> Pose {
    let mut joints: Vec<f64> = degrees.iter().map(|v| v.to_radians()).collect();
    chain.joints_from_controller(&mut joints);
    chain.forward(&joints)
}

#[test]
fn every_robot_is_read_and_names_its_source() {
    for known in ROBOTS {
        let chain = robot(known.name);
        assert_eq!(chain.name(), known.name);
        assert!(known.text.lines().nth(1).unwrap().starts_with("# Source: "), "{}", known.name);
        assert!(matches!(chain.movable().len(), 6 | 7));
        assert_eq!(chain.joints().len(), chain.movable().len());
    }
    let files = std::fs::read_dir(concat!(env!("CARGO_MANIFEST_DIR"), "/robots")).unwrap().count();
    assert_eq!(files, ROBOTS.len());
}

/// What the pendant shows with all axes at zero, mm, and the direction that the flange looks at.
#[test]
fn flange_at_all_zeros() {
    let published: [(&str, [f64; 3], [f64; 3]); 14] = [
        ("ur5e", [-817.2, -232.9, 62.8], [0.0, -1.0, 0.0]),
        ("ur10e", [-1184.25, -290.7, 60.85], [0.0, -1.0, 0.0]),
        ("ur10", [-1184.3, -256.141, 11.6], [0.0, -1.0, 0.0]),
        ("panda", [88.0, 0.0, 926.0], [0.0, 0.0, -1.0]),
        ("iiwa7", [0.0, 0.0, 1266.0], [0.0, 0.0, 1.0]),
        ("iiwa14", [0.0, 0.0, 1306.0], [0.0, 0.0, 1.0]),
        ("xarm6", [207.0, 0.0, 112.0], [0.0, 0.0, -1.0]),
        ("xarm7", [206.0, 0.0, 120.5], [0.0, 0.0, -1.0]),
        ("meca500", [190.0, 0.0, 308.0], [1.0, 0.0, 0.0]),
        ("irb120", [374.0, 0.0, 630.0], [1.0, 0.0, 0.0]),
        ("lrmate200id", [465.0, 0.0, 365.0], [1.0, 0.0, 0.0]),
        ("gp7", [560.0, 0.0, 485.0], [1.0, 0.0, 0.0]),
        ("tx2-60", [0.0, 20.0, 670.0], [0.0, 0.0, 1.0]),
        ("kr6-r900-2", [990.0, 0.0, 425.0], [1.0, 0.0, 0.0]),
    ];
    for (name, xyz, z) in published {
        let chain = robot(name);
        let pose = flange(&chain, &vec![0.0; chain.movable().len()]);
        for k in 0..3 {
            assert!((1e3 * pose.translation[k] - xyz[k]).abs() < 1e-3, "{name} {:?}", 1e3 * pose.translation);
            assert!((pose.rotation[(k, 2)] - z[k]).abs() < 1e-6, "{name} {}", pose.rotation);
        }
    }
}

/// The reach of the wrist (of Stäubli: of the flange), mm, rounded as in the data sheets.
#[test]
fn published_reach() {
    for (name, reach) in [
        ("kr6-r900-2", 901.0),
        ("kr10-r1100-sixx", 1101.0),
        ("kr16-r2010-2", 2013.0),
        ("irb120", 580.0),
        ("irb1200-5-0.9", 901.0),
        ("irb2600-12-1.65", 1653.0),
        ("irb4600-60-2.05", 2051.0),
        ("lrmate200id", 717.0),
        ("m20ia", 1811.0),
        ("gp7", 927.0),
        ("gp12", 1440.0),
        ("gp25", 1730.0),
        ("tx2-60", 670.0),
        ("tx2-60l", 920.0),
        ("tx2-90", 1000.0),
    ] {
        let chain = robot(name);
        let at = |joint: usize| {
            chain.joints()[..=joint]
                .iter()
                .fold(Pose::IDENTITY, |pose, joint| pose * joint.transform(0.0))
                .translation
        };
        // In the plane in which joints 2 and 3 turn; axis 1 is z.
        let between = |a: usize, b: usize| (at(b) - at(a)).xz().norm();
        let last = if name.starts_with("tx2") { 5 } else { 4 };
        let reach_found = 1e3 * (at(1).x + between(1, 2) + between(2, last));
        assert!((reach_found - reach).abs() < 1.01, "{name}: {reach_found}");
    }
}

type Matrix = [[f64; 4]; 4];

fn product(a: &Matrix, b: &Matrix) -> Matrix {
    std::array::from_fn(|i| std::array::from_fn(|j| (0..4).map(|k| a[i][k] * b[k][j]).sum()))
}

fn turn([x, y, z]: [f64; 3], angle: f64) -> Matrix {
    let (s, c) = angle.sin_cos();
    let t = 1.0 - c;
    [
        [t * x * x + c, t * x * y - s * z, t * x * z + s * y, 0.0],
        [t * x * y + s * z, t * y * y + c, t * y * z - s * x, 0.0],
        [t * x * z - s * y, t * y * z + s * x, t * z * z + c, 0.0],
        [0.0, 0.0, 0.0, 1.0],
    ]
}

fn shift([x, y, z]: [f64; 3]) -> Matrix {
    [[1.0, 0.0, 0.0, x], [0.0, 1.0, 0.0, y], [0.0, 0.0, 1.0, z], [0.0, 0.0, 0.0, 1.0]]
}

/// A joint of a URDF: origin (m), rpy, axis.
type Urdf = ([f64; 3], [f64; 3], [f64; 3]);

fn urdf(joints: &[Urdf], tool: Urdf, angles: &[f64]) -> Matrix {
    let origin = |(xyz, [r, p, y], _): &Urdf| {
        let rpy = [turn([0.0, 0.0, 1.0], *y), turn([0.0, 1.0, 0.0], *p), turn([1.0, 0.0, 0.0], *r)];
        rpy.iter().fold(shift(*xyz), |all, one| product(&all, one))
    };
    let mut all = shift([0.0; 3]);
    for (joint, angle) in joints.iter().zip(angles) {
        all = product(&product(&all, &origin(joint)), &turn(joint.2, *angle));
    }
    product(&all, &origin(&tool))
}

#[track_caller]
fn same(name: &str, degrees: &[f64], expected: &Matrix) {
    let pose = flange(&robot(name), degrees);
    for (i, row) in expected.iter().take(3).enumerate() {
        assert!((pose.translation[i] - row[3]).abs() < 1e-6, "{name} {} {expected:?}", pose.translation);
        for (j, value) in row.iter().take(3).enumerate() {
            assert!((pose.rotation[(i, j)] - value).abs() < 1e-6, "{name} {} {expected:?}", pose.rotation);
        }
    }
}

/// In another posture, against the makers' URDFs, computed here.
#[test]
fn flange_in_another_posture() {
    use std::f64::consts::{FRAC_PI_2 as Q, PI};
    const X: [f64; 3] = [1.0, 0.0, 0.0];
    const Y: [f64; 3] = [0.0, 1.0, 0.0];
    const Z: [f64; 3] = [0.0, 0.0, 1.0];
    let o = [0.0; 3];
    let nowhere: Urdf = (o, o, Z);
    let degrees = [25.0, -70.0, 65.0, -35.0, 50.0, -15.0, 80.0];
    let radians = degrees.map(f64::to_radians);

    // ur_description: ur10e, default_kinematics.yaml.
    let ur10e: [Urdf; 6] = [
        ([0.0, 0.0, 0.1807], o, Z),
        (o, [Q, 0.0, 0.0], Z),
        ([-0.6127, 0.0, 0.0], o, Z),
        ([-0.57155, 0.0, 0.17415], o, Z),
        ([0.0, -0.11985, 0.0], [Q, 0.0, 0.0], Z),
        ([0.0, 0.11655, 0.0], [Q, PI, PI], Z),
    ];
    same("ur10e", &degrees[..6], &urdf(&ur10e, nowhere, &radians));
    // franka_description: fer, kinematics.yaml.
    let panda: [Urdf; 7] = [
        ([0.0, 0.0, 0.333], o, Z),
        (o, [-Q, 0.0, 0.0], Z),
        ([0.0, -0.316, 0.0], [Q, 0.0, 0.0], Z),
        ([0.0825, 0.0, 0.0], [Q, 0.0, 0.0], Z),
        ([-0.0825, 0.384, 0.0], [-Q, 0.0, 0.0], Z),
        (o, [Q, 0.0, 0.0], Z),
        ([0.088, 0.0, 0.0], [Q, 0.0, 0.0], Z),
    ];
    same("panda", &degrees, &urdf(&panda, ([0.0, 0.0, 0.107], o, Z), &radians));
    same("fr3", &degrees, &urdf(&panda, ([0.0, 0.0, 0.107], o, Z), &radians));
    // Axes of the LBR iiwa 14 at zero: z, y, z, -y, z, y, z.
    let iiwa: [Urdf; 7] = [
        ([0.0, 0.0, 0.1575], o, Z),
        ([0.0, 0.0, 0.2025], o, Y),
        ([0.0, 0.0, 0.2045], o, Z),
        ([0.0, 0.0, 0.2155], o, [0.0, -1.0, 0.0]),
        ([0.0, 0.0, 0.1845], o, Z),
        ([0.0, 0.0, 0.2155], o, Y),
        ([0.0, 0.0, 0.081], o, Z),
    ];
    same("iiwa14", &degrees, &urdf(&iiwa, ([0.0, 0.0, 0.045], o, Z), &radians));
    // xArm 6 with its axes at zero: z, y, y, -z, y (down the forearm), -z.
    let xarm: [Urdf; 6] = [
        ([0.0, 0.0, 0.267], o, Z),
        (o, o, Y),
        ([0.0535, 0.0, 0.2845], o, Y),
        ([0.0775, 0.0, -0.3425], o, [0.0, 0.0, -1.0]),
        (o, o, Y),
        ([0.076, 0.0, -0.097], o, [0.0, 0.0, -1.0]),
    ];
    same("xarm6", &degrees[..6], &urdf(&xarm, (o, [PI, 0.0, 0.0], Z), &radians));
    // ros-industrial: lrmate200id, seen from the controller's world frame; joint 3 of the URDF is J3 + J2.
    let fanuc: [Urdf; 6] = [
        (o, o, Z),
        ([0.050, 0.0, 0.0], o, Y),
        ([0.0, 0.0, 0.330], o, [0.0, -1.0, 0.0]),
        ([0.0, 0.0, 0.035], o, [-1.0, 0.0, 0.0]),
        ([0.335, 0.0, 0.0], o, [0.0, -1.0, 0.0]),
        ([0.080, 0.0, 0.0], o, [-1.0, 0.0, 0.0]),
    ];
    let mut angles = radians;
    angles[2] += angles[1];
    same("lrmate200id", &degrees[..6], &urdf(&fanuc, (o, [PI, -Q, 0.0], Z), &angles));
    // ros-industrial: irb120_3_58.
    let abb: [Urdf; 6] = [
        (o, o, Z),
        ([0.0, 0.0, 0.29], o, Y),
        ([0.0, 0.0, 0.27], o, Y),
        ([0.0, 0.0, 0.07], o, X),
        ([0.302, 0.0, 0.0], o, Y),
        ([0.072, 0.0, 0.0], o, X),
    ];
    same("irb120", &degrees[..6], &urdf(&abb, (o, [0.0, Q, 0.0], Z), &radians));
}

#[test]
fn words_that_are_near() {
    assert_eq!(Known::named("UR10e").map(|robot| robot.title()), Some("Universal Robots UR10e"));
    assert!(Known::named("ur9").is_none());
    assert_eq!(Known::near("iiwa"), ["iiwa7", "iiwa14"]);
    assert!(Known::near("ur9").contains(&"ur5e"));
    assert!(Known::near("kr6").contains(&"kr6-r900-2"));
    assert!(Known::near("zz").is_empty());
}
