//! The points of the first of some modules, with the frames and tools with which all of them use it.

use super::file::{Candidate, File, Motion, bare};
use super::node::Node;
use crate::Dialect;
use crate::flow::{Active, of_all};
use crate::number::{Form, Slot};
use crate::program::{Branch, Definitions, Note, Point, Program, Reference, Step, Value};
use std::ops::Range;

/// From here on RAPID takes an external axis for absent (9E9).
const ABSENT: f64 = 8.9e9;

pub(super) fn program(text: &[u8], files: &[File], definitions: Definitions) -> Program {
    let file = &files[0];
    let unused = || Reference::Unknown("no motion in the files given goes to it".into());
    let mut points = Vec::new();
    for candidate in &file.candidates {
        let of = |motion: &Motion| [motion.frame.clone(), motion.tool.clone()];
        let uses: Vec<Active> = match candidate.inline {
            Some(number) => file.motions.get(number).map(of).into_iter().collect(),
            None => files
                .iter()
                .flat_map(|file| &file.motions)
                .filter(|motion| motion.names.iter().any(|name| means(name, &candidate.name)))
                .map(of)
                .collect(),
        };
        let mut active = of_all(uses.iter(), &[unused(), unused()]);
        if let Some((line, word)) = files.iter().find_map(|file| file.displaced.clone()) {
            active[0] = Reference::Unknown(format!("{word} in line {line} displaces the program"));
        }
        let changed =
            files.iter().flat_map(|file| &file.changed).find(|(name, _)| means(name, &candidate.name));
        points.push(point(text, candidate, active, changed));
    }
    let mut order = Vec::new();
    let mut notes = Vec::new();
    for (place, file) in files.iter().enumerate() {
        for (number, motion) in file.motions.iter().enumerate() {
            let mut found = false;
            for (k, candidate) in files[0].candidates.iter().enumerate() {
                let here = match candidate.inline {
                    Some(inline) => place == 0 && inline == number,
                    None => motion.names.iter().any(|name| means(name, &candidate.name)),
                };
                if here {
                    found = true;
                    order.push(Step::Point(k));
                }
            }
            if motion.computed || !found {
                order.push(Step::Elsewhere);
                notes.extend(note(motion, files, place, found));
            }
        }
    }
    Program { dialect: Dialect::Rapid, text: text.to_vec(), points, definitions, order, notes }
}

fn means(to: &str, name: &str) -> bool {
    to == name || (bare(to) == bare(name) && (to.contains('*') || name.contains('*')))
}

fn note(motion: &Motion, files: &[File], place: usize, found: bool) -> Option<Note> {
    let refusing = |words: &str| {
        Some(Note { file: place, ..Note::refusing(motion.line, motion.shown.clone(), words.into()) })
    };
    if motion.computed {
        return refusing(
            "the position is computed while the program runs: from a compensated point it comes out displaced",
        );
    }
    let name = motion.names.first()?;
    let known = |name: &str| files.iter().skip(1).any(|f| f.candidates.iter().any(|c| means(name, &c.name)));
    if found || place > 0 || known(name) {
        return None;
    }
    if let Some((_, line)) = files.iter().flat_map(|file| &file.changed).find(|(other, _)| means(other, name))
    {
        return refusing(&format!("its value is computed in line {line}, maybe from a compensated point"));
    }
    Some(Note::missing(motion.line, motion.shown.clone(), name.clone()))
}

fn point(text: &[u8], candidate: &Candidate, active: Active, changed: Option<&(String, usize)>) -> Point {
    let slot = |(range, form): (&Range<usize>, Form)| Slot::padded(text, range.clone(), form);
    let items = candidate.node.items();
    let mut point = Point {
        name: candidate.name.clone(),
        line: candidate.line,
        value: Value::Joints(Vec::new()),
        external: Vec::new(),
        fixed: changed.map(|(_, line)| format!("line {line} changes it while the program runs")),
        slots: Vec::new(),
        written: Vec::new(),
        turns: Vec::new(),
    };
    if let Some(axes) = items.last() {
        point.external = external(axes);
    }
    if candidate.joints {
        match items.first().and_then(|joints| joints.numbers(6)).filter(|_| items.len() == 2) {
            Some(joints) => {
                point.value = Value::Joints(joints.iter().map(|(value, _)| *value).collect());
                point.slots = joints.iter().map(|(_, range)| slot((range, Form::Real(5)))).collect();
            }
            None => point.fixed = Some("it is not two lists of six numbers".into()),
        }
        return point;
    }
    let parts = match items {
        [place, turn, config, _] => place.numbers(3).zip(turn.numbers(4)).zip(config.numbers(4)),
        _ => None,
    };
    let Some(((place, turn), config)) = parts else {
        point.fixed = Some("it is not made of numbers".into());
        return point;
    };
    let numbers: Vec<f64> = place.iter().chain(&turn).map(|(value, _)| *value).collect();
    let whole = config.iter().all(|(value, _)| value.fract() == 0.0 && value.abs() < 1e6);
    let Some(pose) = Dialect::Rapid.pose(&numbers).filter(|_| whole) else {
        let words = if whole {
            "its quaternion is not of length 1"
        } else {
            "its configuration is not made of whole numbers"
        };
        point.fixed = Some(words.into());
        return point;
    };
    let [cf1, cf4, cf6, cfx] = [0, 1, 2, 3].map(|k| config[k].0 as i64);
    let [frame, tool] = active;
    point.value = Value::Pose { pose, frame, tool, branch: Branch::Abb([cf1, cf4, cf6, cfx]) };
    point.written = numbers;
    point.slots = place.iter().map(|(_, range)| slot((range, Form::Real(3)))).collect();
    point.slots.extend(turn.iter().map(|(_, range)| slot((range, Form::Real(7)))));
    point.turns = config[..3].iter().map(|(_, range)| slot((range, Form::Whole))).collect();
    point
}

/// External axes that are there and not at zero.
fn external(axes: &Node) -> Vec<(String, f64)> {
    let letter = |k: usize| format!("eax_{}", char::from(b'a' + k as u8));
    let value = |node: &Node| match node {
        Node::Number(value, _) => *value,
        _ => f64::NAN,
    };
    axes.items()
        .iter()
        .take(6)
        .enumerate()
        .map(|(k, node)| (letter(k), value(node)))
        .filter(|(_, value)| !(*value == 0.0 || *value > ABSENT))
        .collect()
}
