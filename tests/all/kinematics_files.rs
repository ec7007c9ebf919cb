//! Kinematics files of ROS descriptions: read as robots, exported with errors in every structure, and read again.

#![expect(clippy::approx_constant, reason = "makers round their angles, and the files have their digits")]

use nalgebra::{DMatrix, Vector3};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use truepose_compensate::{CompensateError, ExportOptions, RosStyle, StyledOrigins, joint_origins};
use truepose_errormodel::effects::Geometric;
use truepose_errormodel::{ErrorModel, FittedModel, Schema};
use truepose_io::{RobotOptions, read_kinematics, read_robot};
use truepose_kinematics::{Chain, Conditions, Joint, JointKind, Placed, Placement, Pose, samples};

/// x y z roll pitch yaw, as makers publish them.
type Row = [f64; 6];

const Q: f64 = std::f64::consts::FRAC_PI_2;
const PI: f64 = std::f64::consts::PI;

const UR10: [Row; 6] = [
    [0.0, 0.0, 0.1273, 0.0, 0.0, 0.0],
    [0.0, 0.0, 0.0, 1.570796327, 0.0, 0.0],
    [-0.612, 0.0, 0.0, 0.0, 0.0, 0.0],
    [-0.5723, 0.0, 0.163941, 0.0, 0.0, 0.0],
    [0.0, -0.1157, 0.0, 1.570796327, 0.0, 0.0],
    [0.0, 0.0922, 0.0, Q, PI, PI],
];
const FR3: [Row; 8] = [
    [0.0, 0.0, 0.333, 0.0, 0.0, 0.0],
    [0.0, 0.0, 0.0, -Q, 0.0, 0.0],
    [0.0, -0.316, 0.0, Q, 0.0, 0.0],
    [0.0825, 0.0, 0.0, Q, 0.0, 0.0],
    [-0.0825, 0.384, 0.0, -Q, 0.0, 0.0],
    [0.0, 0.0, 0.0, Q, 0.0, 0.0],
    [0.088, 0.0, 0.0, Q, 0.0, 0.0],
    [0.0, 0.0, 0.107, 0.0, 0.0, 0.0],
];
const RIZON4: [Row; 7] = [
    [0.0, 0.0, 0.155, 0.0, 0.0, -3.141592654],
    [0.0, 0.03, 0.21, 0.0, 0.0, 0.0],
    [0.0, 0.035, 0.205, 0.0, 0.0, 0.0],
    [-0.02, -0.03, 0.19, 0.0, 0.0, -3.141592654],
    [-0.02, 0.025, 0.195, 0.0, 0.0, -3.141592654],
    [0.0, 0.03, 0.19, 0.0, 0.0, 0.0],
    [-0.015, 0.073, 0.11, 0.0, -1.570796327, 0.0],
];
const XARM7: [Row; 7] = [
    [0.0, 0.0, 0.267, 0.0, 0.0, 0.0],
    [0.0, 0.0, 0.0, -1.5708, 0.0, 0.0],
    [0.0, -0.293, 0.0, 1.5708, 0.0, 0.0],
    [0.0525, 0.0, 0.0, 1.5708, 0.0, 0.0],
    [0.0775, -0.3425, 0.0, 1.5708, 0.0, 0.0],
    [0.0, 0.0, 0.0, 1.5708, 0.0, 0.0],
    [0.076, 0.097, 0.0, -1.5708, 0.0, 0.0],
];
const UR_KEYS: [&str; 6] = ["shoulder", "upper_arm", "forearm", "wrist_1", "wrist_2", "wrist_3"];

/// The maker's file.
fn published(style: RosStyle) -> String {
    let rows: &[Row] = match style {
        RosStyle::Ur => &UR10,
        RosStyle::Franka => &FR3,
        RosStyle::Flexiv => &RIZON4,
        RosStyle::XArm => &XARM7,
    };
    let mut text = String::from(if style == RosStyle::Franka { "" } else { "kinematics:\n" });
    for (k, row) in rows.iter().enumerate() {
        let key = if style == RosStyle::Ur { UR_KEYS[k].to_owned() } else { format!("joint{}", k + 1) };
        text += &if style == RosStyle::Franka {
            format!("{key}:\n  kinematic:\n")
        } else {
            format!("  {key}:\n")
        };
        for (name, value) in ["x", "y", "z", "roll", "pitch", "yaw"].iter().zip(row) {
            text += &format!("    {name}: {value}\n");
        }
    }
    if style == RosStyle::Ur {
        text += "  hash: calib_12788084448423163542\n";
    }
    text
}

