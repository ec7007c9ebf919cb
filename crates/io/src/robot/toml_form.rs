//! The TOML form of a robot description.

use super::names::joint_name_problem;
use super::{MOST_JOINTS, RobotOptions, turns, urdf};
use super::{columns, couplings, details, kinematics_yaml, mimics, sessions, surroundings, targets, tree};
use crate::frame_names::joint_name;
use crate::text::Text;
use crate::toml_tree::{Document, Table, Value};
use crate::{IoError, Unit, Warning};
use std::path::{Path, PathBuf};
use truepose_kinematics::nalgebra::{Unit as UnitVector, Vector3};
use truepose_kinematics::{
    Chain, ChainError, Gravity, GravityFrame, Joint, JointKind, Link, Placed, Placement, Pose,
};

/// Units of every length and angle of one file.
#[derive(Clone, Copy)]
struct Units {
    length: &'static Unit,
    angle: &'static Unit,
}

impl Units {
    fn lengths(self, values: [f64; 3]) -> [f64; 3] {
        values.map(|v| self.length.to_si(v))
    }

    fn angles(self, values: [f64; 3]) -> [f64; 3] {
        values.map(|v| self.angle.to_si(v))
    }
}

pub(super) fn read(
    path: &Path,
    options: &RobotOptions,
    warnings: &mut Vec<Warning>,
) -> Result<Chain, IoError> {
    of(&Text::read(path)?, options, warnings)
}

/// The robot of a text.
pub(super) fn of(text: &Text, options: &RobotOptions, warnings: &mut Vec<Warning>) -> Result<Chain, IoError> {
    let path = text.file.as_path();
    if text.text.trim().is_empty() {
        return Err(IoError::file(path, "is empty; a robot description begins with its name and its joints"));
    }
    let document = Document::parse(text)?;
    let root = document.root("the robot");
    root.only(&[
        "name",
        "gravity",
        "gravity_frame",
        "units",
        "base",
        "base_link",
        "joints",
        "tool",
        "tools",
        "targets",
        "urdf",
        "kinematics",
        "kinematics_style",
        "kinematics_axes",
        "tip",
        "columns",
        "couplings",
        "sessions",
        "landmarks",
        "distances",
        "cameras",
        details::KEYS[0],
        details::KEYS[1],
    ])?;
    let mut errors = Vec::new();
    errors.extend(columns::read(&root).err());
    errors.extend(sessions::read(&root).err());
    errors.extend(units(&root).and_then(|units| surroundings::read(&root, units.length, units.angle)).err());
    let units = units(&root)?;
    details::of(&root)?;
    if units.angle.is_si() {
        turns::look(&root, path, warnings);
    }
    let (found, there) = kinematics_yaml::named(&root, |file| beside(path, file))?;
    let mut followers = Vec::new();
    let ((name, joints), parents) = match (root.get("urdf"), root.get("joints")) {
        (None, None) if found.is_some() => (found.unwrap_or_default(), Vec::new()),
        (Some(urdf), Some(_)) => {
            return Err(urdf.error("`urdf` and [[joints]] exclude each other; keep one of them"));
        }
        (Some(file), None) => {
            let arm = from_urdf(path, &root, &file, options, warnings)?;
            followers = arm.mimics;
            ((arm.name, arm.joints), arm.parents)
        }
        (None, joints) => {
            if options.base.is_some() || options.tip.is_some() {
                let message = "lists its joints itself; a base or tip link can be chosen for a URDF only";
                return Err(IoError::file(path, message));
            }
            for key in ["tip", "base_link"] {
                if let Some(value) = root.get(key) {
                    return Err(value.error(format!(
                        "`{key}` chooses a link of a URDF; add `urdf = \"…\"` or remove it"
                    )));
                }
            }
            let joints = joints.ok_or_else(|| {
                IoError::file(path, "has neither [[joints]] nor `urdf`; a robot needs one of them")
            })?;
            let read = self::joints(&joints, units, &mut errors)?;
            let parents = tree::parents(&joints.tables("joints")?, &mut errors)?;
            ((String::from("robot"), read), parents)
        }
    };
    let name = root.get("name").map(|value| value.string().map(String::from)).transpose()?.unwrap_or(name);
    let whole = |error: ChainError| IoError::file(path, error.to_string());
    let at = |key: &str, table: &str| -> Result<Option<Placed>, IoError> {
        let value = root.get(key).filter(|value| !value.is_string() || key != "base");
        value.map(|value| placed(&value.table(table)?, units)).transpose()
    };
    // What is wrong with one table says nothing about the others: all of it at once.
    let base = kept(at("base", "[base]"), &mut errors).flatten();
    let tool = kept(at("tool", "[tool]"), &mut errors).flatten();
    let targets = match root.get("targets") {
        Some(targets) => targets::read(&targets, units.length, &tree::names(&root)?, &mut errors)?,
        None => Vec::new(),
    };
    let gravity = kept(gravity(&root), &mut errors).unwrap_or_default();
    some(errors)?;
    let mut chain = Chain::new(name, joints).map_err(whole)?;
    if !parents.is_empty() {
        chain = chain.with_parents(&parents).map_err(whole)?;
    }
    if let Some(tools) = tree::tools(&root, &chain, |table| placed_at(table, units))? {
        chain = chain.with_tools(tools).map_err(whole)?;
    }
    let mut errors = Vec::new();
    let couplings = couplings::read(&root, &chain, &mut errors)?;
    some(std::mem::take(&mut errors))?;
    chain = chain.with_couplings(couplings).and_then(|chain| chain.with_mimics(followers)).map_err(whole)?;
    if let Some(joints) = root.get("joints") {
        chain =
            mimics::with_mimics(&joints.tables("joints")?, chain, (units.length, units.angle), &mut errors)?;
        some(errors)?;
    }
    if let Some(base) = base.or(there.0) {
        chain = chain.with_base(base).map_err(whole)?;
    }
    if let Some(tool) = tool.or(there.1) {
        chain = chain.with_tool(tool).map_err(whole)?;
    }
    chain.with_targets(targets).and_then(|chain| chain.with_gravity(gravity)).map_err(whole)
}

