//! ABB's configuration: of the motion, `MOC.cfg`, where the robot's base is in the world; of the system, `SYS.cfg`, how loads are stated.
//!
//! ```text
//! MOC:CFG_1.0:5:0::
//! ROBOT:
//!       -name "ROB_1" -use_joint_1 "rob1_1" \
//!       -base_frame_pos_x 0.5  … _y _z  -base_frame_orient_u0 1 … _u1 _u2 _u3      m, quaternion; absent: 0, u0 1
//! SYS:CFG_1.0:6:0::
//! SYS_MISC:
//!       -Name "ModalPayLoadMode" -Value 1          1: GripLoad; 0, or no value: \TLoad. The other one has no effect
//!       -Name "PayloadsInWristCoords" -Value 1     the load of GripLoad is in the flange's frame, not in the tool's
//! ```
//!
//! A base that a track moves (`-base_frame_coordinated`) is left to `--external`. Other topics have no frames, tools or loads.

use crate::definitions::{Definition, Definitions};
use crate::{ControllerError, Dialect};
use truepose_kinematics::Pose;

/// The names of the switches of `SYS_MISC`.
pub(super) const MODAL: &str = "$MODALPAYLOADMODE";
pub(super) const WRIST: &str = "$PAYLOADSINWRISTCOORDS";

/// The topic of a configuration (`MOC`); none of another text.
fn topic(text: &[u8]) -> Option<String> {
    let head: Vec<u8> = text.trim_ascii_start().iter().copied().take(12).collect();
    let head = String::from_utf8_lossy(&head).to_ascii_uppercase();
    let (topic, rest) = head.split_once(':')?;
    rest.starts_with("CFG_").then(|| topic.to_owned())
}

/// Whether a text is one of these.
pub(super) fn is(text: &[u8]) -> bool {
    topic(text).is_some()
}

/// `$ROBROOT`, where it is not the world; switches of loads.
///
/// # Errors
/// When it is of another topic.
pub(super) fn read(text: &[u8], definitions: &mut Definitions) -> Result<(), ControllerError> {
    match topic(text).as_deref() {
        Some("MOC") => base(text, definitions),
        Some("SYS") => switches(text, definitions),
        other => {
            return Err(ControllerError::NotAProgram(format!(
                "it is the controller's configuration of the topic {}, which has no frames, tools or loads (read are MOC.cfg and SYS.cfg)",
                other.unwrap_or("?")
            )));
        }
    }
    Ok(())
}

/// Sections with their words.
fn words(text: &str) -> impl Iterator<Item = (&str, &str)> {
    let mut section = "";
    // A line that goes on ends with a backslash, mostly without a blank in front of it.
    let lines =
        text.lines().filter(|line| !line.starts_with('#')).map(|line| line.trim_end().trim_end_matches('\\'));
    lines.flat_map(str::split_whitespace).map(move |word| {
        if let Some(name) = word.strip_suffix(':').filter(|name| !name.starts_with(['-', '"'])) {
            section = name;
        }
        (section, word)
    })
}

fn switches(text: &[u8], definitions: &mut Definitions) {
    let text = String::from_utf8_lossy(text);
    let mut found: Vec<(String, bool)> = Vec::new();
    let mut of_misc = words(&text).filter(|(section, _)| *section == "SYS_MISC").map(|(_, word)| word);
    while let Some(word) = of_misc.next() {
        match (word.to_ascii_lowercase().as_str(), found.last_mut()) {
            ("-name", _) => {
                let name = of_misc.next().unwrap_or("").trim_matches('"').to_ascii_uppercase();
                found.push((format!("${name}"), false));
            }
            ("-value", Some((_, on))) => {
                *on = of_misc.next().is_some_and(|value| value.trim_matches('"') != "0")
            }
            _ => {}
        }
    }
    for (name, on) in found.into_iter().filter(|(name, _)| [MODAL, WRIST].contains(&name.as_str())) {
        definitions.put(name, Definition::Switch(on));
    }
}

fn base(text: &[u8], definitions: &mut Definitions) {
    let text = String::from_utf8_lossy(text);
    let mut robots: Vec<[f64; 7]> = Vec::new();
    let mut moved = false;
    let mut words = words(&text).filter(|(section, _)| *section == "ROBOT").map(|(_, word)| word).peekable();
    while let Some(word) = words.next() {
        match word {
            "-name" => robots.push([0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0]),
            "-base_frame_coordinated" => moved = true,
            _ => {}
        }
        let part =
            word.strip_prefix("-base_frame_").and_then(|part| PARTS.iter().position(|name| *name == part));
        if let (Some(part), Some(robot)) = (part, robots.last_mut()) {
            robot[part] = words.peek().and_then(|value| value.parse().ok()).unwrap_or(f64::NAN);
        }
    }
    let pose = |numbers: &[f64; 7]| {
        let [x, y, z, rest @ ..] = *numbers;
        Dialect::Rapid.pose(&[&[x, y, z].map(|value| 1e3 * value)[..], &rest].concat())
    };
    let poses: Vec<Option<Pose>> = robots.iter().map(pose).collect();
    let [first, others @ ..] = &poses[..] else { return };
    let unusable = |words: &str| Definition::Unusable(format!("the robot's base (MOC.cfg) {words}"));
    let definition = match *first {
        _ if moved => return,
        _ if others.iter().any(|other| other != first) => unusable("is that of several robots"),
        Some(pose) => Definition::Value(pose),
        None => unusable("is not made of numbers"),
    };
    definitions.put("$ROBROOT".into(), definition);
}

const PARTS: [&str; 7] = ["pos_x", "pos_y", "pos_z", "orient_u0", "orient_u1", "orient_u2", "orient_u3"];