const STYLES: [RosStyle; 4] = [RosStyle::Ur, RosStyle::Franka, RosStyle::Flexiv, RosStyle::XArm];

/// The maker's robot: named in a TOML, on a base and with a tool.
fn maker(folder: &std::path::Path, style: RosStyle) -> Chain {
    std::fs::write(folder.join("maker.yaml"), published(style)).expect("a file");
    let toml = format!(
        "name = \"{0}\"\nkinematics = \"maker.yaml\"\nkinematics_style = \"{0}\"\n[base]\nxyz = [1.0, 0.2, 0.1]\nrpy = [0.1, 0.0, 0.7]\n\
         [tool]\nxyz = [0.02, 0.0, 0.15]\n",
        style.word()
    );
    std::fs::write(folder.join("robot.toml"), toml).expect("a file");
    read_robot(folder.join("robot.toml"), &RobotOptions::default()).expect("a robot").0
}

/// Constant errors of every frame: 0.3 mm and 0.3 mrad.
fn fitted(chain: &Chain, size: f64) -> FittedModel {
    let model = ErrorModel::new(chain.clone(), vec![Box::new(Geometric::default())]).expect("a model");
    let mut draw = ChaCha8Rng::seed_from_u64(5);
    let count = model.columns().len();
    let values = (0..count).map(|_| size * draw.random_range(-1.0..1.0)).collect();
    FittedModel::new(model, values, DMatrix::zeros(count, count)).expect("a fit")
}

fn styled(
    fit: &FittedModel,
    style: RosStyle,
    like: Option<&Chain>,
) -> Result<StyledOrigins, CompensateError> {
    joint_origins(fit, &ExportOptions::default())?.value.styled(style, fit.chain(), like)
}

/// Reads the exported file as a robot and compares poses with the fit.
#[track_caller]
fn check_poses(folder: &std::path::Path, fit: &FittedModel, text: &str) {
    check_poses_within(folder, fit, text, 1e-9);
}

/// The same within m and rad.
#[track_caller]
fn check_poses_within(folder: &std::path::Path, fit: &FittedModel, text: &str, most: f64) {
    let file = folder.join("exported.yaml");
    std::fs::write(&file, text).expect("a file");
    let again = read_robot(&file, &RobotOptions::default()).expect("a robot").0;
    let mut real = fit.bind(&Schema::default()).expect("a predictor");
    let mut draw = ChaCha8Rng::seed_from_u64(8);
    for _ in 0..100 {
        let q: Vec<f64> = (0..again.movable().len()).map(|_| draw.random_range(-3.0..3.0)).collect();
        let (a, b) = (again.forward(&q), real.predict(&Conditions::at(fit.chain(), &q), None));
        let (off, turned) = ((a.translation - b.translation).norm(), (a.rotation - b.rotation).amax());
        assert!(off < most && turned < most, "{}: {off:e} m, {turned:e} rad\n{text}", fit.chain().name());
    }
}

#[test]
fn every_structure_is_read_again_with_the_same_poses() {
    for style in STYLES {
        let folder = tempfile::tempdir().expect("a folder");
        let chain = maker(folder.path(), style);
        let fit = fitted(&chain, 3e-4);
        let like = read_kinematics(folder.path().join("maker.yaml"), style.word()).expect("a robot");
        for like in [None, Some(&like)] {
            let found = styled(&fit, style, like).expect("origins");
            check_poses(folder.path(), &fit, &found.to_yaml(None, &["from a test".into()]));
            // Near the maker's own numbers: no common normal is far away.
            let size = chain.characteristic_length();
            assert!(found.joints.iter().all(|pose| pose.translation.norm() < 2.0 * size));
        }
        // Without errors the link frames are the maker's.
        let none = styled(&fitted(&chain, 0.0), style, Some(&like)).expect("origins");
        for (pose, joint) in none.joints.iter().zip(like.joints()) {
            let published = joint.transform(0.0);
            assert!((pose.translation - published.translation).norm() < 1e-9, "{style:?} {}", joint.name);
            assert!((pose.rotation - published.rotation).amax() < 1e-9, "{style:?} {}", joint.name);
        }
    }
}

