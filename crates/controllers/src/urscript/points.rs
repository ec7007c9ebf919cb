//! The points of the first of some scripts, with the frames and tools with which all of them use it.

use super::expression::{Expression, Six};
use super::file::{File, Motion};
use crate::Dialect;
use crate::flow::{FRAME, TOOL};
use crate::number::{Form, Slot};
use crate::program::{Branch, Definition, Definitions, Note, Point, Program, Reference, Step, Value};
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
    files: &'f [File],
}

impl<'f> Names<'f> {
    fn values(&self, name: &str) -> Vec<(usize, &'f Expression, usize)> {
        let all =
            self.files.iter().enumerate().flat_map(|(k, file)| file.assigned.iter().map(move |a| (k, a)));
        all.filter(|(_, (other, ..))| other == name).map(|(k, (_, value, line))| (k, value, *line)).collect()
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
        match self.values(name)[..] {
            [(_, Expression::Pose(six) | Expression::Joints(six), _)] => {
                Some(six).filter(|_| self.changed(name).is_none())
            }
            _ => None,
        }
    }

    fn changed(&self, name: &str) -> Option<usize> {
        let all = self.files.iter().flat_map(|file| &file.changed);
        all.filter(|(other, _)| other == name).map(|(_, line)| *line).next()
    }

    fn frame(&self, expression: Option<&'f Expression>) -> Reference {
        match expression {
            None => Reference::Identity,
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
    uses: Vec<[Reference; 2]>,
    near: Vec<Option<Vec<f64>>>,
}

pub(super) fn program(text: &[u8], files: &[File]) -> Program {
    let names = Names { files };
    let mut definitions = Definitions::default();
    let mut found: Vec<Found<'_>> = Vec::new();
    let mut order = Vec::new();
    let mut notes = Vec::new();
    for (place, file) in files.iter().enumerate() {
        for motion in &file.motions {
            let target = apart(&motion.target);
            let mut active = file.uses[motion.used].clone();
            active[FRAME] = names.frame(target.frame);
            if let Reference::Named(name) = &active[TOOL]
                && let Some(pose) = names.named(name).and_then(|six| Dialect::UrScript.pose(&six.values))
            {
                definitions.put(name.clone(), Definition::Value(pose));
            }
            let near = target.near.map(|near| names.literal(near).map(|six| six.values.to_vec()));
            let literals = literals(&names, &target, motion, place);
            if literals.is_empty() {
                order.push(Step::Elsewhere);
                notes.extend(note(&names, &target, motion, place));
            }
            for (name, six, joints, fixed) in literals {
                let at = found.iter().position(|other| other.six.ranges == six.ranges);
                let at = at.unwrap_or_else(|| {
                    let (uses, near) = (Vec::new(), Vec::new());
                    found.push(Found { name, six, joints, fixed, uses, near });
                    found.len() - 1
                });
                found[at].uses.push(active.clone());
                found[at].near.push(near.clone().flatten());
                order.push(Step::Point(at));
            }
        }
    }
    let points = found.iter().map(|found| point(text, found)).collect();
    let mut program =
        Program { dialect: Dialect::UrScript, text: text.to_vec(), points, definitions, order, notes };
    in_order_of_text(&mut program);
    program
}

/// Points in the order of the text, not of the motions.
fn in_order_of_text(program: &mut Program) {
    let start = |point: &Point| point.slots.first().map_or(0, |slot| slot.range.start);
    let mut places: Vec<usize> = (0..program.points.len()).collect();
    places.sort_by_key(|&k| start(&program.points[k]));
    let mut to = vec![0; places.len()];
    places.iter().enumerate().for_each(|(new, &old)| to[old] = new);
    for step in &mut program.order {
        if let Step::Point(k) = step {
            *k = to[*k];
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
            vec![(format!("{} in line {}", motion.verb, motion.line), six, false, None)]
        }
        Expression::Joints(six) if place == 0 => {
            vec![(format!("{} in line {}", motion.verb, motion.line), six, true, None)]
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
                .into_iter()
                .filter_map(|(file, value, _)| match value {
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
            let note = Note::missing(motion.line, motion.verb.clone(), name.clone());
            return Some(Note { file: place, ..note });
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
    Some(Note { file: place, ..Note::refusing(motion.line, motion.verb.clone(), words.into()) })
}

fn point(text: &[u8], found: &Found<'_>) -> Point {
    let unused = || Reference::Unknown("no motion goes to it".into());
    let [frame, tool] = crate::flow::of_all(found.uses.iter(), &[unused(), unused()]);
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
        fixed,
        slots,
        written: found.six.values.to_vec(),
        turns: Vec::new(),
    }
}
