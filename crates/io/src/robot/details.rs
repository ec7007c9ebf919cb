//! What a robot file holds beside the robot: its units, named frames, and the head of a certificate. A TOML of its own may hold the same.

use crate::text::Text;
use crate::toml_tree::{Document, Table};
use crate::{ExportUnits, IoError, Quantity, Unit};
use serde::{Deserialize, Serialize};
use std::path::Path;
use truepose_kinematics::Pose;

/// Keys beside those of the robot.
pub(super) const KEYS: [&str; 2] = ["frames", "certificate"];

/// Units, frames and certificate of a file.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct RobotDetails {
    /// Units of every length and angle of the file; m and rad without any.
    pub units: ExportUnits,
    /// `[[frames]]`.
    pub frames: Vec<NamedFrame>,
    /// `[certificate]`.
    pub certificate: Option<Certificate>,
    /// Whether the file states gravity or its frame; where it does not, −z of the measurement frame is an assumption.
    pub gravity: bool,
}

/// A frame with a name: a work object, or a tool centre point.
#[derive(Debug, Clone, PartialEq)]
pub struct NamedFrame {
    /// Its name.
    pub name: String,
    /// In which frame it is described.
    pub inside: FrameParent,
    /// Its pose there, m.
    pub pose: Pose,
}

/// The frame in which another one is described.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FrameParent {
    /// The robot's base.
    Base,
    /// The frame of the measurements.
    Measurement,
    /// The frame of the last joint: what it places moves with the robot.
    Flange,
}

/// Texts of the head of a report; none is required.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Certificate {
    /// Names and texts in the order of the file.
    pub entries: Vec<(String, String)>,
}

/// Keys of `[certificate]`, with the words of the page.
const ENTRIES: [(&str, &str); 13] = [
    ("number", "certificate"),
    ("customer", "customer"),
    ("robot", "robot"),
    ("serial", "serial number"),
    ("controller", "controller"),
    ("instrument", "instrument"),
    ("instrument_serial", "serial number of the instrument"),
    ("traceability", "traceability"),
    ("operator", "operator"),
    ("date", "date of measurement"),
    ("place", "place"),
    ("environment", "environment"),
    ("remarks", "remarks"),
];

/// Reads what a TOML holds beside a robot; a URDF holds nothing, and neither does a pipe.
///
/// # Errors
/// When the file cannot be read, or one of these parts is wrong. Other keys are not read.
pub fn read_details(path: impl AsRef<Path>) -> Result<RobotDetails, IoError> {
    let path = path.as_ref();
    // What is no regular file can be read once, by the reader of the robot.
    if !path.is_file() || !path.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("toml")) {
        return Ok(RobotDetails::default());
    }
    let text = Text::read(path)?;
    let document = Document::parse(&text)?;
    of(&document.root("the file"))
}

/// The same, checked as part of a robot file.
pub(super) fn of(root: &Table<'_>) -> Result<RobotDetails, IoError> {
    let units = units(root)?;
    let mut frames: Vec<NamedFrame> = Vec::new();
    if let Some(list) = root.get("frames") {
        for table in list.tables("frames")? {
            table.only(&["name", "in", "xyz", "rpy"])?;
            let name = table.require("name")?;
            let word = name.string()?;
            if ["base", "measurement", "flange", ""].contains(&word) {
                return Err(name.error(format!("a frame cannot be called `{word}`")));
            }
            if frames.iter().any(|other| other.name == word) {
                return Err(name.error(format!("two frames have the name `{word}`; names must be different")));
            }
            let inside = match table.get("in") {
                None => FrameParent::Base,
                Some(value) => value.word(&[
                    ("base", FrameParent::Base),
                    ("measurement", FrameParent::Measurement),
                    ("flange", FrameParent::Flange),
                ])?,
            };
            let three = |key: &str| table.get(key).map_or(Ok([0.0; 3]), |value| value.numbers::<3>());
            let xyz = three("xyz")?.map(|v| units.length.to_si(v));
            let rpy = three("rpy")?.map(|v| units.angle.to_si(v));
            frames.push(NamedFrame { name: word.into(), inside, pose: Pose::from_xyz_rpy(xyz, rpy) });
        }
    }
    let certificate = match root.get("certificate") {
        None => None,
        Some(value) => {
            let table = value.table("[certificate]")?;
            table.only(&ENTRIES.map(|(key, _)| key))?;
            let mut entries = Vec::new();
            for (key, word) in ENTRIES {
                if let Some(value) = table.get(key) {
                    entries.push((word.to_owned(), value.string()?.to_owned()));
                }
            }
            Some(Certificate { entries })
        }
    };
    let gravity = root.get("gravity").is_some() || root.get("gravity_frame").is_some();
    Ok(RobotDetails { units, frames, certificate, gravity })
}

pub(super) fn units(root: &Table<'_>) -> Result<ExportUnits, IoError> {
    let mut found = ExportUnits::default();
    let Some(units) = root.get("units") else { return Ok(found) };
    let units = units.table("[units]")?;
    for (key, slot, quantity) in
        [("length", &mut found.length, Quantity::Length), ("angle", &mut found.angle, Quantity::Angle)]
    {
        if let Some(value) = units.get(key) {
            let named = Unit::named(value.string()?).filter(|unit| unit.quantity == quantity);
            *slot = *named.ok_or_else(|| value.error(format!("this is no unit of {}", quantity.word())))?;
        }
    }
    Ok(found)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str) -> Result<RobotDetails, String> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("r.toml");
        std::fs::write(&path, text).unwrap();
        read_details(&path).map_err(|e| e.to_string().replace(&format!("{}/", folder.path().display()), ""))
    }

    #[test]
    fn frames_and_certificate_are_read_in_the_units_of_the_file() {
        let found = read(
            "name = \"arm\"\n[units]\nlength = \"mm\"\nangle = \"deg\"\n[[frames]]\nname = \"table\"\nxyz = [100, 0, 50]\nrpy = [0, 0, 90]\n\
             [[frames]]\nname = \"gun\"\nin = \"flange\"\n[certificate]\noperator = \"N. N.\"\nserial = \"17\"\n",
        )
        .unwrap();
        assert_eq!((found.units.length.word, found.units.angle.word), ("mm", "deg"));
        assert_eq!(found.frames[0].pose.translation.x.to_bits(), 0.1f64.to_bits());
        assert!((found.frames[0].pose.rotation[(1, 0)] - 1.0).abs() < 1e-15);
        assert_eq!(
            [found.frames[0].inside, found.frames[1].inside],
            [FrameParent::Base, FrameParent::Flange]
        );
        let entries = found.certificate.unwrap().entries;
        assert_eq!(entries[0], ("serial number".into(), "17".into()));
        assert_eq!(entries[1].0, "operator");
    }

    #[test]
    fn what_is_wrong_has_its_place() {
        let error = read("[[frames]]\nname = \"base\"\n").unwrap_err();
        assert_eq!(error, "r.toml:2:8: a frame cannot be called `base`");
        let error = read("[certificate]\nserail = \"1\"\n").unwrap_err();
        assert!(
            error.starts_with("r.toml:2:1: unknown key `serail` in [certificate]; did you mean `serial`?"),
            "{error}"
        );
        assert_eq!(read("").unwrap(), RobotDetails::default());
    }
}