#[test]
fn a_robot_in_dh_gets_the_link_frames_of_the_makers_file() {
    let folder = tempfile::tempdir().expect("a folder");
    let chain = samples::ur10();
    std::fs::write(folder.path().join("maker.yaml"), published(RosStyle::Ur)).expect("a file");
    let like = read_kinematics(folder.path().join("maker.yaml"), "ur").expect("a robot");
    let fit = fitted(&chain, 3e-4);
    let found = styled(&fit, RosStyle::Ur, Some(&like)).expect("origins");
    check_poses(folder.path(), &fit, &found.to_yaml(None, &[]));
    let far = found
        .joints
        .iter()
        .zip(like.joints())
        .map(|(pose, joint)| (pose.translation - joint.transform(0.0).translation).norm());
    assert!(far.fold(0.0, f64::max) < 5e-3, "the frames are near the maker's");
    // Nothing else is done about frames without the file, and the text says so.
    let plain = styled(&fit, RosStyle::Ur, None).expect("origins");
    check_poses(folder.path(), &fit, &plain.to_yaml(None, &[]));
    assert!(plain.to_yaml(None, &[]).contains("--like") && !found.to_yaml(None, &[]).contains("--like"));
}

/// The arm of a factory calibration in rows of Denavit and Hartenberg, with parallel axes that are tilted by a milliradian and their nearest points far
/// away: the file has lengths of an arm, near those of the maker, with and without the maker's own file.
#[test]
fn a_calibrated_robot_in_dh_has_frames_near_the_makers() {
    let folder = tempfile::tempdir().expect("a folder");
    std::fs::write(folder.path().join("maker.yaml"), published(RosStyle::Ur)).expect("a file");
    let like = read_kinematics(folder.path().join("maker.yaml"), "ur").expect("a robot");
    let row = |k: usize, [theta, d, a, alpha]: [f64; 4]| {
        let placement = Placement::Dh { theta, d, a, alpha };
        Joint::new(like.joints()[k].name.clone(), JointKind::Revolute, placement)
    };
    // Of UR10 with 1 mm and 1 mrad, by the common normals of its axes: a far third of the lengths is between them.
    let rows = calibrated_rows();
    let joints = rows.iter().enumerate().map(|(k, numbers)| row(k, *numbers)).collect();
    let chain = Chain::new("calibrated", joints).expect("a robot");
    assert!(rows.iter().any(|row| row[1].abs() > 50.0), "{rows:?}");
    // Errors of the frames far away have long levers.
    let fit = fitted(&chain, 1e-7);
    for like_given in [None, Some(&like)] {
        let found = styled(&fit, RosStyle::Ur, like_given).expect("origins");
        check_poses_within(folder.path(), &fit, &found.to_yaml(None, &[]), 1e-8);
        for (pose, joint) in found.joints.iter().zip(like.joints()) {
            let published = joint.transform(0.0);
            let off = (pose.translation - published.translation).norm();
            let turned = (pose.rotation - published.rotation).amax();
            assert!(off < 5e-3 && turned < 5e-3, "{}: {off} m, {turned}", joint.name);
        }
        let remarks = found.remarks.concat();
        assert!(remarks.contains(if like_given.is_some() { "constants of a calibration" } else { "--like" }));
    }
}