/// Errors of a description that are listed.
const LISTED: usize = 20;

/// Errors in the order of the file, where there are any.
fn some(mut errors: Vec<IoError>) -> Result<(), IoError> {
    if errors.is_empty() {
        return Ok(());
    }
    errors.sort_by_key(IoError::line_number);
    let more = errors.len().saturating_sub(LISTED);
    errors.truncate(LISTED);
    Err(IoError::several(errors, more))
}

/// The value; its error joins the others.
fn kept<T>(value: Result<T, IoError>, errors: &mut Vec<IoError>) -> Option<T> {
    value.map_err(|error| errors.push(error)).ok()
}

/// The URDF or kinematics file that a description names.
pub(super) fn urdf_file(path: &Path) -> Option<PathBuf> {
    let text = Text::read(path).ok()?;
    let document = Document::parse(&text).ok()?;
    let root = document.root("the robot");
    let named = root.get("urdf").or_else(|| root.get("kinematics"))?.string().ok()?.to_owned();
    Some(beside(path, &named))
}

/// A file that a description names counts from its folder.
fn beside(path: &Path, named: &str) -> PathBuf {
    path.parent().unwrap_or(Path::new("")).join(named)
}

fn from_urdf(
    path: &Path,
    root: &Table<'_>,
    file: &Value<'_>,
    options: &RobotOptions,
    warnings: &mut Vec<Warning>,
) -> Result<urdf::Arm, IoError> {
    let word = |key: &str| -> Result<Option<String>, IoError> {
        root.get(key).filter(Value::is_string).map(|value| value.string().map(String::from)).transpose()
    };
    if let Some(link) = root.get("base_link") {
        link.string()?;
    }
    if let Some(tip) = root.get("tip") {
        tip.string()?;
    }
    let base = match (word("base_link")?, word("base")?) {
        (Some(link), _) | (None, Some(link)) => Some(link),
        (None, None) => None,
    };
    let options =
        RobotOptions { base: options.base.clone().or(base), tip: options.tip.clone().or(word("tip")?) };
    let beside = beside(path, file.string()?);
    if !beside.is_file() {
        return Err(file.error(format!(
            "there is no file `{}`; the path counts from this file's folder",
            beside.display()
        )));
    }
    let ends = tree::ends(root)?;
    if ends.is_empty() {
        return urdf::read(&beside, &options, warnings);
    }
    if let Some(tip) = root.get("tip") {
        return Err(tip.error("`tip` and [[tools]] exclude each other: each tool names its `joint`"));
    }
    urdf::read_tree(&beside, &options, &ends, warnings)
}

