//! The way from a URDF's base link to its tip link.

use super::urdf_text::{Urdf, UrdfJoint};
use super::{MOST_JOINTS, RobotOptions};
use crate::nearest::{listed, meant};
use std::collections::{HashMap, HashSet};
use truepose_kinematics::{Joint, Placement, Pose};

/// Why there is no way, and the joint that is to blame.
#[derive(Debug)]
pub(super) struct NoPath {
    pub joint: Option<String>,
    pub message: String,
}

impl NoPath {
    fn new(message: impl Into<String>) -> Self {
        NoPath { joint: None, message: message.into() }
    }
}

/// The way from base to tip: joints that lead back from the base to a link above both, and those from there to the tip, in order.
#[derive(Debug)]
pub(super) struct Way<'a> {
    pub back: Vec<&'a UrdfJoint>,
    pub forth: Vec<&'a UrdfJoint>,
}

/// The joints between base and tip.
pub(super) fn path_between<'a>(robot: &'a Urdf, options: &RobotOptions) -> Result<Way<'a>, NoPath> {
    let links = || robot.links.iter().map(|link| link.name.as_str());
    let declared: HashSet<&str> = links().collect();
    let mut above: HashMap<&str, &UrdfJoint> = HashMap::new();
    for joint in &robot.joints {
        for end in [&joint.parent, &joint.child] {
            if !declared.contains(end.as_str()) {
                return Err(NoPath {
                    joint: Some(joint.name.clone()),
                    message: format!("joint `{}` refers to a link `{end}` that is not declared", joint.name),
                });
            }
        }
        if above.insert(joint.child.as_str(), joint).is_some() {
            return Err(NoPath {
                joint: Some(joint.name.clone()),
                message: format!("link `{}` is the child of two joints", joint.child),
            });
        }
    }
    let known = |role: &str, name: &str| {
        if declared.contains(name) {
            Ok(())
        } else {
            let hint = meant(name, links());
            Err(NoPath::new(format!("there is no {role} link `{name}`{hint} (links: {})", listed(links()))))
        }
    };
    let base = match &options.base {
        Some(base) => {
            known("base", base)?;
            base.as_str()
        }
        None => {
            let roots: Vec<&str> = links().filter(|link| !above.contains_key(link)).collect();
            match roots[..] {
                [root] => root,
                [] if declared.is_empty() => return Err(NoPath::new("the robot has no links")),
                [] => return Err(NoPath::new("the links form a ring; choose a base link")),
                _ => {
                    let roots = listed(roots.iter().copied());
                    return Err(NoPath::new(format!(
                        "several links have no parent: {roots}; choose a base link"
                    )));
                }
            }
        }
    };
    let tip = match &options.tip {
        Some(tip) => {
            known("tip", tip)?;
            tip.as_str()
        }
        None => only_leaf(robot, &above, base)?,
    };
    way(&above, base, tip).ok_or_else(|| {
        NoPath::new(format!("there is no way from the base link `{base}` to the tip link `{tip}`"))
    })
}

/// Upwards from the base, as far as there is a way down to the tip; a tip above the base is the other end of an arm, and no way.
fn way<'a>(above: &HashMap<&str, &'a UrdfJoint>, base: &str, tip: &str) -> Option<Way<'a>> {
    let (mut back, mut link): (Vec<&UrdfJoint>, &str) = (Vec::new(), base);
    loop {
        if let Some(forth) = climb(above, link, tip) {
            return (back.is_empty() || !forth.is_empty()).then_some(Way { back, forth });
        }
        let joint = *above.get(link)?;
        if back.len() >= MOST_JOINTS.min(above.len()) {
            return None;
        }
        back.push(joint);
        link = &joint.parent;
    }
}

/// Turns the first joints of an arm round, those of `back`: about the opposite axis, and the inverse of each origin in front of the next joint. What
/// there is to know of it.
pub(super) fn read_backwards(back: &[&UrdfJoint], joints: &mut [Joint]) -> String {
    let mut inverse = Pose::IDENTITY;
    for (k, joint) in joints.iter_mut().enumerate().take(back.len() + 1) {
        if let Placement::Origin { pose, axis } = &mut joint.placement {
            let own = *pose;
            if k < back.len() {
                (*pose, *axis) = (inverse, -*axis);
            } else {
                *pose = inverse * own;
            }
            inverse = own.inverse();
        }
    }
    let names = listed(back.iter().map(|joint| joint.name.as_str()));
    let above = back.last().map_or("", |joint| joint.parent.as_str());
    format!(
        "the base link moves: {names} lead from it to `{above}` and are read backwards, with the values of the file; where gravity points in its frame \
         changes, and the weight of links is left out"
    )
}

