//! ABB's configuration of motion, `MOC.cfg`: where the robot's base is in the world.
//!
//! ```text
//! MOC:CFG_1.0:5:0::
//! ROBOT:
//!       -name "ROB_1" -use_joint_1 "rob1_1" \
//!       -base_frame_pos_x 0.5  … _y _z  -base_frame_orient_u0 1 … _u1 _u2 _u3      m, quaternion; absent: 0, u0 1
//! ```
//!
//! A base that a track moves (`-base_frame_coordinated`) is left to `--external`.

use crate::Dialect;
use crate::program::{Definition, Definitions};
use truepose_kinematics::Pose;

/// Whether a text is one of these.
pub(super) fn is(text: &[u8]) -> bool {
    text.trim_ascii_start().get(..4).is_some_and(|head| head.eq_ignore_ascii_case(b"MOC:"))
}

/// `$ROBROOT`, where it is not the world.
pub(super) fn read(text: &[u8], definitions: &mut Definitions) {
    let text = String::from_utf8_lossy(text);
    let mut section = "";
    let mut robots: Vec<[f64; 7]> = Vec::new();
    let mut moved = false;
    let mut words =
        text.lines().filter(|line| !line.starts_with('#')).flat_map(str::split_whitespace).peekable();
    while let Some(word) = words.next() {
        if let Some(name) = word.strip_suffix(':').filter(|name| !name.starts_with(['-', '"'])) {
            section = name;
        }
        if section != "ROBOT" {
            continue;
        }
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
