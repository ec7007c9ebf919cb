//! A URDF with other joint origins: the numbers of the origins change, and not another byte of what was there.
//!
//! What is added is a comment behind `<robot …>`, an `<origin>` where a joint had none, and, where the tool has moved against the tip link,
//! a link behind it with a fixed joint, at the file's end.

use super::names::unprintable;
use super::urdf_text::{Urdf, UrdfJoint};
use crate::IoError;
use crate::text::Text;
use std::fmt::Write;
use std::ops::Range;
use std::path::Path;
use truepose_kinematics::{Chain, JointId, Placement, Pose};

/// What is put into a URDF.
#[derive(Debug, Clone, PartialEq)]
pub struct UrdfCorrection {
    /// The corrected origin of each joint of the chain, fixed ones included.
    pub origins: Vec<Pose>,
    /// The pose between the last joint's frame and the nominal tool: the corrected tool's pose times the inverse of the
    /// nominal one. The identity changes nothing.
    pub behind: Pose,
    /// Lines of a comment.
    pub comment: Vec<String>,
}

/// The link that is added behind the tip link.
const ADDED_LINK: &str = "truepose_tip";
const ADDED_JOINT: &str = "truepose_correction";

/// Nominal origins that differ by more, in m or in a rotation's entry, are those of another robot.
const SAME: f64 = 1e-9;

/// The text of a URDF with corrected origins.
///
/// # Errors
/// When the file cannot be read or is no URDF, or its joints are not those of the chain: with file, line and column.
pub fn corrected_urdf(
    path: impl AsRef<Path>,
    nominal: &Chain,
    correction: &UrdfCorrection,
) -> Result<String, IoError> {
    let text = Text::read(path.as_ref())?;
    let robot = Urdf::read(&text)?;
    if correction.origins.len() != nominal.joints().len() {
        let (have, need) = (correction.origins.len(), nominal.joints().len());
        return Err(IoError::file(path.as_ref(), format!("{have} origins are given for {need} joints")));
    }
    let mut edits = vec![Edit { at: robot.opened..robot.opened, with: comment(&correction.comment) }];
    // Link behind each joint.
    let mut links: Vec<&str> = Vec::with_capacity(nominal.joints().len());
    for (index, (joint, corrected)) in nominal.joints().iter().zip(&correction.origins).enumerate() {
        let Some(found) = robot.joints.iter().find(|described| described.name == joint.name) else {
            return Err(
                text.error(robot.at, format!("has no joint `{}`, which the fit's robot has", joint.name))
            );
        };
        let refused = |message: String| text.error(found.at, format!("joint `{}` {message}", joint.name));
        let before = nominal.before(JointId(index + 1)).0.checked_sub(1);
        if before.is_some_and(|k| links.get(k).is_none_or(|link| *link != found.parent)) {
            return Err(refused("does not follow the joint in front of it in the fit's robot".into()));
        }
        links.push(&found.child);
        let Placement::Origin { pose, axis } = joint.placement else {
            return Err(refused(
                "is described in the fit's robot by a row of Denavit and Hartenberg, not by this URDF".into(),
            ));
        };
        let here = found.origin;
        if axis.iter().zip(found.axis).map(|(a, b)| a * b).sum::<f64>() < 0.0 {
            return Err(refused("leads the other way in the fit's robot: a joint that is read backwards is not corrected in the URDF".into()));
        }
        let (off, turned) =
            ((here.translation - pose.translation).amax(), (here.rotation - pose.rotation).amax());
        if off.max(turned) > SAME {
            return Err(refused(format!(
                "has another origin than in the fit's robot, by {off:.1e} m and {turned:.1e}: give the URDF that the fit was made from"
            )));
        }
        edit_origin(found, &pose, corrected, &mut edits);
    }
    // The tip link is the robot's own, and stays where it is: what is found of the tool is in a link of its own.
    if correction.behind != Pose::IDENTITY {
        let link =
            robot.links.iter().find(|link| link.name == ADDED_LINK).map(|link| ("link", ADDED_LINK, link.at));
        let joint = robot.joints.iter().find(|joint| joint.name == ADDED_JOINT);
        let joint = joint.map(|joint| ("joint", ADDED_JOINT, joint.at));
        if let Some((kind, name, at)) = link.or(joint) {
            return Err(text.error(at, format!("has a {kind} `{name}` already: give the original file")));
        }
        let end = text.text.rfind("</robot").unwrap_or(text.text.len());
        edits.push(Edit {
            at: end..end,
            with: added(links.last().copied().unwrap_or_default(), &correction.behind),
        });
    }
    Ok(edited(&text.text, edits))
}

