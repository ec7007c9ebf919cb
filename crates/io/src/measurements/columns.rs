//! What the columns of a table mean.

use super::coupled;
use super::header_words::{name_and_unit, unit_of};
use super::scalars;
use crate::frame_names::joint_called;
use crate::nearest::{meant, nearest};
use crate::{Quantity, Unit};
use truepose_kinematics::{Chain, JointId, JointKind};

/// The meaning of a column. Numbers count from 0: movable joints, or x y z, or w x y z.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(crate) enum Role {
    Joint(usize),
    Position(usize),
    Quaternion(usize),
    RotationVector(usize),
    /// One of the three angles of an orientation, in the order of its convention.
    Angle(usize),
    Target,
    /// What people call the row: passed through to outputs.
    Id,
    Visit,
    /// The installation in which the row was measured.
    Session,
    /// What was measured.
    Kind,
    /// What of the surroundings the row touched.
    Landmark,
    /// What of the surroundings a camera on the robot saw; only beside a column `kind`.
    Point,
    /// The tool, of a robot that has several.
    Tool,
    /// A measured number, by its place in [`SCALARS`]; only beside a column `kind`.
    Scalar(usize),
    PayloadMass,
    PayloadCentre(usize),
    Force(usize),
    Moment(usize),
    Time,
    Approach(usize),
    PositionSd(usize),
    OrientationSd(usize),
    /// Why a visit was planned: a word of `truepose plan`, for people.
    Note,
    /// Whether the row is used.
    Use,
    /// A column that is not read: left out by the user, a text, or empty.
    Nothing,
    Channel(usize),
}

/// What the cells of a column may hold.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Cells {
    /// A number in every row.
    Number,
    /// A number or nothing.
    Maybe,
    /// An integer in every row.
    Integer,
    /// −1, 0 or +1 in every row.
    Direction,
    /// A target's name or nothing.
    Target,
    /// Any text or number, or nothing; passed through.
    Id,
    /// A name of the session, in every row.
    Session,
    /// A word for what was measured, or nothing.
    Kind,
    /// A name of a landmark, or nothing.
    Landmark,
    /// Likewise.
    Point,
    /// A name of a tool, or nothing.
    Tool,
    /// Anything; not read.
    Note,
    /// Nothing: the column has no name.
    Blank,
    /// Yes or no in every row.
    Use,
}

/// A column with its unit.
#[derive(Debug, Clone)]
pub(crate) struct Column {
    /// The header as in the file.
    pub header: String,
    pub name: String,
    /// The unit of the file.
    pub unit: String,
    /// Whether the header names the unit.
    pub unit_given: bool,
    pub conversion: Unit,
    pub role: Role,
    pub cells: Cells,
    pub meaning: String,
}

/// The column of the tool.
const TOOL: &str = "tool";

/// Columns with a meaning of their own, apart from joints and directions of approach.
pub(crate) const FIXED: [(&str, Role); 35] = [
    ("x", Role::Position(0)),
    ("y", Role::Position(1)),
    ("z", Role::Position(2)),
    ("qw", Role::Quaternion(0)),
    ("qx", Role::Quaternion(1)),
    ("qy", Role::Quaternion(2)),
    ("qz", Role::Quaternion(3)),
    ("rx", Role::RotationVector(0)),
    ("ry", Role::RotationVector(1)),
    ("rz", Role::RotationVector(2)),
    ("target", Role::Target),
    ("id", Role::Id),
    ("visit", Role::Visit),
    ("session", Role::Session),
    ("kind", Role::Kind),
    ("landmark", Role::Landmark),
    ("payload", Role::PayloadMass),
    ("cx", Role::PayloadCentre(0)),
    ("cy", Role::PayloadCentre(1)),
    ("cz", Role::PayloadCentre(2)),
    ("fx", Role::Force(0)),
    ("fy", Role::Force(1)),
    ("fz", Role::Force(2)),
    ("tx", Role::Moment(0)),
    ("ty", Role::Moment(1)),
    ("tz", Role::Moment(2)),
    ("time", Role::Time),
    ("sx", Role::PositionSd(0)),
    ("sy", Role::PositionSd(1)),
    ("sz", Role::PositionSd(2)),
    ("srx", Role::OrientationSd(0)),
    ("sry", Role::OrientationSd(1)),
    ("srz", Role::OrientationSd(2)),
    ("why", Role::Note),
    ("use", Role::Use),
];

