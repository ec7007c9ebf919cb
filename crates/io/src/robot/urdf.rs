//! The URDF form of a robot description: from a base link to a tip link.
//!
//! The frame after a URDF joint is its child link's frame, so that a link's centre of mass is where its
//! `<inertial>` has its origin; the inertia's own orientation plays no part in statics.

use super::RobotOptions;
use super::names::joint_name_problem;
use super::urdf_mimics::urdf_mimics;
use super::urdf_path::{path_between, read_backwards};
use super::urdf_text::{Urdf, UrdfJoint, UrdfLink};
use crate::nearest::{listed, meant};
use crate::text::Text;
use crate::toml_tree::Value;
use crate::{IoError, Warning};
use std::path::Path;
use truepose_kinematics::nalgebra::{Unit as UnitVector, Vector3};
use truepose_kinematics::{Joint, JointId, JointKind, Link, Mimic, Placement};

/// The part of a URDF that is read.
#[derive(Debug)]
pub(super) struct Arm {
    pub name: String,
    pub joints: Vec<Joint>,
    /// The joint in front of each; none of them where all follow one another.
    pub parents: Vec<Option<JointId>>,
    /// Joints that follow others.
    pub mimics: Vec<Mimic>,
}

pub(super) fn read(path: &Path, options: &RobotOptions, warnings: &mut Vec<Warning>) -> Result<Arm, IoError> {
    read_tree(path, options, &[], warnings)
}

