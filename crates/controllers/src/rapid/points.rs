//! The points of the first of some modules, with the frames and tools with which all of them use it.

use super::file::{Candidate, Destination, File, Motion, bare};
use super::node::Node;
use crate::Dialect;
use crate::definitions::Definitions;
use crate::event::Visit;
use crate::flow::{Active, of_all, unknown};
use crate::note::Note;
use crate::number::{Form, Slot};
use crate::program::{Branch, Point, Program, Value};
use crate::reference::{Carried, Reference};
use std::collections::{HashMap, HashSet};
use std::ops::Range;

/// From here on RAPID takes an external axis for absent (9E9).
const ABSENT: f64 = 8.9e9;

pub(super) fn program(text: &[u8], files: &[File], definitions: Definitions) -> Program {
    let names = Names::of(files);
    let grips = files.iter().any(|file| file.grip.any);
    let displaced = files.iter().find_map(|file| file.displaced.clone());
    let mut points = Vec::new();
    // The point of each candidate.
    let mut places: Vec<Option<usize>> = Vec::new();
    for candidate in &files[0].candidates {
        let motions: Vec<(&File, &Motion)> = match candidate.inline {
            Some(number) => {
                files[0].motions.get(number).map(|motion| (&files[0], motion)).into_iter().collect()
            }
            None => names.motions_to(files, &candidate.name).collect(),
        };
        let of =
            |(_, motion): &(&File, &Motion)| [motion.frame.clone(), motion.tool.clone(), Reference::Identity];
        let uses: Vec<Active> = motions.iter().map(of).collect();
        let external = candidate.inline.is_none() && names.external.contains(bare(&candidate.name));
        if external && uses.is_empty() {
            places.push(None);
            continue;
        }
        let mut active = of_all(uses.iter(), &unknown("no motion in the files given goes to it"));
        if let Some((line, word)) = &displaced {
            active[0] = Reference::Unknown(format!("{word} in line {line} displaces the program"));
        }
        let mut point = point(text, candidate, active, names.change(&candidate.name));
        if external {
            let words = "a motion of external axes alone uses it as well";
            point.fixed.get_or_insert_with(|| words.into());
        }
        point.carried = carried(&motions, &definitions, grips);
        places.push(Some(points.len()));
        points.push(point);
    }
    let mut route = Vec::new();
    let mut notes = Vec::new();
    for (place, file) in files.iter().enumerate() {
        let mut visits = |number: usize| {
            let motion = &file.motions[number];
            notes.extend(motion.head.odd.as_deref().map(|words| motion.head.refusing(place, words)));
            let mut visits = Vec::new();
            for destination in &motion.destinations {
                let at: Vec<usize> = match destination {
                    Destination::Inline(candidate) if place == 0 => {
                        places.get(*candidate).copied().flatten().into_iter().collect()
                    }
                    Destination::Name(name) => {
                        names.candidates(files, name).filter_map(|k| places[k]).collect()
                    }
                    _ => Vec::new(),
                };
                if at.is_empty() {
                    notes.extend(note(motion, destination, files, &names, place));
                }
                visits.push(Visit::event(at, motion.head.linear, motion.head.line));
            }
            visits
        };
        route.push(file.steps.iter().flat_map(|step| step.events(&mut visits)).collect());
        notes.extend(odd(file, &names, place));
    }
    Program { dialect: Dialect::Rapid, text: text.to_vec(), points, definitions, route, notes }
}

/// The one load of all motions to a point.
fn carried(motions: &[(&File, &Motion)], definitions: &Definitions, grips: bool) -> Carried {
    let of =
        |(file, motion): &(&File, &Motion)| motion.load.carried(&motion.tool, &file.grip, definitions, grips);
    let mut all = motions.iter().map(of);
    let Some(first) = all.next() else { return Carried::unstated() };
    match all.all(|other| other == first) {
        true => first,
        false => Carried::Open("it is used with several loads".into()),
    }
}

fn means(to: &str, name: &str) -> bool {
    to == name || (bare(to) == bare(name) && (to.contains('*') || name.contains('*')))
}

/// What there is under a name.
struct Names<'f> {
    /// File and motion.
    motions: HashMap<&'f str, Vec<(usize, usize)>>,
    changed: HashMap<&'f str, Vec<&'f (String, usize)>>,
    /// Of the first file.
    candidates: HashMap<&'f str, Vec<usize>>,
    /// With a value in another file.
    elsewhere: HashSet<&'f str>,
    declared: HashSet<&'f str>,
    external: HashSet<&'f str>,
}