/// A piece of the text, and its replacement.
struct Edit {
    at: Range<usize>,
    with: String,
}

fn edited(text: &str, mut edits: Vec<Edit>) -> String {
    edits.sort_by_key(|edit| edit.at.start);
    let mut out = String::with_capacity(text.len() + 1000);
    let mut from = 0;
    for edit in edits {
        out.push_str(&text[from..edit.at.start]);
        out.push_str(&edit.with);
        from = edit.at.end;
    }
    out.push_str(&text[from..]);
    out
}

/// The edits that turn the origin of a joint into another; numbers that stay are left as they are written.
fn edit_origin(joint: &UrdfJoint, from: &Pose, to: &Pose, edits: &mut Vec<Edit>) {
    let triple = |v: [f64; 3]| v.map(|x| format!("{x:?}")).join(" ");
    let (xyz, rpy) = (triple(to.translation.into()), triple(to.rpy()));
    let moved = from.translation != to.translation;
    let turned = from.rotation != to.rotation;
    if !moved && !turned {
        return;
    }
    let Some(origin) = &joint.written else {
        let at = joint.opened..joint.opened;
        edits.push(Edit { at, with: format!("<origin xyz=\"{xyz}\" rpy=\"{rpy}\"/>") });
        return;
    };
    let mut put = |value: &Option<Range<usize>>, name: &str, with: String| match value {
        Some(at) => edits.push(Edit { at: at.clone(), with }),
        None => edits.push(Edit { at: origin.named..origin.named, with: format!(" {name}=\"{with}\"") }),
    };
    if moved {
        put(&origin.xyz, "xyz", xyz);
    }
    match &origin.quat_xyzw {
        _ if !turned => {}
        Some(at) => edits.push(Edit { at: at.clone(), with: format!("rpy=\"{rpy}\"") }),
        None => put(&origin.rpy, "rpy", rpy),
    }
}

/// A text of characters that XML 1.0 has; those that it has not are replaced.
pub(super) fn xml(text: &str) -> String {
    let none = |c: char| (c.is_control() && !matches!(c, '\t' | '\n')) || unprintable(c);
    text.chars().map(|c| if none(c) { '\u{fffd}' } else { c }).collect()
}

pub(super) fn comment(lines: &[String]) -> String {
    if lines.is_empty() {
        return String::new();
    }
    let mut out = String::from("\n<!--\n");
    for line in lines {
        // Two hyphens would end it.
        let mut safe = xml(line).replace("--", "- -");
        while safe.contains("--") {
            safe = safe.replace("--", "- -");
        }
        let _ = writeln!(out, "  {safe}");
    }
    out + "-->"
}

