//! Kinematics files of ROS descriptions: x y z roll pitch yaw of each joint, in m and rad about fixed axes.
//!
//! | style | structure | axes | joints |
//! | --- | --- | --- | --- |
//! | `ur` | `kinematics:` `shoulder:`, `upper_arm:`, …, and `hash:` | z | `shoulder_pan_joint`, … |
//! | `franka` | `joint1:` `kinematic:` … `joint8:` (the flange) | z | `joint1` … `joint7` |
//! | `flexiv` | `kinematics:` `joint1:` … `link7_to_flange:` | z y z y z y z | `joint1` … `joint7` |
//! | `xarm` | `kinematics:` `joint1:` … | z | `joint1` … |
//!
//! The files have no limits, masses or names. A key `truepose` at the top, which an export adds, has style, base and tool.

use super::yaml_tree::{Node, Value};
use crate::IoError;
use crate::text::Text;
use crate::toml_tree::Table;
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

/// Joints of a file, and where base and tool are if it states that.
struct Kinematics {
    name: String,
    joints: Vec<Joint>,
    base: Option<Pose>,
    tool: Option<Pose>,
}

/// Reads a file; a style that is given is not searched for.
fn read(path: &Path, style: Option<&str>) -> Result<Kinematics, IoError> {
    let text = Text::read(path)?;
    let root = Node::parse(&text)?;
    let own = root.get("truepose");
    let stated = own.and_then(|own| own.get("style")).and_then(Node::word);
    let inner = root.get("kinematics");
    let of = inner.unwrap_or(&root);
    let style = match style.or(stated) {
        Some(style) => style.to_owned(),
        None if of.get("shoulder").is_some() => "ur".into(),
        None if inner.is_none()
            && root.get("joint1").is_some_and(|joint| joint.get("kinematic").is_some()) =>
        {
            "franka".into()
        }
        None if of.get("joint1").is_some() => {
            return Err(IoError::file(
                path,
                "is a kinematics file of Flexiv or of UFACTORY, which differ in their axes: name it in a robot TOML, with \
                 `kinematics_style = \"flexiv\"` or \"xarm\"",
            ));
        }
        None => {
            return Err(IoError::file(
                path,
                "is no kinematics file: it has neither `kinematics: shoulder:` nor `joint1:` (styles: ur, franka, flexiv, xarm)",
            ));
        }
    };
    let joints = joints(path, of, &style)?;
    let placed = |key: &str| own.and_then(|own| own.get(key)).map(|node| pose(path, key, node)).transpose();
    Ok(Kinematics { name: style, joints, base: placed("base")?, tool: placed("tool")? })
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
    let style = match root.get("kinematics_style") {
        Some(value) => Some(value.word(&STYLES.map(|word| (word, word)))?),
        None => None,
    };
    let Kinematics { name, joints, base, tool } = read(&found, style)?;
    let there = |pose: Option<Pose>| pose.map(|pose| Placed { pose, known: true });
    Ok((Some((name, joints)), (there(base), there(tool))))
}

/// Reads a kinematics file of a ROS description in the structure of a maker (`ur`, `franka`, `flexiv`, `xarm`) as a robot.
///
/// # Errors
/// When the file cannot be read, or has another structure.
pub fn read_kinematics(path: impl AsRef<Path>, style: &str) -> Result<Chain, IoError> {
    made(path.as_ref(), read(path.as_ref(), Some(style))?)
}

/// The robot of a file.
pub(super) fn read_chain(path: &Path) -> Result<Chain, IoError> {
    made(path, read(path, None)?)
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
        let franka = format!("{}joint8:\n  kinematic: {}\n", seven("", "kinematic: "), joint(0.0));
        let franka = chain(&franka).unwrap();
        assert_eq!((franka.movable().len(), franka.joints().len()), (7, 8));
        let flexiv = "kinematics:\n".to_owned() + &seven("  ", "").replace(":\n    {", ": {");
        assert!(chain(&flexiv).unwrap_err().contains("kinematics_style"));
        let flexiv = chain(&(flexiv + "truepose: {style: flexiv}\n")).unwrap();
        let axis = |k: usize| match flexiv.joints()[k].placement {
            Placement::Origin { axis, .. } => axis.into_inner(),
            _ => Vector3::zeros(),
        };
        assert_eq!((axis(0), axis(1)), (Vector3::z(), Vector3::y()));
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