impl<'f> Names<'f> {
    fn of(files: &'f [File]) -> Self {
        let mut names = Names {
            motions: HashMap::new(),
            changed: HashMap::new(),
            candidates: HashMap::new(),
            elsewhere: HashSet::new(),
            declared: HashSet::new(),
            external: HashSet::new(),
        };
        for (f, file) in files.iter().enumerate() {
            for (k, motion) in file.motions.iter().enumerate() {
                for destination in &motion.destinations {
                    if let Destination::Name(name) = destination {
                        names.motions.entry(bare(name)).or_default().push((f, k));
                    }
                }
            }
            for change in &file.changed {
                names.changed.entry(bare(&change.0)).or_default().push(change);
            }
            for (k, candidate) in file.candidates.iter().enumerate().filter(|(_, c)| c.inline.is_none()) {
                if f == 0 {
                    names.candidates.entry(bare(&candidate.name)).or_default().push(k);
                } else {
                    names.elsewhere.insert(bare(&candidate.name));
                }
            }
            names.declared.extend(file.declared.iter().map(|(name, _)| name.as_str()));
            names.external.extend(file.external.iter().map(|name| bare(name)));
        }
        names
    }

    fn motions_to<'a>(
        &'a self,
        files: &'a [File],
        name: &'a str,
    ) -> impl Iterator<Item = (&'a File, &'a Motion)> {
        let all = self.motions.get(bare(name)).into_iter().flatten();
        all.map(|&(f, k)| (&files[f], &files[f].motions[k])).filter(move |(_, motion)| {
            let to =
                |destination: &Destination| matches!(destination, Destination::Name(to) if means(to, name));
            motion.destinations.iter().any(to)
        })
    }

    fn candidates<'a>(&'a self, files: &'a [File], name: &'a str) -> impl Iterator<Item = usize> + 'a {
        let all = self.candidates.get(bare(name)).into_iter().flatten().copied();
        all.filter(move |&k| means(name, &files[0].candidates[k].name))
    }

    fn change(&self, name: &str) -> Option<&'f (String, usize)> {
        self.changed.get(bare(name))?.iter().copied().find(|(other, _)| means(other, name))
    }
}

/// Instructions that are no motions and have a point in them.
fn odd(file: &File, names: &Names<'_>, place: usize) -> Vec<Note> {
    let mut notes = Vec::new();
    for odd in &file.odd {
        let words = match odd.names.iter().find(|name| names.declared.contains(bare(name))) {
            Some(point) => format!(
                "{point} is given to an instruction that is not known: whether the robot moves there is not known"
            ),
            None if odd.literal => {
                "an instruction with a position that is not known: whether the robot moves there is not known"
                    .into()
            }
            None => continue,
        };
        notes.push(Note { file: place, ..Note::refusing(odd.line, odd.shown.clone(), words) });
    }
    notes
}

fn note(
    motion: &Motion,
    destination: &Destination,
    files: &[File],
    names: &Names<'_>,
    place: usize,
) -> Option<Note> {
    let refusing = |words: &str| Some(motion.head.refusing(place, words));
    let name = match destination {
        Destination::Inline(_) => return None,
        Destination::Computed => {
            return refusing(
                "the position is computed while the program runs: from a compensated point it comes out displaced",
            );
        }
        Destination::Name(name) => name,
    };
    if place > 0 || names.elsewhere.contains(bare(name)) || files.is_empty() {
        return None;
    }
    match names.change(name) {
        Some((_, line)) => {
            refusing(&format!("its value is computed in line {line}, maybe from a compensated point"))
        }
        None => Some(motion.head.missing(place, name)),
    }
}

fn point(text: &[u8], candidate: &Candidate, active: Active, changed: Option<&(String, usize)>) -> Point {
    let slot = |(range, form): (&Range<usize>, Form)| Slot::padded(text, range.clone(), form);
    let items = candidate.node.items();
    let mut point = Point {
        fixed: changed.map(|(_, line)| format!("line {line} changes it while the program runs")),
        ..Point::new(candidate.name.clone(), candidate.line)
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
    let [frame, tool, _] = active;
    point.value = Value::Pose { pose, frame, tool, branch: Branch::Abb([cf1, cf4, cf6, cfx]) };
    point.written = numbers;
    point.slots = place.iter().map(|(_, range)| slot((range, Form::Real(3)))).collect();
    point.slots.extend(turn.iter().map(|(_, range)| slot((range, Form::Real(7)))));
    point.turns = config[..3].iter().map(|(_, range)| slot((range, Form::Whole))).collect();
    point
}

/// External axes that are there.
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
        .filter(|(_, value)| value.is_nan() || *value <= ABSENT)
        .collect()
}