fn only_leaf<'a>(
    robot: &'a Urdf,
    above: &HashMap<&str, &'a UrdfJoint>,
    base: &str,
) -> Result<&'a str, NoPath> {
    let parents: HashSet<&str> = robot.joints.iter().map(|joint| joint.parent.as_str()).collect();
    let leaves: Vec<&str> = robot
        .links
        .iter()
        .map(|link| link.name.as_str())
        .filter(|link| !parents.contains(link))
        .filter(|link| *link != base && climb(above, base, link).is_some())
        .collect();
    let moves =
        |leaf: &&&str| climb(above, base, leaf).is_some_and(|way| way.iter().any(|of| of.kind != "fixed"));
    let moving: Vec<&str> = leaves.iter().filter(moves).copied().collect();
    // Behind no moving joint nothing is a tip.
    let leaves = if moving.is_empty() { leaves } else { moving };
    match leaves[..] {
        [leaf] => Ok(leaf),
        [] => Err(NoPath::new(format!("no joint leads away from the base link `{base}`"))),
        _ => {
            let count = leaves.len();
            let first = leaves.first().map_or("NAME", |leaf| *leaf);
            let leaves = listed(leaves.iter().copied());
            Err(NoPath::new(format!(
                "the robot has {count} leaves: {leaves}; choose one of them as the tip link, as in --tip {first}"
            )))
        }
    }
}

fn climb<'a>(above: &HashMap<&str, &'a UrdfJoint>, base: &str, tip: &str) -> Option<Vec<&'a UrdfJoint>> {
    let mut joints = Vec::new();
    let mut link = tip;
    while link != base {
        let joint = *above.get(link)?;
        joints.push(joint);
        if joints.len() > MOST_JOINTS.min(above.len()) {
            return None;
        }
        link = &joint.parent;
    }
    joints.reverse();
    Some(joints)
}

#[cfg(test)]
mod tests {
    use crate::{RobotOptions, read_robot};
    use truepose_kinematics::Pose;

    /// A head that looks at the hand: from the head's link back to the torso, and on to the hand.
    #[test]
    fn the_way_from_a_head_to_a_hand_goes_back_to_the_torso() {
        let joint = |name: &str, (parent, child): (&str, &str), origin: &str, axis: &str| {
            format!(
                "<link name=\"{child}\"><inertial><mass value=\"2\"/></inertial></link>\n<joint name=\"{name}\" type=\"continuous\">\
                 <origin {origin}/><parent link=\"{parent}\"/><child link=\"{child}\"/><axis xyz=\"{axis}\"/></joint>\n"
            )
        };
        let text = [
            "<robot name=\"torso\">\n<link name=\"torso\"/>\n".to_owned(),
            joint("pan", ("torso", "neck"), "xyz=\"0.1 0.2 1\" rpy=\"0 0 0.4\"", "0 0 1"),
            joint("nod", ("neck", "eyes"), "xyz=\"0 0 0.2\"", "0 1 0"),
            joint("lift", ("torso", "arm"), "xyz=\"0 -0.3 0.8\"", "0 1 0"),
            joint("roll", ("arm", "hand"), "xyz=\"0.4 0 0\"", "-1 0 0"),
            "</robot>\n".to_owned(),
        ];
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("t.urdf");
        std::fs::write(&path, text.concat()).unwrap();
        let read = |base: &str, tip: &str| {
            read_robot(&path, &RobotOptions { base: Some(base.into()), tip: Some(tip.into()) })
        };
        let (chain, warnings) = read("eyes", "hand").unwrap();
        let names: Vec<&str> = chain.joints().iter().map(|joint| joint.name.as_str()).collect();
        assert_eq!(names, ["nod", "pan", "lift", "roll"]);
        // The same by hand: both ways from the torso.
        let place = |x: f64, y: f64, z: f64| Pose::trans(0, x) * Pose::trans(1, y) * Pose::trans(2, z);
        let q = [0.3, -0.7, 0.5, 1.1];
        let eyes =
            place(0.1, 0.2, 1.0) * Pose::rot(2, 0.4 + q[1]) * place(0.0, 0.0, 0.2) * Pose::rot(1, q[0]);
        let hand = place(0.0, -0.3, 0.8) * Pose::rot(1, q[2]) * place(0.4, 0.0, 0.0) * Pose::rot(0, -q[3]);
        let (found, truth) = (chain.forward(&q), eyes.inverse() * hand);
        assert!((found.translation - truth.translation).norm() < 1e-12, "{found:?}");
        assert!((found.rotation - truth.rotation).amax() < 1e-12, "{found:?}");
        let told = |words: &str| warnings.iter().any(|warning| warning.message.contains(words));
        assert!(told("nod, pan lead from it to `torso`"), "{warnings:?}");
        assert!(chain.joints().iter().all(|joint| joint.link.is_none()));
        // The two ends of an arm the other way round are a mistake.
        assert!(read("hand", "torso").unwrap_err().to_string().contains("there is no way"));
    }
}