impl Role {
    /// The role of a column of this name; `channels` is how many channels stand before it.
    ///
    /// # Errors
    /// Why a column cannot bear this name.
    pub fn of(name: &str, chain: &Chain, channels: usize) -> Result<Role, String> {
        if let Some(joint) = joint_called(chain, name) {
            return match chain.coordinate(joint) {
                Some(k) if !chain.is_commanded(k) => {
                    let driver = chain.mimics().iter().find(|mimic| mimic.joint == joint);
                    let driver = driver.map_or("", |mimic| &chain.joint(mimic.driver).name);
                    Err(format!(
                        "joint `{name}` mimics `{driver}` and has no value of its own; remove the column, or leave it out (`[columns] ignore`)"
                    ))
                }
                Some(k) => Ok(Role::Joint(k)),
                None => Err(format!("joint `{name}` is fixed and has no values; remove the column")),
            };
        }
        // On a robot with one tool it is a column like any other.
        if name == TOOL && chain.tools().len() > 1 {
            return Ok(Role::Tool);
        }
        if let Some((_, role)) = FIXED.iter().find(|(word, _)| *word == name) {
            return Ok(*role);
        }
        if let Some(joint) = name.strip_prefix("approach_") {
            return match joint_called(chain, joint).and_then(|j| chain.coordinate(j)) {
                Some(k) => Ok(Role::Approach(k)),
                None => {
                    let joints = || joint_names(chain);
                    let hint = meant(joint, joints());
                    let joints = crate::nearest::listed(joints());
                    Err(format!("the robot has no moving joint `{joint}`{hint} (its joints: {joints})"))
                }
            };
        }
        Ok(Role::Channel(channels))
    }

    /// What its numbers measure; none for texts, counts and channels.
    pub fn quantity(self, chain: &Chain) -> Option<Quantity> {
        match self {
            Role::Joint(k) => Some(joint_quantity(chain, k)),
            Role::Position(_) | Role::PayloadCentre(_) | Role::PositionSd(_) => Some(Quantity::Length),
            Role::Scalar(k) => Some(scalars::quantity(k)),
            Role::RotationVector(_) | Role::Angle(_) | Role::OrientationSd(_) => Some(Quantity::Angle),
            Role::Quaternion(_)
            | Role::Approach(_)
            | Role::Target
            | Role::Id
            | Role::Visit
            | Role::Session
            | Role::Kind
            | Role::Landmark
            | Role::Point
            | Role::Tool
            | Role::Note
            | Role::Use
            | Role::Nothing => Some(Quantity::Ratio),
            Role::PayloadMass => Some(Quantity::Mass),
            Role::Force(_) => Some(Quantity::Force),
            Role::Moment(_) => Some(Quantity::Moment),
            Role::Time => Some(Quantity::Time),
            Role::Channel(_) => None,
        }
    }

    pub fn cells(self) -> Cells {
        match self {
            Role::Joint(_) | Role::PayloadMass | Role::Time | Role::Channel(_) => Cells::Number,
            Role::Visit => Cells::Integer,
            Role::Approach(_) => Cells::Direction,
            Role::Target => Cells::Target,
            Role::Id => Cells::Id,
            Role::Session => Cells::Session,
            Role::Kind => Cells::Kind,
            Role::Landmark => Cells::Landmark,
            Role::Point => Cells::Point,
            Role::Tool => Cells::Tool,
            Role::Note | Role::Nothing => Cells::Note,
            Role::Use => Cells::Use,
            _ => Cells::Maybe,
        }
    }

    /// The meaning in words.
    pub fn meaning(self, chain: &Chain) -> String {
        let xyz = |k: usize| ["x", "y", "z"][k];
        match self {
            Role::Joint(k) => {
                let joint = chain.joint(chain.movable()[k]);
                let kind = if joint.kind == JointKind::Prismatic { "prismatic" } else { "revolute" };
                format!("value of {kind} joint {}", chain.movable()[k].0)
            }
            Role::Position(k) => format!("measured position, {}", xyz(k)),
            Role::Quaternion(k) => format!("measured orientation, quaternion {}", ["w", "x", "y", "z"][k]),
            Role::RotationVector(k) => format!("measured orientation, rotation vector {}", xyz(k)),
            Role::Angle(k) => format!("measured orientation, angle {} of its convention", k + 1),
            Role::Target => "measured target".into(),
            Role::Id => "name of the row, passed through to outputs".into(),
            Role::Visit => "visit".into(),
            Role::Kind => "kind of observation".into(),
            Role::Landmark => "landmark that was observed".into(),
            Role::Point => "landmark that a camera on the robot saw".into(),
            Role::Tool => "tool".into(),
            Role::Scalar(k) => scalars::MEANINGS[k].into(),
            Role::Session => "session: installation of robot and instrument".into(),
            Role::PayloadMass => "mass carried".into(),
            Role::PayloadCentre(k) => format!("centre of gravity of the mass, tool frame, {}", xyz(k)),
            Role::Force(k) => format!("force of the load, tool axes, {}", xyz(k)),
            Role::Moment(k) => format!("moment of the load, tool axes, {}", xyz(k)),
            Role::Time => "time of measurement".into(),
            Role::Approach(k) => {
                format!("direction of approach of {}", chain.joint(chain.movable()[k]).name)
            }
            Role::PositionSd(k) => format!("stated standard deviation of the position, {}", xyz(k)),
            Role::OrientationSd(k) => format!("stated standard deviation of the orientation, {}", xyz(k)),
            Role::Note => "a word for people, not read".into(),
            Role::Use => "whether the row is used".into(),
            Role::Nothing => "not read".into(),
            Role::Channel(_) => "channel".into(),
        }
    }
}

