//! The points of the first of some scripts, with the frames and tools with which all of them use it.

use super::expression::{Expression, Six};
use super::file::{File, Motion};
use crate::Dialect;
use crate::definitions::{Definition, Definitions};
use crate::event::{Event, Visit};
use crate::flow::{Active, FRAME, LOAD, of_all, unknown};
use crate::note::Note;
use crate::number::{Form, Slot};
use crate::program::{Branch, Point, Program, Value};
use crate::reference::Reference;
use std::collections::HashMap;
use truepose_kinematics::Pose;

/// A target taken apart: the literal or name that is a point, its frame, and the joints near it.
struct Target<'e> {
    inner: &'e Expression,
    frame: Option<&'e Expression>,
    near: Option<&'e Expression>,
}

fn apart(target: &Expression) -> Target<'_> {
    match target {
        Expression::Inverse(inner, near) => Target { near: near.as_deref(), ..apart(inner) },
        Expression::In(frame, inner) => match &**inner {
            inner @ (Expression::Pose(_) | Expression::Name(_)) => {
                Target { inner, frame: Some(frame), near: None }
            }
            _ => Target { inner: target, frame: None, near: None },
        },
        _ => Target { inner: target, frame: None, near: None },
    }
}

struct Names<'f> {
    /// File, value and line of each name.
    values: HashMap<&'f str, Vec<(usize, &'f Expression, usize)>>,
    changed: HashMap<&'f str, usize>,
}

impl<'f> Names<'f> {
    fn of(files: &'f [File]) -> Self {
        let mut names = Names { values: HashMap::new(), changed: HashMap::new() };
        for (k, file) in files.iter().enumerate() {
            for (name, value, line) in &file.assigned {
                names.values.entry(name).or_default().push((k, value, *line));
            }
            for (name, line) in &file.changed {
                names.changed.entry(name).or_insert(*line);
            }
        }
        names
    }

    fn values(&self, name: &str) -> &[(usize, &'f Expression, usize)] {
        self.values.get(name).map_or(&[], Vec::as_slice)
    }

    /// The one literal of a name.
    fn literal(&self, expression: &'f Expression) -> Option<&'f Six> {
        match expression {
            Expression::Pose(six) | Expression::Joints(six) => Some(six),
            Expression::Name(name) => self.named(name),
            _ => None,
        }
    }

    fn named(&self, name: &str) -> Option<&'f Six> {
        match *self.values(name) {
            [(_, Expression::Pose(six) | Expression::Joints(six), _)] => {
                Some(six).filter(|_| self.changed(name).is_none())
            }
            _ => None,
        }
    }

    fn changed(&self, name: &str) -> Option<usize> {
        self.changed.get(name).copied()
    }

    /// Whether an expression is a pose or joints, or a name that has them.
    fn is_place(&self, expression: &Expression) -> bool {
        match expression {
            Expression::Pose(_) | Expression::Joints(_) | Expression::In(..) | Expression::Inverse(..) => {
                true
            }
            Expression::Name(name) => self.values(name).iter().any(|(_, value, _)| {
                matches!(
                    value,
                    Expression::Pose(_)
                        | Expression::Joints(_)
                        | Expression::In(..)
                        | Expression::Inverse(..)
                )
            }),
            Expression::Computed => false,
        }
    }

    fn frame(&self, expression: Option<&'f Expression>) -> Reference {
        match expression {
            None => Reference::Identity,
            Some(Expression::Name(name)) if self.named(name).is_some() => Reference::Named(name.clone()),
            Some(expression) => self
                .literal(expression)
                .and_then(|six| Dialect::UrScript.pose(&six.values))
                .map_or(Reference::Unknown("it is computed while the program runs".into()), Reference::Value),
        }
    }
}

/// A point and how motions use it.
struct Found<'f> {
    name: String,
    six: &'f Six,
    joints: bool,
    fixed: Option<String>,
    uses: Vec<Active>,
    near: Vec<Option<Vec<f64>>>,
}

pub(super) fn program(text: &[u8], files: &[File]) -> Program {
    let names = Names::of(files);
    let mut reading = Reading {
        names: &names,
        definitions: Definitions::default(),
        found: Vec::new(),
        places: HashMap::new(),
        notes: Vec::new(),
    };
    let mut route: Vec<Vec<Event>> = Vec::new();
    for (place, file) in files.iter().enumerate() {
        let mut visits = |number: usize| {
            let motion = &file.motions[number];
            vec![Visit::event(reading.motion(file, motion, place), motion.head.linear, motion.head.line)]
        };
        route.push(file.steps.iter().flat_map(|step| step.events(&mut visits)).collect());
        let refusing = |line: &usize, name: &String, words: &str| {
            let note = Note::refusing(*line, name.clone(), words.into());
            Note { file: place, ..note }
        };
        let odd = file.odd.iter().filter(|(.., parts)| parts.iter().any(|part| names.is_place(part)));
        let words = "a function that is not known has a position: whether the robot moves there is not known";
        reading.notes.extend(odd.map(|(line, name, _)| refusing(line, name, words)));
        reading.notes.extend(file.refused.iter().map(|(line, name, words)| refusing(line, name, words)));
    }
    let (notes, mut definitions) = (reading.notes, reading.definitions);
    for (name, load) in files.iter().flat_map(|file| &file.loads) {
        definitions.put(name.clone(), load.clone());
    }
    let points = reading.found.iter().map(|found| point(text, found, &definitions)).collect();
    let mut program =
        Program { dialect: Dialect::UrScript, text: text.to_vec(), points, definitions, route, notes };
    in_order_of_text(&mut program);
    program
}

