//! Stäubli VAL3 data, `.dtx` (format 2 of VAL3's `Data`).
//!
//! ```text
//! <Data name="pPick" type="pointRx" …> <Value key="0" x="…" y="…" z="…" rx="…" ry="…" rz="…" … fatherId="fPart[0]"/> </Data>
//! <Data name="jHome" type="jointRx" …> <Value key="0" j1="…" … j6="…"/> </Data>
//! <Data name="fPart" type="frame" …>   <Data name="tGripper" type="tool" …>
//! ```
//!
//! An absent number is zero. The tool of a point is in the program (`.pgx`), not in the data: it has to be given.

mod tags;

use crate::definitions::{Definition, Definitions};
use crate::error::syntax;
use crate::event::Visit;
use crate::note::Note;
use crate::number::{Form, Slot, number_at};
use crate::program::{Branch, Point, Value};
use crate::reference::Reference;
use crate::{ControllerError, Dialect, Program};
use std::collections::BTreeMap;
use tags::{Tag, tags};
use truepose_kinematics::Pose;

const POSE: [&str; 6] = ["x", "y", "z", "rx", "ry", "rz"];
const JOINTS: [&str; 6] = ["j1", "j2", "j3", "j4", "j5", "j6"];

pub(crate) fn read(text: &[u8], others: &[&[u8]]) -> Result<Program, ControllerError> {
    let mut frames = BTreeMap::new();
    let mut notes = Vec::new();
    let points = file(text, &mut frames, &mut notes)?;
    for (k, other) in others.iter().enumerate() {
        file(other, &mut frames, &mut Vec::new()).map_err(|error| error.in_other(k))?;
    }
    let mut definitions = Definitions::default();
    for name in ["world[0]", "flange[0]"] {
        definitions.put(name.into(), Definition::Value(Pose::IDENTITY));
    }
    for name in frames.keys() {
        let definition = match placed(name, &frames) {
            Some(pose) => Definition::Value(pose),
            None => Definition::Unusable(format!("the frame under {name} is not in the files given")),
        };
        definitions.put(name.clone(), definition);
    }
    let visit = |(k, point): (usize, &Point)| Visit::event(vec![k], false, point.line);
    let route = vec![points.iter().enumerate().map(visit).collect()];
    Ok(Program { dialect: Dialect::Val3, text: text.to_vec(), points, definitions, route, notes })
}

/// A frame or tool, and what it stands on.
type Frames = BTreeMap<String, (Pose, String)>;

fn placed(name: &str, frames: &Frames) -> Option<Pose> {
    let mut pose = Pose::IDENTITY;
    let mut name = name;
    for _ in 0..32 {
        if name == "world[0]" || name == "flange[0]" {
            return Some(pose);
        }
        let (own, father) = frames.get(name)?;
        pose = *own * pose;
        name = father;
    }
    None
}

fn file(text: &[u8], frames: &mut Frames, notes: &mut Vec<Note>) -> Result<Vec<Point>, ControllerError> {
    let mut points = Vec::new();
    let mut data: Option<(String, String)> = None;
    let mut any = false;
    for tag in tags(text)? {
        match (tag.name, tag.closes) {
            ("Data", false) => {
                any = true;
                let of = |name: &str| tag.shown(text, name).unwrap_or_default();
                data = Some((of("name"), of("type")));
            }
            ("Data", true) => data = None,
            ("Value", false) => {
                let Some((name, kind)) = &data else { continue };
                let key = tag.shown(text, "key").unwrap_or_else(|| "0".into());
                let name = format!("{name}[{key}]");
                match kind.as_str() {
                    "pointRx" | "pointRs" | "point" => points.push(point(text, name, &tag)),
                    "jointRx" | "joint" => points.push(joints(text, name, &tag, &JOINTS)),
                    // Of arms with four axes.
                    "jointRs" => points.push(joints(text, name, &tag, &JOINTS[..4])),
                    "frame" | "tool" => {
                        let root = if kind == "frame" { "world[0]" } else { "flange[0]" };
                        let father = tag.shown(text, "fatherId").unwrap_or_else(|| root.into());
                        if let Some(pose) = numbers(text, &tag, &POSE).and_then(|n| Dialect::Val3.pose(&n)) {
                            frames.insert(name, (pose, father));
                        }
                    }
                    // A distance between frames, not a place.
                    "trsf" => {}
                    _ if tag.value("j1").is_some()
                        || (tag.value("x").is_some() && tag.value("rx").is_some()) =>
                    {
                        let words = format!("data of the type `{kind}` has a position and is not understood");
                        notes.push(Note::refusing(tag.line, name, words));
                    }
                    _ => {}
                }
            }
            _ => {}
        }
    }
    if !any {
        return Err(syntax(text, 0, "it has no <Data …> of VAL3's data files (format 2)"));
    }
    Ok(points)
}

