//! The points of the first of some files, with the frames and tools with which all of them use it.

use super::candidate::{Candidate, Literal};
use super::file::{File, Motion, bare};
use crate::Dialect;
use crate::flow::{Active, of_all};
use crate::program::{Branch, Definitions, Note, Point, Program, Reference, Step, Value};

pub(super) fn program(text: &[u8], files: &[File], definitions: Definitions) -> Program {
    let file = &files[0];
    let moves = |name: &str| moves(files, name);
    let mut points = Vec::new();
    for candidate in &file.candidates {
        if let Literal::Pose { frame: true, .. } = candidate.kind
            && candidate.inline.is_none()
            && moves(&candidate.name).is_empty()
        {
            continue;
        }
        let none = of_frame_data(&candidate.name, &definitions);
        let active = match candidate.inline {
            Some(used) => file.uses[used].clone(),
            None => {
                let all = moves(&candidate.name);
                let direct = all.iter().filter(|(_, motion)| !motion.computed);
                of_all(direct.map(|(file, motion)| &file.uses[motion.used]), &none)
            }
        };
        let changed =
            files.iter().flat_map(|file| &file.changed).find(|(name, _)| means(name, &candidate.name));
        points.push(point(candidate, active, changed));
    }
    let mut order = Vec::new();
    let mut notes = Vec::new();
    for (place, file) in files.iter().enumerate() {
        for motion in &file.motions {
            let at = candidates_of(motion, file, place, &points);
            if at.is_empty() || motion.computed {
                order.push(Step::Elsewhere);
                notes.extend(note(motion, files, place));
            }
            if !motion.computed {
                order.extend(at.into_iter().map(Step::Point));
            }
        }
    }
    Program { dialect: Dialect::Krl, text: text.to_vec(), points, definitions, order, notes }
}

/// The motions to a name, with their files.
fn moves<'f>(files: &'f [File], name: &str) -> Vec<(&'f File, &'f Motion)> {
    let all = files.iter().flat_map(|file| file.motions.iter().map(move |motion| (file, motion)));
    all.filter(|(_, motion)| motion.name.as_deref().is_some_and(|to| means(to, name))).collect()
}

/// Whether a reference to `to` may be to `name`.
fn means(to: &str, name: &str) -> bool {
    to == name || (bare(to) == bare(name) && (to.contains("[*]") || name.contains("[*]")))
}

/// The points to which a motion goes.
fn candidates_of(motion: &Motion, file: &File, place: usize, points: &[Point]) -> Vec<usize> {
    let of = |keep: &dyn Fn(&Point) -> bool| {
        points.iter().enumerate().filter(|(_, point)| keep(point)).map(|(k, _)| k).collect()
    };
    match &motion.name {
        Some(name) => of(&|point| means(name, &point.name)),
        None if place == 0 && motion.inline && !motion.computed => {
            let lines: Vec<usize> = file
                .candidates
                .iter()
                .filter(|c| c.inline == Some(motion.used) && c.line == motion.line)
                .map(|c| c.line)
                .collect();
            of(&|point| point.name.contains(" in line ") && lines.contains(&point.line))
        }
        None => Vec::new(),
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
    [of("BASE_NO"), of("TOOL_NO")]
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
            let [frame, tool] = active;
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
        fixed,
        slots: candidate.slots.clone(),
        written: match &candidate.kind {
            Literal::Axes(numbers) | Literal::Pose { numbers, .. } => numbers.clone(),
        },
        turns: candidate.turns.clone(),
    }
}

/// What there is to say of a motion that goes to no literal of the first file.
fn note(motion: &Motion, files: &[File], place: usize) -> Option<Note> {
    let name = motion.name.as_deref().unwrap_or("");
    let refusing = |words: &str| {
        Some(Note { file: place, ..Note::refusing(motion.line, motion.shown.clone(), words.into()) })
    };
    if motion.computed {
        return refusing(
            "the position is computed while the program runs: from a compensated point it comes out displaced",
        );
    }
    if name.starts_with('$') {
        return None;
    }
    let elsewhere = files.iter().skip(1).any(|file| file.candidates.iter().any(|c| means(name, &c.name)));
    if elsewhere || place > 0 {
        return None;
    }
    if let Some((_, line)) = files.iter().flat_map(|file| &file.changed).find(|(other, _)| means(other, name))
    {
        return refusing(&format!("its value is computed in line {line}, maybe from a compensated point"));
    }
    Some(Note::missing(motion.line, motion.shown.clone(), name.into()))
}
