//! Kinematics files of ROS descriptions: x y z roll pitch yaw of each joint, in m and rad about fixed axes.
//!
//! | style | structure | axes | joints |
//! | --- | --- | --- | --- |
//! | `ur` | `kinematics:` `shoulder:`, `upper_arm:`, …, and `hash:` | z | `shoulder_pan_joint`, … |
//! | `franka` | `joint1:` `kinematic:` … `joint8:` (the flange) | z | `joint1` … `joint7` |
//! | `flexiv` | `kinematics:` `joint1:` … `link7_to_flange:` | z y z y z y z | `joint1` … `joint7` |
//! | `xarm` | `kinematics:` `joint1:` … | z | `joint1` … |
//!
//! The files have no limits, masses or names, and no axes: a file of `joint1:` … without a maker's style is another maker's with other axes, unless
//! its dimensions are those of a Franka arm. A robot TOML states the axes of any (`kinematics_axes`). A key `truepose` at the top, which an export
//! adds, has style, base and tool.

use super::yaml_tree::{Node, Value};
use crate::IoError;
use crate::text::Text;
use crate::toml_tree::Table;
use std::f64::consts::FRAC_PI_2;
use std::path::{Path, PathBuf};
use truepose_kinematics::nalgebra::{Unit, Vector3};
use truepose_kinematics::{Chain, Joint, JointKind, Placed, Placement, Pose};

/// Keys of Universal Robots' links, and the joints in front of them.
const UR: [(&str, &str); 6] = [
    ("shoulder", "shoulder_pan_joint"),
    ("upper_arm", "shoulder_lift_joint"),
    ("forearm", "elbow_joint"),
    ("wrist_1", "wrist_1_joint"),
    ("wrist_2", "wrist_2_joint"),
    ("wrist_3", "wrist_3_joint"),
];

/// Words of the styles.
const STYLES: [&str; 4] = ["ur", "franka", "flexiv", "xarm"];

/// Words of axes.
const AXES: [(&str, [f64; 3]); 6] = [
    ("x", [1.0, 0.0, 0.0]),
    ("y", [0.0, 1.0, 0.0]),
    ("z", [0.0, 0.0, 1.0]),
    ("-x", [-1.0, 0.0, 0.0]),
    ("-y", [0.0, -1.0, 0.0]),
    ("-z", [0.0, 0.0, -1.0]),
];

/// Joints of a file, and where base and tool are if it states that.
struct Kinematics {
    name: String,
    joints: Vec<Joint>,
    base: Option<Pose>,
    tool: Option<Pose>,
}

/// Origins of Franka's arms (Panda, FER, FR3): x, y, z in m, roll in rad.
const FRANKA: [[f64; 4]; 7] = [
    [0.0, 0.0, 0.333, 0.0],
    [0.0, 0.0, 0.0, -FRAC_PI_2],
    [0.0, -0.316, 0.0, FRAC_PI_2],
    [0.0825, 0.0, 0.0, FRAC_PI_2],
    [-0.0825, 0.384, 0.0, -FRAC_PI_2],
    [0.0, 0.0, 0.0, FRAC_PI_2],
    [0.088, 0.0, 0.0, FRAC_PI_2],
];

/// Whether the dimensions are those of a Franka arm, but for what a calibration finds (m, rad).
fn is_franka(root: &Node) -> bool {
    let near = |number: usize, row: &[f64; 4]| -> Option<bool> {
        let of = root.get(&format!("joint{number}"))?.get("kinematic")?;
        let found = ["x", "y", "z", "roll"].map(|part| of.get(part).and_then(Node::number));
        Some(found.iter().zip(row).all(|(found, row)| found.is_some_and(|found| (found - row).abs() < 0.02)))
    };
    FRANKA.iter().enumerate().all(|(k, row)| near(k + 1, row) == Some(true))
}

/// What a robot TOML, or the caller, states of the joints of a file.
enum Stated<'a> {
    Nothing,
    Style(&'a str),
    Axes(Vec<Unit<Vector3<f64>>>),
}

