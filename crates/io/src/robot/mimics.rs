//! `mimic` of joints of a robot description: joints that follow others and have no column of their own.

use crate::IoError;
use crate::Unit;
use crate::frame_names::{joint_called, joint_name};
use crate::nearest::meant;
use crate::toml_tree::{Table, Value};
use truepose_kinematics::{Chain, ChainError, JointId, JointKind, Mimic};

/// The robot with the joints that follow others; every error joins the others.
pub(super) fn with_mimics(
    joints: &[Table<'_>],
    chain: Chain,
    (length, angle): (&Unit, &Unit),
    errors: &mut Vec<IoError>,
) -> Result<Chain, IoError> {
    let mut mimics: Vec<(Mimic, Value<'_>)> = Vec::new();
    for table in joints {
        let Some(value) = table.get("mimic") else { continue };
        match mimic(table, &value, &chain, (length, angle)) {
            Ok(found) => mimics.push((found, value)),
            Err(error) => errors.push(error),
        }
    }
    if mimics.is_empty() || !errors.is_empty() {
        return Ok(chain);
    }
    let name = |joint: JointId| chain.joint(joint).name.clone();
    let places: Vec<(String, &Value<'_>)> =
        mimics.iter().map(|(of, value)| (name(of.joint), value)).collect();
    chain.clone().with_mimics(mimics.iter().map(|(mimic, _)| *mimic).collect()).map_err(|error| {
        let of = |wanted: &str| places.iter().find(|(name, _)| name == wanted).or(places.first());
        match &error {
            ChainError::Mimic { name, .. } => of(name)
                .map_or_else(|| joints[0].error(error.to_string()), |(_, at)| at.error(error.to_string())),
            _ => places[0].1.error(error.to_string()),
        }
    })
}

fn mimic(
    table: &Table<'_>,
    value: &Value<'_>,
    chain: &Chain,
    (length, angle): (&Unit, &Unit),
) -> Result<Mimic, IoError> {
    let called = joint_name(table.require("name")?.string()?);
    let inner = value.table(&format!("`mimic` of joint `{called}`"))?;
    inner.only(&["joint", "ratio", "offset"])?;
    let at = inner.require("joint")?;
    let word = at.string()?;
    let moving = |joint: &JointId| chain.joint(*joint).moves();
    let joint = chain.joint_named(&called).filter(moving);
    let joint =
        joint.ok_or_else(|| value.error(format!("joint `{called}` is fixed and follows no other one")))?;
    let driver = joint_called(chain, word).filter(moving).ok_or_else(|| {
        let names = chain.movable().iter().map(|&joint| chain.joint(joint).name.as_str());
        let hint = meant(word, names.clone());
        let known: Vec<&str> = names.collect();
        at.error(format!("the robot has no moving joint `{word}`{hint} (its joints: {})", known.join(", ")))
    })?;
    let unit = |joint: JointId| if chain.joint(joint).kind == JointKind::Prismatic { length } else { angle };
    let (own, others) = (unit(joint), unit(driver));
    let number = |key: &str, default: f64| inner.get(key).map_or(Ok(default), |value| value.number());
    let ratio = own.to_si(number("ratio", 1.0)?) / others.to_si(1.0);
    Ok(Mimic { joint, driver, ratio, offset: own.to_si(number("offset", 0.0)?) })
}

#[cfg(test)]
mod tests {
    use crate::{RobotOptions, robot_from_text};

    const ROBOT: &str = "[units]\nlength = \"mm\"\nangle = \"deg\"\n\
        [[joints]]\nname = \"a\"\norigin = { axis = [0, 0, 1] }\n\
        [[joints]]\nname = \"b\"\nmimic = { joint = \"a\", ratio = -0.5, offset = 90 }\norigin = { xyz = [100, 0, 0], axis = [0, 0, 1] }\n\
        [[joints]]\nname = \"s\"\ntype = \"prismatic\"\nmimic = { joint = \"b\", ratio = 2, offset = 10 }\norigin = { axis = [1, 0, 0] }\n\
        [[joints]]\nname = \"t\"\ntype = \"fixed\"\norigin = { xyz = [50, 0, 0] }\n";

    #[test]
    fn a_joint_follows_in_the_units_of_the_file() {
        let (chain, _) = robot_from_text("r.toml", ROBOT, &RobotOptions::default()).unwrap();
        let mut q = [0.4, 0.0, 0.0];
        chain.joints_from_controller(&mut q);
        let b = -0.2 + std::f64::consts::FRAC_PI_2;
        assert!((q[1] - b).abs() < 1e-15);
        assert!((q[2] - (2e-3 * b.to_degrees() + 0.01)).abs() < 1e-15);
    }

    #[test]
    fn what_is_wrong_is_said_with_its_place() {
        for (from, to, words) in [
            ("joint = \"a\"", "joint = \"aa\"", "r.toml:9:19: the robot has no moving joint `aa`"),
            ("joint = \"a\"", "joint = \"t\"", "r.toml:9:19: the robot has no moving joint `t`"),
            (
                "joint = \"a\"",
                "joint = \"s\"",
                "r.toml:9:9: joint `b` cannot mimic: joints follow each other in a circle",
            ),
            (
                "joint = \"a\"",
                "joint = \"b\"",
                "r.toml:9:9: joint `b` cannot mimic: joints follow each other in a circle",
            ),
            ("ratio = -0.5", "ratio = 0", "`ratio` has to be a finite number other than zero"),
            ("ratio = -0.5", "factor = 1", "unknown key `factor`"),
            ("joint = \"a\", ", "", "lacks `joint`"),
            (
                "type = \"fixed\"",
                "type = \"fixed\"\nmimic = { joint = \"a\" }",
                "joint `t` is fixed and follows no other one",
            ),
        ] {
            let text = ROBOT.replace(from, to);
            let found = robot_from_text("r.toml", text, &RobotOptions::default()).unwrap_err().to_string();
            assert!(found.contains(words), "{found}");
        }
    }
}