impl Column {
    /// A column from a header cell in our own spelling.
    #[cfg(test)]
    pub fn parse(header: &str, chain: &Chain, channels: usize) -> Result<(Column, Option<String>), String> {
        Column::named(header, header, (chain, None), channels)
    }

    /// A column that is not read.
    pub fn unread(header: &str, cells: Cells) -> Column {
        Column {
            header: header.into(),
            name: header.into(),
            unit: "1".into(),
            unit_given: false,
            conversion: *Quantity::Ratio.si(),
            role: Role::Nothing,
            cells,
            meaning: "not read".into(),
        }
    }

    /// A column from its header cell in the file and the name and unit that this stands for, on a robot and in a role where that is known
    /// otherwise than by the name; the second value is a warning.
    ///
    /// # Errors
    /// What is wrong with the header, and what to do.
    pub fn named(
        shown: &str,
        header: &str,
        (chain, role): (&Chain, Option<Role>),
        channels: usize,
    ) -> Result<(Column, Option<String>), String> {
        let (name, unit) = name_and_unit(header)?;
        let role = match role {
            Some(role) => role,
            None => Role::of(name, chain, channels)?,
        };
        let mut warning = None;
        let (unit, unit_given, conversion, meaning) = match (role.quantity(chain), unit) {
            (Some(quantity), Some(word)) => {
                let conversion = unit_of(word, name, quantity)?;
                (word.to_string(), true, conversion, role.meaning(chain))
            }
            (Some(quantity), None) => {
                let si = quantity.si();
                if quantity != Quantity::Ratio {
                    let word = si.word;
                    warning = Some(format!("has no unit and is taken as [{word}]; write `{name}[{word}]`"));
                }
                (si.word.to_string(), false, *si, role.meaning(chain))
            }
            (None, unit) => {
                looks_like_a_joint(name, unit, chain)?;
                let known = FIXED.iter().map(|(word, _)| *word).chain(joint_names(chain));
                if let Some(near) = nearest(name, known) {
                    warning = Some(format!("is taken as a channel; did you mean `{near}`?"));
                }
                let word = unit.unwrap_or("1");
                match Unit::named(word) {
                    Some(named) if named.quantity == Quantity::Temperature => {
                        (word.to_string(), true, *named, "channel, a temperature".to_string())
                    }
                    _ => (word.to_string(), unit.is_some(), *Quantity::Ratio.si(), role.meaning(chain)),
                }
            }
        };
        let cells = role.cells();
        let column = Column {
            header: shown.into(),
            name: name.into(),
            unit,
            unit_given,
            conversion,
            role,
            cells,
            meaning,
        };
        Ok((column, warning))
    }
}

/// Refuses `j7[rad]` on a robot whose joints are `j1` … `j6`: an angle or a length under a joint's kind of name.
fn looks_like_a_joint(name: &str, unit: Option<&str>, chain: &Chain) -> Result<(), String> {
    let stem = |name: &str| name.trim_end_matches(|c: char| c.is_ascii_digit()).to_string();
    let numbered = |name: &str| name.ends_with(|c: char| c.is_ascii_digit()) && !stem(name).is_empty();
    let measures = unit.and_then(Unit::named).map(|unit| unit.quantity);
    let alike = |joint: &str| numbered(joint) && stem(joint) == stem(name);
    if numbered(name)
        && matches!(measures, Some(Quantity::Angle | Quantity::Length))
        && joint_names(chain).any(alike)
    {
        let joints = crate::nearest::listed(joint_names(chain));
        return Err(format!(
            "the robot has no moving joint `{name}` (its joints: {joints}); remove the column, or give it another \
             name if it is a channel"
        ));
    }
    Ok(())
}

pub(crate) fn joint_quantity(chain: &Chain, k: usize) -> Quantity {
    match chain.joint(chain.movable()[k]).kind {
        JointKind::Prismatic => Quantity::Length,
        _ => Quantity::Angle,
    }
}

/// Names of the movable joints.
pub(crate) fn joint_names(chain: &Chain) -> impl Iterator<Item = &str> + Clone {
    chain.movable().iter().map(|&joint| chain.joint(joint).name.as_str())
}

/// The joint whose value the column of each movable joint holds: its own, or that of the joint that it follows.
pub(crate) fn columns_of(chain: &Chain) -> impl Iterator<Item = JointId> {
    (0..chain.movable().len()).map(move |k| chain.movable()[coupled::column_of(chain, k)])
}

#[cfg(test)]
mod tests;