/// Reads a file; a style that is given is not searched for.
fn read(path: &Path, joints_are: &Stated<'_>) -> Result<Kinematics, IoError> {
    let text = Text::read(path)?;
    let root = Node::parse(&text)?;
    let own = root.get("truepose");
    let inner = root.get("kinematics");
    let of = inner.unwrap_or(&root);
    let stated = match joints_are {
        Stated::Nothing => own.and_then(|own| own.get("style")).and_then(Node::word),
        Stated::Style(style) => Some(*style),
        Stated::Axes(_) => Some("kinematics"),
    };
    let style = match stated {
        Some(style) => style.to_owned(),
        None if of.get("shoulder").is_some() => "ur".into(),
        None if inner.is_none() && is_franka(&root) => "franka".into(),
        None if of.get("joint1").is_some() => {
            return Err(IoError::file(
                path,
                "is a kinematics file that states neither its maker nor the axes of its joints, and several makers write such files: name it in a \
                 robot TOML (`kinematics = \"…\"`) with `kinematics_style = \"flexiv\"`, \"xarm\" or \"franka\", or with the axis of each joint, as in \
                 `kinematics_axes = [\"z\", \"-x\", \"z\"]`",
            ));
        }
        None => {
            return Err(IoError::file(
                path,
                "is no kinematics file: it has neither `kinematics: shoulder:` nor `joint1:` (styles: ur, franka, flexiv, xarm)",
            ));
        }
    };
    let joints = match joints_are {
        Stated::Axes(axes) => of_axes(path, of, axes)?,
        _ => joints(path, of, &style)?,
    };
    let placed = |key: &str| own.and_then(|own| own.get(key)).map(|node| pose(path, key, node)).transpose();
    Ok(Kinematics { name: style, joints, base: placed("base")?, tool: placed("tool")? })
}

/// The joints in the order of the file, with the axes that were stated; those behind them do not move.
fn of_axes(path: &Path, of: &Node, axes: &[Unit<Vector3<f64>>]) -> Result<Vec<Joint>, IoError> {
    let Value::Mapping(entries) = &of.value else {
        return Err(IoError::line(path, of.line, "has no joints"));
    };
    let entries = entries.iter().map(|(name, node)| (name, node.get("kinematic").unwrap_or(node)));
    let entries: Vec<_> = entries.filter(|(_, node)| node.get("x").is_some()).collect();
    if axes.is_empty() || entries.len() < axes.len() {
        let words = format!("has {} joints, and `kinematics_axes` {}", entries.len(), axes.len());
        return Err(IoError::file(path, words));
    }
    let one = |(k, (name, node)): (usize, &(&String, &Node))| {
        let (kind, axis) = match axes.get(k) {
            Some(axis) => (JointKind::Revolute, *axis),
            None => (JointKind::Fixed, Vector3::z_axis()),
        };
        Ok(Joint::new((*name).clone(), kind, Placement::Origin { pose: pose(path, name, node)?, axis }))
    };
    entries.iter().enumerate().map(one).collect()
}

/// Name and joints of a file, and base and tool where it states them.
type Named = (Option<(String, Vec<Joint>)>, (Option<Placed>, Option<Placed>));

/// The file that a robot TOML names in place of its joints, if it names one.
pub(super) fn named(root: &Table<'_>, beside: impl Fn(&str) -> PathBuf) -> Result<Named, IoError> {
    let Some(file) = root.get("kinematics") else { return Ok((None, (None, None))) };
    if let Some(other) = root.get("urdf").or_else(|| root.get("joints")) {
        return Err(other.error("`kinematics` excludes `urdf` and [[joints]]; keep one of them"));
    }
    let found = beside(file.string()?);
    if !found.is_file() {
        let words = "the path counts from this file's folder";
        return Err(file.error(format!("there is no file `{}`; {words}", found.display())));
    }
    let stated = match (root.get("kinematics_style"), root.get("kinematics_axes")) {
        (Some(_), Some(axes)) => {
            return Err(axes.error("`kinematics_style` has its own axes; keep one of the two"));
        }
        (Some(style), None) => Stated::Style(style.word(&STYLES.map(|word| (word, word)))?),
        (None, Some(axes)) => {
            let words = AXES.map(|(word, [x, y, z])| (word, Unit::new_unchecked(Vector3::new(x, y, z))));
            let axes = axes.elements("an array of axes, as in [\"z\", \"-x\"]")?;
            Stated::Axes(axes.iter().map(|axis| axis.word(&words)).collect::<Result<_, _>>()?)
        }
        (None, None) => Stated::Nothing,
    };
    let Kinematics { name, joints, base, tool } = read(&found, &stated)?;
    let there = |pose: Option<Pose>| pose.map(|pose| Placed { pose, known: true });
    Ok((Some((name, joints)), (there(base), there(tool))))
}