struct Reading<'f> {
    names: &'f Names<'f>,
    definitions: Definitions,
    found: Vec<Found<'f>>,
    /// By the place of the first number.
    places: HashMap<usize, usize>,
    notes: Vec<Note>,
}

impl<'f> Reading<'f> {
    /// The points to which a motion goes.
    fn motion(&mut self, file: &File, motion: &'f Motion, place: usize) -> Vec<usize> {
        let names = self.names;
        let target = apart(&motion.target);
        let mut active = file.uses[motion.used].clone();
        active[FRAME] = names.frame(target.frame);
        for reference in &active[..LOAD] {
            if let Reference::Named(name) = reference
                && let Some(pose) = names.named(name).and_then(|six| Dialect::UrScript.pose(&six.values))
            {
                self.definitions.put(name.clone(), Definition::Value(pose));
            }
        }
        let near = target.near.map(|near| names.literal(near).map(|six| six.values.to_vec()));
        let literals = literals(names, &target, motion, place);
        if literals.is_empty() {
            self.notes.extend(note(names, &target, motion, place));
        }
        let mut at = Vec::new();
        for (name, six, joints, fixed) in literals {
            let next = self.found.len();
            let k = *self.places.entry(six.ranges[0].start).or_insert(next);
            if k == next {
                let (uses, near) = (Vec::new(), Vec::new());
                self.found.push(Found { name, six, joints, fixed, uses, near });
            }
            self.found[k].uses.push(active.clone());
            self.found[k].near.push(near.clone().flatten());
            at.push(k);
        }
        at
    }
}

/// Points in the order of the text, not of the motions.
fn in_order_of_text(program: &mut Program) {
    let start = |point: &Point| point.slots.first().map_or(0, |slot| slot.range.start);
    let mut places: Vec<usize> = (0..program.points.len()).collect();
    places.sort_by_key(|&k| start(&program.points[k]));
    let mut to = vec![0; places.len()];
    places.iter().enumerate().for_each(|(new, &old)| to[old] = new);
    for event in program.route.iter_mut().flatten() {
        if let Event::Visit(visit) = event {
            visit.points.iter_mut().for_each(|k| *k = to[*k]);
        }
    }
    program.points.sort_by_key(start);
}

/// Name, numbers, whether they are joints, and why it must stay.
type Literal<'f> = (String, &'f Six, bool, Option<String>);

/// The literals of the first file to which a motion goes.
fn literals<'f>(names: &Names<'f>, target: &Target<'f>, motion: &Motion, place: usize) -> Vec<Literal<'f>> {
    match target.inner {
        Expression::Pose(six) if place == 0 => {
            vec![(format!("{} in line {}", motion.head.shown, motion.head.line), six, false, None)]
        }
        Expression::Joints(six) if place == 0 => {
            vec![(format!("{} in line {}", motion.head.shown, motion.head.line), six, true, None)]
        }
        Expression::Name(name) => {
            let values = names.values(name);
            let changed = names.changed(name);
            let computed = values
                .iter()
                .find(|(_, value, _)| !matches!(value, Expression::Pose(_) | Expression::Joints(_)));
            let line = changed.or(computed.map(|(_, _, line)| *line));
            let fixed = line.map(|line| format!("line {line} changes it while the program runs"));
            values
                .iter()
                .filter_map(|&(file, value, _)| match value {
                    Expression::Pose(six) if file == 0 => Some((name.clone(), six, false, fixed.clone())),
                    Expression::Joints(six) if file == 0 => Some((name.clone(), six, true, fixed.clone())),
                    _ => None,
                })
                .collect()
        }
        _ => Vec::new(),
    }
}

fn note(names: &Names<'_>, target: &Target<'_>, motion: &Motion, place: usize) -> Option<Note> {
    if let Expression::Name(name) = target.inner {
        let values = names.values(name);
        if values.is_empty() {
            return Some(motion.head.missing(place, name));
        }
        if values.iter().all(|(file, ..)| *file > 0) || place > 0 {
            return None;
        }
    }
    if place > 0 && matches!(target.inner, Expression::Pose(_) | Expression::Joints(_)) {
        return None;
    }
    let words =
        "the position is computed while the program runs: from a compensated point it comes out displaced";
    Some(motion.head.refusing(place, words))
}

fn point(text: &[u8], found: &Found<'_>, definitions: &Definitions) -> Point {
    let active = of_all(found.uses.iter(), &unknown("no motion goes to it"));
    let carried = definitions.load(&active[LOAD]);
    let [frame, tool, _] = active;
    let mut fixed = found.fixed.clone();
    let mut near = found.near.clone();
    near.dedup();
    let branch = match &near[..] {
        [Some(joints)] => Branch::Near(joints.clone()),
        _ => Branch::Continuous,
    };
    let value = if found.joints {
        Value::Joints(found.six.values.to_vec())
    } else {
        let pose = Dialect::UrScript.pose(&found.six.values).unwrap_or_else(|| {
            fixed.get_or_insert_with(|| "its numbers are no pose".into());
            Pose::IDENTITY
        });
        Value::Pose { pose, frame, tool, branch }
    };
    let slots =
        found.six.ranges.iter().map(|range| Slot::padded(text, range.clone(), Form::Real(6))).collect();
    Point {
        name: found.name.clone(),
        line: found.six.line,
        value,
        external: Vec::new(),
        carried,
        fixed,
        slots,
        written: found.six.values.to_vec(),
        turns: Vec::new(),
    }
}