/// Rows of Denavit and Hartenberg of UR10 whose axes 2, 3 and 4 are tilted: worked out here from points and directions of the axes.
fn calibrated_rows() -> [[f64; 4]; 6] {
    let v = Vector3::new;
    // Axes of UR10 at zero, each moved by a millimetre or so, the parallel ones tilted by about a milliradian.
    let axes = [
        (v(0.0, 0.0, 0.0), v(0.0, 0.0, 1.0)),
        (v(0.0003, 0.0, 0.1278), v(0.0002, -1.0, -0.0001)),
        (v(-0.6125, 0.0, 0.1275), v(0.0009, -1.0, 0.0011)),
        (v(-1.1840, 0.0, 0.1268), v(-0.0004, -1.0, 0.0006)),
        (v(-1.1842, -0.1643, 0.0), v(0.0004, 0.0003, -1.0)),
        (v(-1.1845, 0.0, 0.0112), v(0.0001, -1.0, -0.0002)),
    ];
    let axes = axes.map(|(point, direction): (Vector3<f64>, Vector3<f64>)| (point, direction.normalize()));
    let mut rows = [[0.0; 4]; 6];
    // The frame in front of joint k: z along its axis, x along the common normal of the axis before and this one.
    let (mut x, mut at) = (v(1.0, 0.0, 0.0), axes[0].0);
    for k in 0..6 {
        let (point, z) = axes[k];
        let (next, toward) = axes.get(k + 1).copied().unwrap_or((at + z * 0.0922, z));
        let across = z.cross(&toward);
        let (normal, foot, end) = if k == 5 {
            (x, next, next)
        } else {
            let s = (next - point).cross(&toward).dot(&across) / across.norm_squared();
            let t = (next - point).cross(&z).dot(&across) / across.norm_squared();
            (across.normalize(), point + z * s, next + toward * t)
        };
        let theta = x.cross(&normal).dot(&z).atan2(x.dot(&normal));
        let alpha = across.dot(&normal).atan2(z.dot(&toward));
        rows[k] = [theta, (foot - at).dot(&z), (end - foot).dot(&normal), alpha];
        (x, at) = (normal, end);
    }
    rows
}

#[test]
fn the_hash_is_never_that_of_the_controller_by_itself() {
    let folder = tempfile::tempdir().expect("a folder");
    let chain = maker(folder.path(), RosStyle::Ur);
    let found = styled(&fitted(&chain, 3e-4), RosStyle::Ur, None).expect("origins");
    let text = found.to_yaml(None, &[]);
    assert!(
        !text.contains("calib_")
            && text.contains("  hash: truepose_")
            && text.contains("controller still has the maker's")
    );
    assert_eq!(text, styled(&fitted(&chain, 3e-4), RosStyle::Ur, None).expect("origins").to_yaml(None, &[]));
    assert_ne!(text, styled(&fitted(&chain, 2e-4), RosStyle::Ur, None).expect("origins").to_yaml(None, &[]));
    assert!(found.to_yaml(Some("calib_1"), &[]).contains("\n  hash: calib_1\n"));
    let keys: Vec<&str> =
        text.lines().filter(|l| l.starts_with("  ") && !l.starts_with("   ") && l.ends_with(':')).collect();
    assert_eq!(
        keys[..6],
        ["  shoulder:", "  upper_arm:", "  forearm:", "  wrist_1:", "  wrist_2:", "  wrist_3:"]
    );
}

#[test]
fn another_robot_than_the_makers_is_refused() {
    let folder = tempfile::tempdir().expect("a folder");
    let chain = maker(folder.path(), RosStyle::Ur);
    let like = read_kinematics(folder.path().join("maker.yaml"), "ur").expect("a robot");
    let refused = |chain: Chain, style, like| {
        styled(&fitted(&chain, 3e-4), style, like).expect_err("refused").to_string()
    };
    assert!(refused(samples::scara(), RosStyle::Ur, None).contains("style ur"));
    assert!(refused(samples::seven(), RosStyle::Ur, None).contains("style ur"));
    assert!(refused(samples::heavy(), RosStyle::Ur, Some(&like)).contains("axis of joint"));
    // A base that is turned by a half turn, as between ROS and the controller.
    let mut joints = chain.joints().to_vec();
    if let Placement::Origin { pose, .. } = &mut joints[0].placement {
        *pose = Pose::rot(0, PI) * *pose;
    }
    let other =
        Chain::new("other", joints).and_then(|c| c.with_base(Placed { pose: Pose::IDENTITY, known: true }));
    assert!(refused(other.expect("a robot"), RosStyle::Ur, Some(&like)).contains("axis of joint 1"));
}