/// Reads a kinematics file of a ROS description in the structure of a maker (`ur`, `franka`, `flexiv`, `xarm`) as a robot.
///
/// # Errors
/// When the file cannot be read, or has another structure.
pub fn read_kinematics(path: impl AsRef<Path>, style: &str) -> Result<Chain, IoError> {
    made(path.as_ref(), read(path.as_ref(), &Stated::Style(style))?)
}

/// The robot of a file.
pub(super) fn read_chain(path: &Path) -> Result<Chain, IoError> {
    made(path, read(path, &Stated::Nothing)?)
}

fn made(path: &Path, found: Kinematics) -> Result<Chain, IoError> {
    let Kinematics { name, joints, base, tool } = found;
    let placed = |pose: Option<Pose>| Placed { pose: pose.unwrap_or(Pose::IDENTITY), known: true };
    Chain::new(name, joints)
        .and_then(|chain| chain.with_base(placed(base)))
        .and_then(|chain| chain.with_tool(placed(tool)))
        .map_err(|error| IoError::file(path, error.to_string()))
}

fn joints(path: &Path, of: &Node, style: &str) -> Result<Vec<Joint>, IoError> {
    let entry = |key: &str| of.get(key).map(|node| node.get("kinematic").unwrap_or(node));
    let made = |key: &str, name: &str, axis: Unit<Vector3<f64>>, kind: JointKind| {
        entry(key)
            .map(|node| Ok(Joint::new(name, kind, Placement::Origin { pose: pose(path, key, node)?, axis })))
    };
    let (y, z) = (Vector3::y_axis(), Vector3::z_axis());
    let mut joints: Vec<Joint> = Vec::new();
    if style == "ur" {
        for (key, name) in UR {
            let joint = made(key, name, z, JointKind::Revolute);
            joints.push(joint.ok_or_else(|| IoError::file(path, format!("has no `{key}`")))??);
        }
        return Ok(joints);
    }
    // Franka's joint8 is the flange.
    let most = if style == "franka" { 7 } else { 16 };
    for number in 1..=most {
        let key = format!("joint{number}");
        let axis = if style == "flexiv" && number % 2 == 0 { y } else { z };
        match made(&key, &key, axis, JointKind::Revolute) {
            Some(joint) => joints.push(joint?),
            None => break,
        }
    }
    if joints.is_empty() {
        return Err(IoError::file(path, "has no `joint1`"));
    }
    for flange in ["joint8", "link7_to_flange"].into_iter().filter(|_| style != "xarm") {
        if !joints.iter().any(|joint| joint.name == flange) {
            joints.extend(made(flange, flange, z, JointKind::Fixed).transpose()?);
        }
    }
    Ok(joints)
}

