//! Joint origins as the kinematics file of ROS drivers, which `ur_description` made a habit.
//!
//! ```yaml
//! kinematics:
//!   shoulder: {x, y, z, roll, pitch, yaw}      # m, rad: origin of the joint, turned about the fixed axes x, y, z
//! ```
//!
//! Joints with the names of Universal Robots' description stand under its words for the links; all others under their own.
//! What such a file has no place for (base, tool, what was left out) is under a key of ours, `truepose`.

use super::origins::JointOrigins;
use std::fmt::Write;
use truepose_kinematics::Pose;

/// Names of Universal Robots' joints, and their words in its kinematics files.
const UR: [(&str, &str); 6] = [
    ("shoulder_pan_joint", "shoulder"),
    ("shoulder_lift_joint", "upper_arm"),
    ("elbow_joint", "forearm"),
    ("wrist_1_joint", "wrist_1"),
    ("wrist_2_joint", "wrist_2"),
    ("wrist_3_joint", "wrist_3"),
];

impl JointOrigins {
    /// The origins as YAML, in m and rad, with digits that read back to the same numbers; `statement` goes into
    /// comments at the front.
    pub fn to_ros_yaml(&self, statement: &[String]) -> String {
        let mut out = String::new();
        // Writing to a String cannot fail.
        let _ = self.write_yaml(statement, &mut out);
        out
    }

    fn write_yaml(&self, statement: &[String], out: &mut String) -> std::fmt::Result {
        for line in statement {
            writeln!(out, "# {line}")?;
        }
        writeln!(out, "# x y z in m; roll, pitch, yaw about the fixed axes x, y, z in rad")?;
        writeln!(out, "kinematics:")?;
        for joint in &self.joints {
            let key = UR.iter().find(|(name, _)| *name == joint.name).map_or(joint.name.as_str(), |ur| ur.1);
            writeln!(out, "  {}:", quoted(key))?;
            entry("    ", &joint.pose, out)?;
        }
        writeln!(out, "truepose:")?;
        for (key, pose) in [("base", &self.base), ("tool", &self.tools[0])] {
            writeln!(out, "  {key}:")?;
            entry("    ", pose, out)?;
        }
        let turned = |axis: &[f64]| axis != [0.0, 0.0, 1.0];
        if self.joints.iter().any(|joint| turned(joint.axis.as_slice())) {
            writeln!(out, "  axes:")?;
            for joint in &self.joints {
                let [x, y, z] = joint.axis.into_inner().into();
                writeln!(out, "    {}: [{x:?}, {y:?}, {z:?}]", quoted(&joint.name))?;
            }
        }
        Ok(())
    }
}

pub(super) fn entry(indent: &str, pose: &Pose, out: &mut String) -> std::fmt::Result {
    let [roll, pitch, yaw] = pose.rpy();
    let [x, y, z] = pose.translation.into();
    let named = [("x", x), ("y", y), ("z", z), ("roll", roll), ("pitch", pitch), ("yaw", yaw)];
    named.iter().try_for_each(|(name, value)| writeln!(out, "{indent}{name}: {}", number(*value)))
}

/// With a point even where there is an exponent: readers of YAML 1.1 take `1e-5` for a text.
fn number(value: f64) -> String {
    let shown = format!("{value:?}");
    match shown.split_once('e') {
        Some((digits, exponent)) => {
            let point = if digits.contains('.') { "" } else { ".0" };
            let sign = if exponent.starts_with('-') { "" } else { "+" };
            format!("{digits}{point}e{sign}{exponent}")
        }
        None => shown,
    }
}

/// A key as it is where that is plain, else in quotes.
pub(super) fn quoted(key: &str) -> String {
    let plain = key.starts_with(|c: char| c.is_ascii_alphabetic())
        && key.chars().all(|c| c.is_ascii_alphanumeric() || c == '_')
        && !["y", "n", "yes", "no", "on", "off", "true", "false", "null"]
            .contains(&key.to_lowercase().as_str());
    if plain {
        return key.into();
    }
    let escaped: String = key.chars().map(escaped).collect();
    format!("\"{escaped}\"")
}

/// A character inside of double quotes.
fn escaped(c: char) -> String {
    match c {
        '\\' | '"' => format!("\\{c}"),
        // Line ends of YAML 1.1, and what it cannot show.
        c if c.is_control()
            || matches!(c, '\u{2028}' | '\u{2029}' | '\u{feff}' | '\u{fffe}' | '\u{ffff}') =>
        {
            format!("\\u{:04x}", u32::from(c))
        }
        c => c.into(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_numbers_to_every_reader() {
        for (value, shown) in
            [(1e-5, "1.0e-5"), (-2.5e-7, "-2.5e-7"), (0.1, "0.1"), (1e300, "1.0e+300"), (0.0, "0.0")]
        {
            assert_eq!(number(value), shown);
            assert!((number(value).parse::<f64>().expect("a number") - value).abs() <= 0.0);
        }
    }

    #[test]
    fn keys_that_mean_something_else_are_quoted() {
        assert_eq!(quoted("wrist_1"), "wrist_1");
        assert_eq!(quoted("y"), "\"y\"");
        assert_eq!(quoted("1st"), "\"1st\"");
        assert_eq!(quoted("a: b"), "\"a: b\"");
        assert_eq!(quoted("a\u{85}b\u{2028}\\\""), "\"a\\u0085b\\u2028\\\\\\\"\"");
    }
}
