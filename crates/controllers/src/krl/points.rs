//! The points of the first of some files, with the frames and tools with which all of them use it.

use super::candidate::{Candidate, Literal};
use super::file::{File, Motion, bare};
use crate::Dialect;
use crate::definitions::Definitions;
use crate::event::Visit;
use crate::flow::{Active, LOAD, of_all};
use crate::note::Note;
use crate::program::{Branch, Point, Program, Value};
use crate::reference::{Carried, Reference};
use std::collections::HashMap;

pub(super) fn program(text: &[u8], files: &[File], definitions: Definitions) -> Program {
    let file = &files[0];
    let uses = Uses::of(files);
    let mut points = Vec::new();
    for candidate in &file.candidates {
        let all = uses.of_point(files, &candidate.name);
        if let Literal::Pose { frame: true, .. } = candidate.kind
            && candidate.inline.is_none()
            && all.is_empty()
        {
            continue;
        }
        let none = of_frame_data(&candidate.name, &definitions);
        let active = match candidate.inline {
            Some(used) => file.uses[used].clone(),
            None => {
                let direct = all.iter().filter(|(_, motion)| !motion.computed);
                of_all(direct.map(|(file, motion)| &file.uses[motion.used]), &none)
            }
        };
        let carried = definitions.load(&active[LOAD]);
        let whole = candidate.auxiliary.then(|| candidate.oriented(destination(candidate, files)));
        let candidate = whole.as_ref().unwrap_or(candidate);
        points.push(Point { carried, ..point(candidate, active, uses.change(&candidate.name)) });
    }
    let places = Places::of(&points);
    let mut route = Vec::new();
    let mut notes = Vec::new();
    for (place, file) in files.iter().enumerate() {
        let mut visits = |number: usize| {
            let motion = &file.motions[number];
            let at = places.of_motion(motion, place);
            if let Some(words) = &motion.head.odd {
                notes.push(motion.head.refusing(place, words));
            } else if at.is_empty() || motion.computed {
                notes.extend(note(motion, files, &uses, place));
            }
            vec![Visit::event(
                if motion.computed { Vec::new() } else { at },
                motion.head.linear,
                motion.head.line,
            )]
        };
        route.push(file.steps.iter().flat_map(|step| step.events(&mut visits)).collect());
        notes.extend(odd(file, files, place));
    }
    Program { dialect: Dialect::Krl, text: text.to_vec(), points, definitions, route, notes }
}

/// The destination of the circular motion of the first file that has this point on its way.
fn destination<'f>(on_the_way: &Candidate, files: &'f [File]) -> Option<&'f Candidate> {
    let of_motion = |motion: &&Motion| on_the_way.inline == Some(motion.used);
    let name = files[0].motions.iter().filter(of_motion).nth(1)?.name.as_deref();
    let is = |other: &&Candidate| match name {
        Some(name) => other.inline.is_none() && other.name == name,
        None => other.inline == on_the_way.inline && !other.auxiliary,
    };
    files.iter().take(if name.is_some() { files.len() } else { 1 }).flat_map(|file| &file.candidates).find(is)
}

/// Statements that are no motions and have a point in them.
fn odd(file: &File, files: &[File], place: usize) -> Vec<Note> {
    let point = |name: &String| {
        let declared = files.iter().flat_map(|file| &file.declared);
        declared.into_iter().any(|(other, kind)| other == name && kind != "FRAME")
    };
    let mut notes = Vec::new();
    for (line, name, names, motion) in &file.odd {
        let words = match names.iter().find(|name| point(name)) {
            Some(point) => format!("{point} is given to a statement that is not understood: whether the robot moves there is not known"),
            None if *motion => "a statement with a position that is not understood: whether the robot moves there is not known".into(),
            None => continue,
        };
        notes.push(Note { file: place, ..Note::refusing(*line, name.clone(), words) });
    }
    notes
}

/// Motions and changes by the names that they have.
struct Uses {
    /// File and motion.
    motions: HashMap<String, Vec<(usize, usize)>>,
    changed: HashMap<String, Vec<(String, usize)>>,
}

impl Uses {
    fn of(files: &[File]) -> Uses {
        let mut uses = Uses { motions: HashMap::new(), changed: HashMap::new() };
        for (f, file) in files.iter().enumerate() {
            for (k, motion) in file.motions.iter().enumerate() {
                if let Some(name) = &motion.name {
                    uses.motions.entry(bare(name).into()).or_default().push((f, k));
                }
            }
            for (name, line) in &file.changed {
                uses.changed.entry(bare(name).into()).or_default().push((name.clone(), *line));
            }
        }
        uses
    }

    /// The motions to a name, with their files.
    fn of_point<'f>(&self, files: &'f [File], name: &str) -> Vec<(&'f File, &'f Motion)> {
        let all = self.motions.get(bare(name)).into_iter().flatten();
        let all = all.map(|&(f, k)| (&files[f], &files[f].motions[k]));
        all.filter(|(_, motion)| motion.name.as_deref().is_some_and(|to| means(to, name))).collect()
    }

    fn change(&self, name: &str) -> Option<&(String, usize)> {
        self.changed.get(bare(name))?.iter().find(|(other, _)| means(other, name))
    }
}