fn pose(path: &Path, key: &str, node: &Node) -> Result<Pose, IoError> {
    if !matches!(node.value, Value::Mapping(_)) {
        return Err(IoError::line(path, node.line, format!("`{key}` needs x, y, z, roll, pitch, yaw")));
    }
    let number = |part: &str| {
        let found = node.get(part);
        let line = found.map_or(node.line, |found| found.line);
        let message = || match found {
            None => format!("`{key}` has no `{part}`"),
            Some(found) => match found.word() {
                Some(word) => format!("`{part}` of `{key}` is `{word}`, not a number"),
                None => format!("`{part}` of `{key}` is not a number"),
            },
        };
        found.and_then(Node::number).ok_or_else(|| IoError::line(path, line, message()))
    };
    let xyz = [number("x")?, number("y")?, number("z")?];
    let rpy = [number("roll")?, number("pitch")?, number("yaw")?];
    // No arm has links of a kilometre: a file in mm, or none at all.
    if let Some(value) = xyz.iter().find(|value| value.abs() > 100.0) {
        return Err(IoError::line(path, node.line, format!("`{key}` is {value} m away; lengths are in m")));
    }
    Ok(Pose::from_xyz_rpy(xyz, rpy))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn chain(text: &str) -> Result<Chain, String> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("k.yaml");
        std::fs::write(&path, text).unwrap();
        let name = format!("{}/", folder.path().display());
        read_chain(&path).map_err(|error| error.to_string().replace(&name, ""))
    }

    #[test]
    fn structures_of_the_makers_are_read() {
        let joint = |x: f64| format!("{{x: {x}, y: 0, z: 0.5, roll: 0, pitch: -0, yaw: 1.5e-1}}");
        let keys = ["shoulder", "upper_arm", "forearm", "wrist_1", "wrist_2", "wrist_3"];
        let ur: String = keys.iter().map(|key| format!("  {key}: {}\n", joint(0.1))).collect();
        let ur = chain(&format!("kinematics:\n{ur}  hash: calib_123\n")).unwrap();
        assert_eq!((ur.movable().len(), ur.joints()[2].name.as_str()), (6, "elbow_joint"));
        let seven = |indent: &str, inner: &str| -> String {
            (1..=7)
                .map(|k| format!("{indent}joint{k}:\n{indent}  {inner}{}\n", joint(k as f64 / 10.0)))
                .collect()
        };
        // The structure is that of several makers: without the dimensions of one it is nobody's.
        let unknown = format!("{}joint8:\n  kinematic: {}\n", seven("", "kinematic: "), joint(0.0));
        let refused = chain(&unknown).unwrap_err();
        assert!(refused.contains("kinematics_style") && refused.contains("kinematics_axes"), "{refused}");
        let franka = chain(&(unknown + "truepose: {style: franka}\n")).unwrap();
        assert_eq!((franka.movable().len(), franka.joints().len()), (7, 8));
        let row = |(k, [x, y, z, roll]): (usize, &[f64; 4])| {
            let (x, roll) = (x + 3e-4, roll - 2e-3);
            format!(
                "joint{}: {{kinematic: {{x: {x}, y: {y}, z: {z}, roll: {roll}, pitch: 0, yaw: 1e-3}}}}\n",
                k + 1
            )
        };
        let calibrated: String = FRANKA.iter().enumerate().map(row).collect();
        assert_eq!(chain(&calibrated).unwrap().name(), "franka");
        let flexiv = "kinematics:\n".to_owned() + &seven("  ", "").replace(":\n    {", ": {");
        assert!(chain(&flexiv).unwrap_err().contains("kinematics_style"));
        let flexiv = chain(&(flexiv + "truepose: {style: flexiv}\n")).unwrap();
        let axis = |k: usize| match flexiv.joints()[k].placement {
            Placement::Origin { axis, .. } => axis.into_inner(),
            _ => Vector3::zeros(),
        };
        assert_eq!((axis(0), axis(1)), (Vector3::z(), Vector3::y()));
    }

    /// A file of nobody's structure, with the axes of its joints in the robot's own file.
    #[test]
    fn axes_that_are_stated_are_those_of_the_joints() {
        let folder = tempfile::tempdir().unwrap();
        let entry = |name: &str, z: f64| {
            format!("{name}:\n  kinematic: {{x: 0.1, y: 0, z: {z}, roll: 0, pitch: 0, yaw: 0}}\n")
        };
        let yaml = entry("waist", 0.2) + &entry("arm", 0.3) + &entry("hand", 0.4);
        std::fs::write(folder.path().join("k.yaml"), yaml).unwrap();
        let read = |axes: &str| {
            let text = format!("name = \"one\"\nkinematics = \"k.yaml\"\nkinematics_axes = {axes}\n");
            let path = folder.path().join("robot.toml");
            std::fs::write(&path, text).unwrap();
            crate::read_robot(&path, &crate::RobotOptions::default())
                .map(|read| read.0)
                .map_err(|e| e.to_string())
        };
        let chain = read("[\"z\", \"-x\"]").unwrap();
        assert_eq!((chain.movable().len(), chain.joints()[2].name.as_str()), (2, "hand"));
        // A quarter of a turn about −x takes z to y: 0.4 m of the hand are along y.
        let at = chain.forward(&[0.0, FRAC_PI_2]).translation;
        assert!((at - Vector3::new(0.3, 0.4, 0.5)).norm() < 1e-12, "{at}");
        assert!(read("[\"z\", \"w\"]").unwrap_err().contains("cannot be `w`"));
        assert!(read("[\"z\", \"z\", \"z\", \"z\"]").unwrap_err().contains("has 3 joints"));
    }

    #[test]
    fn what_is_wrong_is_reported_with_its_line() {
        assert_eq!(
            chain("kinematics:\n  shoulder:\n    x: 0\n    y: a\n    z: 0\n").unwrap_err(),
            "k.yaml:4: `y` of `shoulder` is `a`, not a number"
        );
        assert!(chain("kinematics: &a\n  shoulder: *a\n").unwrap_err().contains("refers to another place"));
        assert!(chain("a: [1, 2").unwrap_err().starts_with("k.yaml:"));
        assert!(chain("").unwrap_err().contains("is empty"));
        assert!(chain("a: 1\na: 2\n").unwrap_err().contains("twice"));
        assert!(chain(&"[".repeat(100_000)).is_err());
    }
}