/// The unit of every length of a description.
pub(super) fn units_of(root: &Table<'_>) -> Result<(&'static Unit, &'static Unit), IoError> {
    units(root).map(|units| (units.length, units.angle))
}

fn units(root: &Table<'_>) -> Result<Units, IoError> {
    let named = |word: &'static str| (word, Unit::named(word));
    let (mut length, mut angle) = (Unit::named("m"), Unit::named("rad"));
    if let Some(units) = root.get("units") {
        let units = units.table("[units]")?;
        units.only(&["length", "angle"])?;
        if let Some(value) = units.get("length") {
            length = value.word(&["m", "mm", "in"].map(named))?;
        }
        if let Some(value) = units.get("angle") {
            angle = value.word(&["rad", "deg"].map(named))?;
        }
    }
    let both = length.zip(angle).map(|(length, angle)| Units { length, angle });
    both.ok_or_else(|| root.error("the units of this file are not known"))
}

fn joints(value: &Value<'_>, units: Units, errors: &mut Vec<IoError>) -> Result<Vec<Joint>, IoError> {
    let tables = value.tables("joints")?;
    if let Some(table) = tables.get(MOST_JOINTS) {
        return Err(table.error(format!("a robot has at most {MOST_JOINTS} joints")));
    }
    let mut joints: Vec<Joint> = Vec::with_capacity(tables.len());
    for table in &tables {
        let Some(joint) = kept(joint(table, units), errors) else { continue };
        if joints.iter().any(|other| other.name == joint.name) {
            errors.push(
                table
                    .require("name")?
                    .error(format!("two joints have the name `{}`; names must be different", joint.name)),
            );
        }
        joints.push(joint);
    }
    Ok(joints)
}

fn joint(table: &Table<'_>, units: Units) -> Result<Joint, IoError> {
    table.only(&["name", "type", "limits", "dh", "mdh", "origin", "mass", "com", "parent", "mimic"])?;
    let name = table.require("name")?;
    let called = joint_name(name.string()?);
    if let Some(problem) = joint_name_problem(&called) {
        return Err(name.error(problem));
    }
    let kinds =
        [("revolute", JointKind::Revolute), ("prismatic", JointKind::Prismatic), ("fixed", JointKind::Fixed)];
    let kind = table.get("type").map_or(Ok(JointKind::Revolute), |word| word.word(&kinds))?;
    let mut joint = Joint::new(called, kind, placement(table, kind, units)?);
    if let Some(limits) = table.get("limits") {
        let unit = match kind {
            JointKind::Revolute => units.angle,
            JointKind::Prismatic => units.length,
            JointKind::Fixed => return Err(limits.error("a fixed joint has no limits; remove them")),
        };
        let [lower, upper] = limits.numbers::<2>()?;
        if lower > upper {
            return Err(limits.error(format!("the limits are the wrong way round: {lower} > {upper}")));
        }
        joint = joint.with_limits(unit.to_si(lower), unit.to_si(upper));
    }
    joint.link = match (table.get("mass"), table.get("com")) {
        (None, None) => None,
        (Some(mass), Some(com)) => {
            let kg = mass.number()?;
            if kg < 0.0 {
                return Err(mass.error(format!("a mass cannot be negative: {kg} kg")));
            }
            Some(Link { mass: kg, com: Vector3::from(units.lengths(com.numbers::<3>()?)) })
        }
        (Some(mass), None) => {
            return Err(mass.error(
                "`mass` needs `com`, the link's centre of mass in the frame after the joint; add it",
            ));
        }
        (None, Some(com)) => return Err(com.error("`com` needs `mass`, the link's mass in kg; add it")),
    };
    Ok(joint)
}