fn added(parent: &str, behind: &Pose) -> String {
    let triple = |v: [f64; 3]| v.map(|x| format!("{x:?}")).join(" ");
    let (xyz, rpy) = (triple(behind.translation.into()), triple(behind.rpy()));
    format!(
        "<link name=\"{ADDED_LINK}\"/>\n<joint name=\"{ADDED_JOINT}\" type=\"fixed\"><origin xyz=\"{xyz}\" rpy=\"{rpy}\"/>\
         <parent link=\"{parent}\"/><child link=\"{ADDED_LINK}\"/></joint>\n"
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{RobotOptions, read_robot};

    const ARM: &str = r#"<?xml version="1.0"?>
<robot name="arm">
<ros2_control name="c" type="system"><joint name="j1"><origin/></joint></ros2_control>
<link name="base"/><link name="l1"/><link name="l2"/><link name="l3"/><!-- <joint name="j2"/> -->
<joint name='j1' type='revolute'><origin rpy='0 0 0.5'   xyz='0 0 3e-1'/><parent link="base"/><child link="l1"/><axis xyz="0 0 1"/>
<limit lower="-3" upper="2" effort="1" velocity="1"/></joint>
<joint name="j2" type="continuous"><parent link="l1"/><child link="l2"/><axis xyz="0 1 0"/></joint>
<joint name="j3" type="prismatic"><origin xyz="0.1 0 0"/><parent link="l2"/><child link="l3"/><axis xyz="0 0 -1"/>
<limit lower="0" upper="0.5" effort="1" velocity="1"/></joint>
</robot>
"#;

    fn nominal(folder: &Path, text: &str) -> Chain {
        std::fs::write(folder.join("a.urdf"), text).unwrap();
        read_robot(folder.join("a.urdf"), &RobotOptions::default()).unwrap().0
    }

    fn origins(chain: &Chain) -> Vec<Pose> {
        chain.joints().iter().map(|joint| joint.transform(0.0)).collect()
    }

    #[test]
    fn nothing_changes_without_a_correction() {
        let folder = tempfile::tempdir().unwrap();
        let chain = nominal(folder.path(), ARM);
        let correction = UrdfCorrection { origins: origins(&chain), behind: Pose::IDENTITY, comment: vec![] };
        assert_eq!(corrected_urdf(folder.path().join("a.urdf"), &chain, &correction).unwrap(), ARM);
    }

    #[test]
    fn only_the_numbers_of_the_origins_change() {
        let folder = tempfile::tempdir().unwrap();
        let chain = nominal(folder.path(), ARM);
        let mut corrected = origins(&chain);
        let small = Pose::from_xyz_rpy([1e-4, -2e-4, 3e-4], [1e-3, 2e-3, -1e-3]);
        corrected[0].translation.z += 1e-3;
        corrected[1] = corrected[1] * small;
        corrected[2] = corrected[2] * small;
        let correction =
            UrdfCorrection { origins: corrected.clone(), behind: small, comment: vec!["a -- b".into()] };
        let text = corrected_urdf(folder.path().join("a.urdf"), &chain, &correction).unwrap();
        // Taken out again, what is left is the original.
        let (xyz, rpy) = (
            "0.0001 -0.0002 0.0003",
            format!("{:?} {:?} {:?}", small.rpy()[0], small.rpy()[1], small.rpy()[2]),
        );
        let third = Pose::from_xyz_rpy([0.1, 0.0, 0.0], [0.0; 3]) * small;
        let third = third.translation;
        let back = text
            .replace("\n<!--\n  a - - b\n-->", "")
            .replace(
                &format!("<origin xyz=\"{xyz}\" rpy=\"{rpy}\"/><parent link=\"l1\"/>"),
                "<parent link=\"l1\"/>",
            )
            .replace(
                &format!("<origin rpy=\"{rpy}\" xyz=\"{:?} {:?} {:?}\"/>", third.x, third.y, third.z),
                "<origin xyz=\"0.1 0 0\"/>",
            )
            .replace("xyz='0.0 0.0 0.301'", "xyz='0 0 3e-1'")
            .replace(&added("l3", &small), "");
        assert_eq!(back, ARM);
        std::fs::write(folder.path().join("b.urdf"), &text).unwrap();
        let (again, _) = read_robot(folder.path().join("b.urdf"), &RobotOptions::default()).unwrap();
        let q = [0.3, -0.4, 0.2];
        let expected =
            chain.joints().iter().zip(&corrected).zip(q).fold(Pose::IDENTITY, |at, ((joint, origin), q)| {
                at * *origin * joint.transform(0.0).inverse() * joint.transform(q)
            }) * small;
        let found = again.forward(&q);
        assert!((found.translation - expected.translation).norm() < 1e-14);
        assert!((found.rotation - expected.rotation).amax() < 1e-14);
        // A file that was corrected is not corrected again.
        assert!(corrected_urdf(folder.path().join("b.urdf"), &chain, &correction).is_err());
    }

    #[test]
    fn another_robot_is_refused_with_its_place() {
        let folder = tempfile::tempdir().unwrap();
        let chain = nominal(folder.path(), ARM);
        let correction = UrdfCorrection { origins: origins(&chain), behind: Pose::IDENTITY, comment: vec![] };
        let say = |text: &str| {
            let path = folder.path().join("other.urdf");
            std::fs::write(&path, text).unwrap();
            let error = corrected_urdf(&path, &chain, &correction).unwrap_err().to_string();
            error.replace(&format!("{}/", folder.path().display()), "")
        };
        let moved = say(&ARM.replace("0.1 0 0", "0.2 0 0"));
        assert!(
            moved.starts_with("other.urdf:8:1: joint `j3` has another origin than in the fit's robot"),
            "{moved}"
        );
        let missing = say(&ARM.replace("name=\"j3\"", "name=\"j9\""));
        assert_eq!(missing, "other.urdf:2:1: has no joint `j3`, which the fit's robot has");
        for broken in ["", "<a/>", "<robot", "<robot name='r'/>"] {
            assert!(say(broken).starts_with("other.urdf"), "{broken}");
        }
        let dh = truepose_kinematics::samples::heavy();
        let correction = UrdfCorrection { origins: origins(&dh), ..correction };
        assert!(corrected_urdf(folder.path().join("a.urdf"), &dh, &correction).is_err());
    }
}
