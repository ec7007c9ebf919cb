//! The way from a URDF's base link to its tip link.

use super::urdf_text::{Urdf, UrdfJoint};
use super::{MOST_JOINTS, RobotOptions};
use crate::nearest::{listed, meant};
use std::collections::{HashMap, HashSet};

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

/// The joints from base to tip, in order.
pub(super) fn path_between<'a>(
    robot: &'a Urdf,
    options: &RobotOptions,
) -> Result<Vec<&'a UrdfJoint>, NoPath> {
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
    climb(&above, base, tip).ok_or_else(|| {
        NoPath::new(format!("there is no way from the base link `{base}` to the tip link `{tip}`"))
    })
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