/// All joints between the base and these ones, each with the place that names it; from the base to the tip where there are none.
pub(super) fn read_tree(
    path: &Path,
    options: &RobotOptions,
    ends: &[(String, Value<'_>)],
    warnings: &mut Vec<Warning>,
) -> Result<Arm, IoError> {
    let text = Text::read(path)?;
    let robot = Urdf::read(&text)?;
    let between = |options: &RobotOptions| {
        path_between(&robot, options).map_err(|problem| {
            let at = problem.joint.map_or(robot.at, |name| robot.joint_at(&name));
            text.error(at, problem.message)
        })
    };
    let mut on_path = Vec::new();
    for (name, place) in ends {
        let joints = || robot.joints.iter().map(|joint| joint.name.as_str());
        let Some(last) = robot.joints.iter().find(|joint| joint.name == *name) else {
            let (hint, known) = (meant(name, joints()), listed(joints()));
            return Err(place.error(format!("the URDF has no joint `{name}`{hint} (its joints: {known})")));
        };
        let tip = Some(last.child.clone());
        let way = between(&RobotOptions { tip, ..options.clone() })?;
        if let Some(joint) = way.back.first() {
            let message = format!(
                "the base link moves with joint `{}`; of several arms the base is above all",
                joint.name
            );
            return Err(place.error(message));
        }
        for joint in way.forth {
            if !on_path.iter().any(|other: &&UrdfJoint| other.name == joint.name) {
                on_path.push(joint);
            }
        }
    }
    let mut backwards = 0;
    if ends.is_empty() {
        let way = between(options)?;
        backwards = way.back.len();
        on_path = [way.back, way.forth].concat();
    }
    let before = |joint: &&UrdfJoint| {
        on_path.iter().position(|other| other.child == joint.parent).map(|k| JointId(k + 1))
    };
    let parents = if ends.is_empty() { Vec::new() } else { on_path.iter().map(before).collect() };
    let mimics = urdf_mimics(&on_path, |name, message| text.error(robot.joint_at(name), message))?;
    let mut joints: Vec<Joint> = Vec::with_capacity(on_path.len());
    for described in &on_path {
        let at = described.at;
        let warn = |message: String| {
            let (line, _) = text.place(at);
            Warning { file: path.into(), line: Some(line), column: None, message }
        };
        let mut joint = joint(described).map_err(|message| text.error(at, message))?;
        if joints.iter().any(|other| other.name == joint.name) {
            return Err(
                text.error(at, format!("two joints have the name `{}`; names must be different", joint.name))
            );
        }
        if limited(described) && joint.limits.is_none() {
            warnings.push(warn(format!("joint `{}` has no limits; add <limit lower=… upper=…>", joint.name)));
        }
        let link = robot.links.iter().find(|link| link.name == described.child);
        if let Some(link) = link.filter(|_| backwards == 0) {
            joint.link = link_of(link).map_err(|message| text.error(link.at, message))?;
        }
        joints.push(joint);
    }
    match backwards {
        0 => warn_of_side_branches(&robot, &joints, path, warnings),
        _ => {
            let message = read_backwards(&on_path[..backwards], &mut joints);
            warnings.push(Warning { file: path.into(), line: None, column: None, message });
        }
    }
    if joints.is_empty() {
        return Err(text.error(0, "base and tip are the same link; choose links with joints between them"));
    }
    Ok(Arm { name: robot.name.clone(), joints, parents, mimics })
}

fn joint(described: &UrdfJoint) -> Result<Joint, String> {
    let name = &described.name;
    if let Some(problem) = joint_name_problem(name) {
        return Err(problem);
    }
    let kind = match described.kind.as_str() {
        "revolute" | "continuous" => JointKind::Revolute,
        "prismatic" => JointKind::Prismatic,
        "fixed" => JointKind::Fixed,
        kind @ ("floating" | "planar" | "spherical") => {
            return Err(format!(
                "joint `{name}` is {kind}, which is not supported between base and tip; choose other links"
            ));
        }
        kind => {
            return Err(format!(
                "joint `{name}` has the type `{kind}`; a URDF has revolute, continuous, prismatic and fixed joints"
            ));
        }
    };
    let pose = described.origin;
    if !pose.is_finite() {
        return Err(format!("the origin of joint `{name}` is not finite"));
    }
    let axis = Vector3::from(described.axis);
    let axis = match UnitVector::try_new(axis, 1e-9) {
        Some(axis) if axis.iter().all(|v| v.is_finite()) => axis,
        _ if kind == JointKind::Fixed => Vector3::z_axis(),
        _ => return Err(format!("the axis of joint `{name}` has no direction; give one such as \"0 0 1\"")),
    };
    let mut joint = Joint::new(name.clone(), kind, Placement::Origin { pose, axis });
    let (lower, upper) = described.limits.unwrap_or_default();
    if limited(described) && lower.is_finite() && upper.is_finite() && (lower, upper) != (0.0, 0.0) {
        if lower > upper {
            return Err(format!("the limits of joint `{name}` are the wrong way round: {lower} > {upper}"));
        }
        joint = joint.with_limits(lower, upper);
    }
    Ok(joint)
}

/// Whether a joint of this type has limits.
fn limited(described: &UrdfJoint) -> bool {
    matches!(described.kind.as_str(), "revolute" | "prismatic")
}

fn link_of(link: &UrdfLink) -> Result<Option<Link>, String> {
    let (mass, com) = (link.mass, Vector3::from(link.com));
    if !mass.is_finite() || mass < 0.0 || !com.iter().all(|v| v.is_finite()) {
        return Err(format!(
            "the inertial of link `{}` has a mass of {mass} kg; it has to be 0 or more",
            link.name
        ));
    }
    Ok((mass > 0.0).then_some(Link { mass, com }))
}

/// Links that hang beside the path have weight, too, which a serial chain does not carry.
fn warn_of_side_branches(robot: &Urdf, joints: &[Joint], path: &Path, warnings: &mut Vec<Warning>) {
    let on_path = |name: &str| joints.iter().any(|joint| joint.name == name);
    let Some(first) = robot.joints.iter().find(|joint| joints.first().is_some_and(|j| j.name == joint.name))
    else {
        return;
    };
    // Everything that the first joint moves, by walking outwards.
    let mut moved: Vec<&str> = vec![&first.child];
    let mut next = 0;
    while next < moved.len() && moved.len() <= robot.links.len() {
        let link = moved[next];
        moved.extend(
            robot.joints.iter().filter(|joint| joint.parent == link).map(|joint| joint.child.as_str()),
        );
        next += 1;
    }
    let beside: Vec<&UrdfLink> = robot
        .joints
        .iter()
        .filter(|joint| !on_path(&joint.name) && moved.contains(&joint.child.as_str()))
        .filter_map(|joint| robot.links.iter().find(|link| link.name == joint.child))
        .filter(|link| link.mass > 0.0)
        .collect();
    if !beside.is_empty() {
        let kg: f64 = beside.iter().map(|link| link.mass).sum();
        let names: Vec<&str> = beside.iter().map(|link| link.name.as_str()).collect();
        let message = format!(
            "the links {} are not on the path from base to tip; their weight ({kg} kg) is ignored",
            crate::nearest::listed(names)
        );
        warnings.push(Warning { file: path.into(), line: None, column: None, message });
    }
}

#[cfg(test)]
mod tests {
    use crate::{RobotOptions, Warning, read_robot};
    use std::fmt::Write;
    use truepose_kinematics::{Chain, JointKind};

    /// A small arm: three moving joints and a fixed tool, with a gripper's finger on the side.
    fn arm(extra: &str) -> String {
        let mut text = String::from("<?xml version=\"1.0\"?>\n<robot name=\"arm\">\n");
        for (link, mass) in [("base", 9.0), ("l1", 4.0), ("l2", 2.0), ("l3", 1.0), ("tool0", 0.0)] {
            let _ = writeln!(
                text,
                "<link name=\"{link}\"><inertial><origin xyz=\"0.1 0 {mass}\" rpy=\"1 0 0\"/><mass value=\"{mass}\"/>\
                 <inertia ixx=\"1\" ixy=\"0\" ixz=\"0\" iyy=\"1\" iyz=\"0\" izz=\"1\"/></inertial></link>"
            );
        }
        text.push_str(
            r#"<joint name="j1" type="revolute"><origin xyz="0 0 0.3" rpy="0 0 0.5"/><parent link="base"/><child link="l1"/>
<axis xyz="0 0 2"/><limit lower="-3" upper="2" effort="1" velocity="1"/></joint>
<joint name="j2" type="continuous"><parent link="l1"/><child link="l2"/><axis xyz="0 1 0"/></joint>
<joint name="j3" type="prismatic"><parent link="l2"/><child link="l3"/><axis xyz="0 0 -1"/>
<limit lower="0" upper="0.5" effort="1" velocity="1"/></joint>
<joint name="flange" type="fixed"><origin xyz="0 0 0.1"/><parent link="l3"/><child link="tool0"/></joint>
"#,
        );
        text.push_str(extra);
        text.push_str("</robot>\n");
        text
    }

    const FINGER: &str = r#"<link name="finger"><inertial><mass value="0.2"/><inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial></link>
<joint name="grip" type="prismatic"><parent link="l3"/><child link="finger"/><axis xyz="1 0 0"/><limit lower="0" upper="0.1" effort="1" velocity="1"/></joint>
"#;

    fn read(urdf: &str, base: Option<&str>, tip: Option<&str>) -> Result<(Chain, Vec<Warning>), String> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.urdf");
        std::fs::write(&path, urdf).unwrap();
        let options = RobotOptions { base: base.map(String::from), tip: tip.map(String::from) };
        read_robot(&path, &options)
            .map_err(|error| error.to_string().replace(&format!("{}/", folder.path().display()), ""))
    }

    #[test]
    fn the_only_leaf_is_the_tip() {
        let (chain, warnings) = read(&arm(""), None, None).unwrap();
        assert_eq!(warnings, []);
        assert_eq!(chain.name(), "arm");
        let names: Vec<_> = chain.joints().iter().map(|j| (j.name.as_str(), j.kind, j.limits)).collect();
        assert_eq!(
            names,
            [
                ("j1", JointKind::Revolute, Some((-3.0, 2.0))),
                ("j2", JointKind::Revolute, None),
                ("j3", JointKind::Prismatic, Some((0.0, 0.5))),
                ("flange", JointKind::Fixed, None),
            ]
        );
        let link = chain.joints()[0].link.unwrap();
        assert_eq!((link.mass, link.com.as_slice()), (4.0, &[0.1, 0.0, 4.0][..]));
        assert!(chain.joints()[3].link.is_none());
        let pose = chain.forward(&[0.0, 0.0, 0.2]);
        assert!((pose.translation.z - (0.3 - 0.2 + 0.1)).abs() < 1e-15);
    }

    #[test]
    fn a_leaf_behind_no_moving_joint_is_no_tip() {
        let stand = "<link name=\"stand\"/><joint name=\"s\" type=\"fixed\"><parent link=\"base\"/><child link=\"stand\"/></joint>";
        let (chain, _) = read(&arm(stand), None, None).unwrap();
        assert_eq!(chain.joints().len(), 4);
        let none = read("<robot name=\"a\"></robot>", None, None).unwrap_err();
        assert_eq!(none, "a.urdf:1:1: the robot has no links");
    }

    #[test]
    fn a_branch_beside_the_path_is_told() {
        let text = arm(FINGER);
        assert_eq!(
            read(&text, None, None).unwrap_err(),
            "a.urdf:2:1: the robot has 2 leaves: tool0, finger; choose one of them as the tip link, as in --tip tool0"
        );
        let (chain, warnings) = read(&text, Some("l1"), Some("tool0")).unwrap();
        assert_eq!(chain.joints().len(), 3);
        assert!(warnings[0].message.contains("the links finger are not on the path"), "{}", warnings[0]);
        assert_eq!(
            read(&text, None, Some("tol0")).unwrap_err(),
            "a.urdf:2:1: there is no tip link `tol0`; did you mean `tool0`? (links: base, l1, l2, l3, tool0, finger)"
        );
        assert_eq!(
            read(&text, Some("tool0"), Some("l1")).unwrap_err(),
            "a.urdf:2:1: there is no way from the base link `tool0` to the tip link `l1`"
        );
    }

    #[test]
    fn what_is_not_supported_is_reported() {
        let good = arm("");
        let floating = read(&good.replace("continuous", "floating"), None, None).unwrap_err();
        assert_eq!(
            floating,
            "a.urdf:10:1: joint `j2` is floating, which is not supported between base and tip; choose other links"
        );
        let mimic = good.replace("<axis xyz=\"0 1 0\"/>", "<axis xyz=\"0 1 0\"/><mimic joint=\"j1\"/>");
        assert_eq!(
            read(&mimic.replace("mimic joint=\"j1", "mimic joint=\"j9"), None, None).unwrap_err(),
            "a.urdf:10:1: joint `j2` mimics `j9`, which is not between base and tip; choose other links (joints there: j1, j2, j3, flange)"
        );
        let circle = read(&mimic.replace("mimic joint=\"j1", "mimic joint=\"j2"), None, None).unwrap_err();
        assert_eq!(circle, "a.urdf:10:1: joint `j2` cannot mimic: joints follow each other in a circle");
        let (chain, _) =
            read(&mimic.replace("\"j1\"/>", "\"j1\" multiplier=\"-2\" offset=\"0.1\"/>"), None, None)
                .unwrap();
        let mut values = [0.3, 7.0, 0.2];
        chain.joints_from_controller(&mut values);
        let expected = [0.3, -2.0 * 0.3 + 0.1, 0.2];
        assert!(values.iter().zip(expected).all(|(value, expected)| (value - expected).abs() < 1e-15));
        let zero = read(&good.replace("0 1 0", "0 0 0"), None, None).unwrap_err();
        assert!(zero.starts_with("a.urdf:10:1: the axis of joint `j2` has no direction"), "{zero}");
        let reserved = read(&good.replace("\"j2\"", "\"time\""), None, None).unwrap_err();
        assert!(reserved.starts_with("a.urdf:10:1: a joint cannot be called `time`"), "{reserved}");
        let lost =
            read(&good.replace("<parent link=\"l1\"/>", "<parent link=\"l9\"/>"), None, None).unwrap_err();
        assert_eq!(lost, "a.urdf:10:1: joint `j2` refers to a link `l9` that is not declared");
        for broken in
            ["", "<", "<robot", "<a/>", "<robot name='r'/>", "<robot name='r'><joint/></robot>", "&lol;"]
        {
            let message = read(broken, None, None).unwrap_err();
            assert!(message.starts_with("a.urdf:"), "{message}");
        }
        let typo = read(&good.replace("xyz=\"0 0 0.3\"", "xyz=\"0 0 o.3\""), None, None).unwrap_err();
        assert_eq!(typo, "a.urdf:8:47: `xyz=\"0 0 o.3\"` is not 3 numbers");
    }

    #[test]
    fn a_toml_adds_to_a_urdf() {
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join("a.urdf"), arm(FINGER)).unwrap();
        let path = folder.path().join("r.toml");
        let toml = "urdf = \"a.urdf\"\ntip = \"tool0\"\n[units]\nlength = \"mm\"\n[tool]\nxyz = [0, 0, 100]\n\
                    [[targets]]\nname = \"T\"\nxyz = [1, 2, 3]\n";
        std::fs::write(&path, toml).unwrap();
        let (chain, _) = read_robot(&path, &RobotOptions::default()).unwrap();
        assert_eq!((chain.joints().len(), chain.targets().len()), (4, 1));
        assert!((chain.tool().pose.translation.z - 0.1).abs() < 1e-15);
        assert_eq!(chain.name(), "arm");
        let options = RobotOptions { tip: Some("finger".into()), ..RobotOptions::default() };
        assert_eq!(read_robot(&path, &options).unwrap().0.joints().len(), 4);
        assert_eq!(read_robot(&path, &options).unwrap().0.joints()[3].name, "grip");
    }

    #[test]
    fn what_robots_carry_besides_is_skipped() {
        let text = arm(
            r#"<!-- everything that a generated file has, too -->
<material name="grey"><color rgba="0.5 0.5 0.5 1"/></material>
<transmission name="t1"><type>transmission_interface/SimpleTransmission</type>
<joint name="j1"><hardwareInterface>hardware_interface/PositionJointInterface</hardwareInterface></joint>
<actuator name="m1"><mechanicalReduction>1</mechanicalReduction></actuator></transmission>
<gazebo reference="l1"><material>Gazebo/Grey</material></gazebo>
<ros2_control name="arm" type="system"><hardware><plugin>mock</plugin></hardware><joint name="j1"><command_interface name="position"/></joint></ros2_control>
"#,
        )
        .replace(
            "<link name=\"l2\">",
            "<link name=\"l2\"><visual><origin xyz=\"0 0 0\" rpy=\"0 0 0\"/><geometry><mesh filename=\"package://a/b.dae\"/></geometry>\
             <material name=\"grey\"/></visual><collision><geometry><cylinder radius=\"0.1\" length=\"0.2\"/></geometry></collision>",
        )
        .replace("<axis xyz=\"0 1 0\"/>", "<axis xyz=\"0 1 0\"/><dynamics damping=\"0.1\"/><safety_controller k_velocity=\"0\"/>");
        let (chain, warnings) = read(&text, None, None).unwrap();
        assert_eq!((chain.joints().len(), warnings.len()), (4, 0));
    }
}