/// Whether a reference to `to` may be to `name`.
pub(super) fn means(to: &str, name: &str) -> bool {
    to == name || (bare(to) == bare(name) && (to.contains("[*]") || name.contains("[*]")))
}

/// Points by their names, and by the lines of those in motions.
struct Places {
    named: HashMap<String, Vec<(String, usize)>>,
    lines: HashMap<usize, Vec<usize>>,
}

impl Places {
    fn of(points: &[Point]) -> Places {
        let mut places = Places { named: HashMap::new(), lines: HashMap::new() };
        for (k, point) in points.iter().enumerate() {
            if point.name.contains(" in line ") {
                places.lines.entry(point.line).or_default().push(k);
            } else {
                places.named.entry(bare(&point.name).into()).or_default().push((point.name.clone(), k));
            }
        }
        places
    }

    /// The points to which a motion goes.
    fn of_motion(&self, motion: &Motion, place: usize) -> Vec<usize> {
        match &motion.name {
            Some(name) => {
                let all = self.named.get(bare(name)).into_iter().flatten();
                all.filter(|(other, _)| means(name, other)).map(|(_, k)| *k).collect()
            }
            None if place == 0 && motion.inline && !motion.computed => {
                self.lines.get(&motion.head.line).cloned().unwrap_or_default()
            }
            None => Vec::new(),
        }
    }
}

/// Frame and tool of the point's FDAT: XP1 has FP1.
fn of_frame_data(name: &str, definitions: &Definitions) -> Active {
    let data = name.strip_prefix('X').map(|rest| format!("F{rest}"));
    let of = |part: &str| {
        let key = data.as_ref().map(|data| format!("{data}.{part}"));
        match key.filter(|key| definitions.0.contains_key(key)) {
            Some(key) => Reference::Named(key),
            None => Reference::Unknown("no motion in the files given goes to it".into()),
        }
    };
    [of("BASE_NO"), of("TOOL_NO"), of("LOAD_NO")]
}

/// Bit 4 of S: taught with an absolutely accurate robot.
const OWN_MODEL: i64 = 16;

fn point(candidate: &Candidate, active: Active, changed: Option<&(String, usize)>) -> Point {
    let mut fixed = candidate.incomplete.clone();
    if let Some((_, line)) = changed {
        fixed = Some(format!("line {line} changes it while the program runs"));
    }
    let value = match &candidate.kind {
        Literal::Axes(values) => Value::Joints(values.clone()),
        Literal::Pose { numbers, status, turn, .. } => {
            let pose = Dialect::Krl.pose(numbers);
            if status.is_some_and(|status| status & OWN_MODEL != 0) {
                let words = "S states that it was taught with the controller's own absolute-accuracy model: both corrections would add up";
                fixed.get_or_insert_with(|| words.into());
            }
            let branch = match status {
                Some(status) => Branch::Kuka { status: *status, turn: *turn },
                None => Branch::Continuous,
            };
            let [frame, tool, _] = active;
            let pose = pose.unwrap_or_else(|| {
                fixed.get_or_insert_with(|| "its numbers are no pose".into());
                truepose_kinematics::Pose::IDENTITY
            });
            Value::Pose { pose, frame, tool, branch }
        }
    };
    Point {
        name: candidate.name.clone(),
        line: candidate.line,
        value,
        external: candidate.external.clone(),
        carried: Carried::unstated(),
        fixed,
        slots: candidate.slots.clone(),
        written: match &candidate.kind {
            Literal::Axes(numbers) | Literal::Pose { numbers, .. } => numbers.clone(),
        },
        turns: candidate.turns.clone(),
    }
}

/// What there is to say of a motion that goes to no literal of the first file.
fn note(motion: &Motion, files: &[File], uses: &Uses, place: usize) -> Option<Note> {
    let name = motion.name.as_deref().unwrap_or("");
    let refusing = |words: &str| Some(motion.head.refusing(place, words));
    if motion.computed {
        return refusing(
            "the position is computed while the program runs: from a compensated point it comes out displaced",
        );
    }
    if name.starts_with('$') {
        // Where the robot is or was; other positions of the controller stay as they are.
        let here =
            ["_ACT", "_ACT_MES", "_RET", "_INT", "_FOR", "_BACK"].iter().any(|end| name.ends_with(end));
        return (!here && place == 0).then(|| motion.head.missing(place, name));
    }
    let elsewhere = files.iter().skip(1).any(|file| file.candidates.iter().any(|c| means(name, &c.name)));
    if elsewhere || place > 0 {
        return None;
    }
    if let Some((_, line)) = uses.change(name) {
        return refusing(&format!("its value is computed in line {line}, maybe from a compensated point"));
    }
    Some(motion.head.missing(place, name))
}