fn placement(table: &Table<'_>, kind: JointKind, units: Units) -> Result<Placement, IoError> {
    let given: Vec<(&str, Value<'_>)> =
        ["dh", "mdh", "origin"].into_iter().filter_map(|key| table.get(key).map(|v| (key, v))).collect();
    let (key, value) = match &given[..] {
        [(key, value)] => (*key, value),
        [] => return Err(table.error(format!("{} needs one of `dh`, `mdh` and `origin`", table.name()))),
        [_, (_, second), ..] => {
            let keys: Vec<&str> = given.iter().map(|(key, _)| *key).collect();
            let message =
                format!("{} has `{}`; keep exactly one of them", table.name(), keys.join("` and `"));
            return Err(second.error(message));
        }
    };
    let inner = value.table(&format!("`{key}` of {}", table.name()))?;
    if key == "origin" {
        inner.only(&["xyz", "rpy", "axis"])?;
        let axis = match (inner.get("axis"), kind) {
            (Some(value), _) => {
                let axis = Vector3::from(value.numbers::<3>()?);
                UnitVector::try_new(axis, 1e-9).ok_or_else(|| {
                    value.error("the axis has length zero; give a direction such as [0, 0, 1]")
                })?
            }
            (None, JointKind::Fixed) => Vector3::z_axis(),
            (None, _) => {
                return Err(inner.error(format!("{} lacks `axis`; add it, e.g. [0, 0, 1]", inner.name())));
            }
        };
        return Ok(Placement::Origin { pose: pose(&inner, units)?, axis });
    }
    inner.only(&["theta", "d", "a", "alpha"])?;
    let number = |key: &str| inner.require(key)?.number();
    let offset = |key: &str| inner.get(key).map_or(Ok(0.0), |value| value.number());
    let theta = units.angle.to_si(offset("theta")?);
    let d = units.length.to_si(offset("d")?);
    let a = units.length.to_si(number("a")?);
    let alpha = units.angle.to_si(number("alpha")?);
    Ok(if key == "dh" { Placement::Dh { theta, d, a, alpha } } else { Placement::Mdh { alpha, a, theta, d } })
}

/// A pose from `xyz` and `rpy`, each zero where it is absent.
fn pose(table: &Table<'_>, units: Units) -> Result<Pose, IoError> {
    let three = |key: &str| table.get(key).map_or(Ok([0.0; 3]), |value| value.numbers::<3>());
    Ok(Pose::from_xyz_rpy(units.lengths(three("xyz")?), units.angles(three("rpy")?)))
}

fn placed(table: &Table<'_>, units: Units) -> Result<Placed, IoError> {
    table.only(&["xyz", "rpy", "known"])?;
    placed_at(table, units)
}

fn placed_at(table: &Table<'_>, units: Units) -> Result<Placed, IoError> {
    let known = table.get("known").map_or(Ok(true), |value| value.boolean())?;
    Ok(Placed { pose: pose(table, units)?, known })
}

fn gravity(root: &Table<'_>) -> Result<Gravity, IoError> {
    let mut gravity = Gravity::default();
    if let Some(value) = root.get("gravity") {
        gravity.vector = Vector3::from(value.numbers::<3>()?);
    }
    if let Some(value) = root.get("gravity_frame") {
        gravity.frame =
            value.word(&[("measurement", GravityFrame::Measurement), ("base", GravityFrame::Base)])?;
    }
    Ok(gravity)
}

#[cfg(test)]
mod tests;