/// The numbers of attributes; an absent one is zero, one that is no number makes none of them.
fn numbers(text: &[u8], tag: &Tag<'_>, names: &[&str]) -> Option<Vec<f64>> {
    let one = |name: &&str| match tag.value(name) {
        None => Some(0.0),
        Some(range) => {
            let bytes = &text[range.clone()];
            number_at(bytes).filter(|(_, length)| *length == bytes.len()).map(|(value, _)| value)
        }
    };
    names.iter().map(one).collect()
}

fn slots(tag: &Tag<'_>, names: &[&'static str], least: [usize; 6]) -> Vec<Slot> {
    let behind = names.iter().filter_map(|name| tag.value(name)).map(|range| range.end + 1).max();
    let behind = behind.unwrap_or(tag.behind_name);
    let one = |(name, least): (&&'static str, usize)| match tag.value(name) {
        Some(range) => Slot { range, form: Form::Real(least) },
        None => Slot { range: behind..behind, form: Form::Absent(name, least) },
    };
    names.iter().zip(least).map(one).collect()
}

fn point(text: &[u8], name: String, tag: &Tag<'_>) -> Point {
    let mut point = Point::new(name, tag.line);
    point.written = numbers(text, tag, &POSE).unwrap_or_default();
    let Some(pose) = Dialect::Val3.pose(&point.written) else {
        point.fixed = Some("it is not made of numbers".into());
        return point;
    };
    let frame = match tag.shown(text, "fatherId").as_deref() {
        None | Some("world[0]") => Reference::Identity,
        Some(name) => Reference::Named(name.into()),
    };
    let tool = Reference::Unknown("VAL3 has the tool in the program, not in the data".into());
    // A word of each, or none where it is that of the point before (same) or any (free).
    let mut side = |name: &str, yes: &str, no: &str| match tag.shown(text, name).as_deref() {
        Some(word) if word == yes => Some(true),
        Some(word) if word == no => Some(false),
        Some(word) if !(word.ends_with("same") || word.ends_with("free")) => {
            point.fixed = Some(format!("its {name} `{word}` is not understood"));
            None
        }
        _ => None,
    };
    let lefty = side("shoulder", "lefty", "righty");
    let elbow = side("elbow", "epositive", "enegative");
    let wrist = side("wrist", "wpositive", "wnegative");
    let branch = match (lefty, elbow, wrist) {
        (None, None, None) => Branch::Continuous,
        _ => Branch::Val3 { lefty, elbow, wrist },
    };
    point.slots = slots(tag, &POSE, [3, 3, 3, 4, 4, 4]);
    point.value = Value::Pose { pose, frame, tool, branch };
    point
}

fn joints(text: &[u8], name: String, tag: &Tag<'_>, names: &[&'static str]) -> Point {
    let mut point = Point::new(name, tag.line);
    match numbers(text, tag, names) {
        Some(numbers) => {
            point.slots = slots(tag, names, [5; 6]);
            point.value = Value::Joints(numbers);
        }
        None => point.fixed = Some("it is not made of numbers".into()),
    }
    point
}
