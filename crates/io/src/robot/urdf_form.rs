//! A robot as a URDF of its own, for those that were described otherwise.
//!
//! Links are bare but for their weight: the inertias are those of point masses. A base or tool that the description has
//! beside the joints becomes a fixed joint (the tool's), or a comment (the base's, which is the installation of the robot).

use super::urdf_corrected::{comment, xml};
use std::fmt::Write;
use truepose_kinematics::{Chain, Joint, JointId, JointKind, Placement, Pose};

/// The robot as a URDF, from its base to its tool, with digits that read back to the same numbers. Its base pose is left
/// away: a URDF begins at the base link.
pub fn robot_urdf(chain: &Chain, comments: &[String]) -> String {
    let mut out = String::new();
    // Writing to a String cannot fail.
    let _ = write(chain, comments, &mut out);
    out
}

fn write(chain: &Chain, comments: &[String], out: &mut String) -> std::fmt::Result {
    writeln!(out, "<?xml version=\"1.0\"?>")?;
    writeln!(out, "<robot name=\"{}\">{}", escaped(chain.name()), comment(comments))?;
    writeln!(out, "  <link name=\"base_link\"/>")?;
    // Link of each frame, and where the joints on it begin.
    let mut frames = vec![(String::from("base_link"), Pose::IDENTITY)];
    for (index, joint) in chain.joints().iter().enumerate() {
        let (parent, before) = frames[chain.before(JointId(index + 1)).0].clone();
        let (pose, axis, behind) = match joint.placement {
            Placement::Origin { pose, axis } => (pose, axis.into_inner().into(), Pose::IDENTITY),
            Placement::Dh { .. } if joint.moves() => (Pose::IDENTITY, [0.0, 0.0, 1.0], joint.transform(0.0)),
            _ => (joint.transform(0.0), [0.0, 0.0, 1.0], Pose::IDENTITY),
        };
        let child = format!("{}_link", joint.name);
        link(&child, joint, &behind, out)?;
        let kind = match (joint.kind, joint.limits) {
            (JointKind::Fixed, _) => "fixed",
            (JointKind::Prismatic, _) => "prismatic",
            (JointKind::Revolute, Some(_)) => "revolute",
            (JointKind::Revolute, None) => "continuous",
        };
        let limits = joint.limits.filter(|_| joint.moves());
        let mimic = chain.mimics().iter().find(|mimic| mimic.joint.0 == index + 1);
        let follows = mimic.map(|mimic| (chain.joint(mimic.driver).name.as_str(), mimic.ratio, mimic.offset));
        let motion = (axis, limits, follows);
        connection(&joint.name, kind, &(before * pose), (&parent, &child), Some(motion), out)?;
        frames.push((child, behind));
    }
    for tool in chain.tools() {
        let (parent, before) = &frames[tool.frame.0];
        let pose = *before * tool.placed.pose;
        // Of several tools each has a link, as a robot has leaves.
        let name = if chain.tools().len() == 1 { "tool" } else { &tool.name };
        if pose != Pose::IDENTITY || chain.tools().len() > 1 {
            let (link, joint) = (format!("{name}_link"), format!("{name}_joint"));
            writeln!(out, "  <link name=\"{}\"/>", escaped(&link))?;
            connection(&joint, "fixed", &pose, (parent, &link), None, out)?;
        }
    }
    writeln!(out, "</robot>")
}

fn link(name: &str, joint: &Joint, behind: &Pose, out: &mut String) -> std::fmt::Result {
    let Some(link) = &joint.link else { return writeln!(out, "  <link name=\"{}\"/>", escaped(name)) };
    let com = triple(behind.apply(&link.com).into());
    writeln!(
        out,
        "  <link name=\"{}\"><inertial><origin xyz=\"{com}\"/><mass value=\"{:?}\"/>\
         <inertia ixx=\"0\" ixy=\"0\" ixz=\"0\" iyy=\"0\" iyz=\"0\" izz=\"0\"/></inertial></link>",
        escaped(name),
        link.mass
    )
}

/// Axis and limits of a joint that moves; what it follows: name, ratio, offset.
type Motion<'a> = ([f64; 3], Option<(f64, f64)>, Option<(&'a str, f64, f64)>);

fn connection(
    name: &str,
    kind: &str,
    origin: &Pose,
    (parent, child): (&str, &str),
    motion: Option<Motion<'_>>,
    out: &mut String,
) -> std::fmt::Result {
    writeln!(out, "  <joint name=\"{}\" type=\"{kind}\">", escaped(name))?;
    let (xyz, rpy) = (triple(origin.translation.into()), triple(origin.rpy()));
    writeln!(out, "    <origin xyz=\"{xyz}\" rpy=\"{rpy}\"/>")?;
    writeln!(out, "    <parent link=\"{}\"/>\n    <child link=\"{}\"/>", escaped(parent), escaped(child))?;
    if let Some((axis, ..)) = motion.filter(|_| kind != "fixed") {
        writeln!(out, "    <axis xyz=\"{}\"/>", triple(axis))?;
    }
    let (limits, follows) = motion.map_or((None, None), |(_, limits, follows)| (limits, follows));
    if let Some((driver, ratio, offset)) = follows {
        let driver = escaped(driver);
        writeln!(out, "    <mimic joint=\"{driver}\" multiplier=\"{ratio:?}\" offset=\"{offset:?}\"/>")?;
    }
    if let Some((lower, upper)) = limits.filter(|(lower, upper)| lower.is_finite() && upper.is_finite()) {
        writeln!(out, "    <limit lower=\"{lower:?}\" upper=\"{upper:?}\" effort=\"0\" velocity=\"0\"/>")?;
    }
    writeln!(out, "  </joint>")
}

fn triple(v: [f64; 3]) -> String {
    v.map(|x| format!("{x:?}")).join(" ")
}

fn escaped(text: &str) -> String {
    xml(text).replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{RobotOptions, read_robot};
    use truepose_kinematics::samples;

    #[test]
    fn every_sample_robot_comes_back() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("r.urdf");
        for chain in samples::all() {
            std::fs::write(&path, robot_urdf(&chain, &["one".into(), "two".into()])).unwrap();
            let (again, _) = read_robot(&path, &RobotOptions::default()).unwrap();
            assert_eq!(again.name(), chain.name());
            for (a, b) in again.movable().iter().zip(chain.movable()) {
                let (a, b) = (again.joint(*a), chain.joint(*b));
                assert_eq!((&a.name, a.kind, a.limits), (&b.name, b.kind, b.limits));
                assert_eq!(a.link.map(|l| l.mass), b.link.map(|l| l.mass));
            }
            let q: Vec<f64> = (0..chain.movable().len()).map(|k| 0.1 + 0.2 * k as f64).collect();
            let (here, there) = (chain.base().pose * again.forward(&q), chain.forward(&q));
            assert!((here.translation - there.translation).norm() < 1e-14, "{}", chain.name());
            assert!((here.rotation - there.rotation).amax() < 1e-14, "{}", chain.name());
        }
    }
}
