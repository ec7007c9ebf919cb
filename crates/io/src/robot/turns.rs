//! Angles of a description that nobody means in radians.

use crate::Warning;
use crate::toml_tree::{Table, Value};
use std::f64::consts::TAU;
use std::path::Path;

/// A warning where an angle of a joint, the base or the tool is more than a turn in rad: 90 is a quarter of one in degrees.
pub(super) fn look(root: &Table<'_>, file: &Path, warnings: &mut Vec<Warning>) {
    let places = ["base", "tool"].into_iter().filter_map(|key| Some((key.to_owned(), root.get(key)?)));
    let place = |(name, value): (String, Value<'_>)| in_table(&value, &name);
    let of_joints = || {
        let joints = root.get("joints")?.tables("joints").ok()?;
        joints.iter().find_map(|joint| {
            let name = joint.get("name").and_then(|name| name.string().ok()).unwrap_or_default();
            ["dh", "mdh", "origin"].into_iter().find_map(|key| in_table(&joint.get(key)?, name))
        })
    };
    if let Some((name, key, angle)) = of_joints().or_else(|| places.into_iter().find_map(place)) {
        let message = format!(
            "`{key}` of {name} is {angle} rad, more than a turn, and looks like degrees; if so, set `angle = \"deg\"` in [units]"
        );
        warnings.push(Warning { file: file.into(), line: None, column: None, message });
    }
}

/// Name of the table, key and value of an angle of more than a turn.
fn in_table(value: &Value<'_>, name: &str) -> Option<(String, &'static str, f64)> {
    let table = value.table(name).ok()?;
    let turns = |angle: &f64| angle.abs() > TAU + 1e-3;
    let one = |key: &'static str| {
        let angle = table.get(key)?.number().ok().filter(turns)?;
        Some((name.to_owned(), key, angle))
    };
    let rpy =
        || Some((name.to_owned(), "rpy", table.get("rpy")?.numbers::<3>().ok()?.into_iter().find(turns)?));
    one("theta").or_else(|| one("alpha")).or_else(rpy)
}

#[cfg(test)]
mod tests {
    use crate::{RobotOptions, read_robot};

    fn said(text: &str) -> String {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("r.toml");
        std::fs::write(&path, text).unwrap();
        let (_, warnings) = read_robot(&path, &RobotOptions::default()).unwrap();
        warnings.iter().map(|warning| warning.message.clone()).collect::<Vec<_>>().join("\n")
    }

    #[test]
    fn degrees_under_radians() {
        let words = |key: &str, name: &str| format!("`{key}` of {name} is 90 rad, more than a turn");
        let origin = "[[joints]]\nname = \"A6\"\norigin = { rpy = [0, 90, 0], axis = [0, 0, 1] }\n";
        assert!(said(origin).contains(&words("rpy", "A6")));
        let dh = "[[joints]]\nname = \"j1\"\ndh = { a = 0, alpha = 90 }\n";
        assert!(said(dh).contains(&words("alpha", "j1")));
        let tool = "[[joints]]\nname = \"j1\"\ndh = { a = 0, alpha = 1.5 }\n[tool]\nrpy = [90, 0, 0]\n";
        assert!(said(tool).contains(&words("rpy", "tool")));
        for right in [origin, dh, tool] {
            assert_eq!(said(&format!("units.angle = \"deg\"\n{right}")), "");
        }
    }
}
