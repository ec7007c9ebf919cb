//! Yaskawa INFORM, `.jbi`.
//!
//! ```text
//! //POS
//! ///TOOL n   ///USER n   ///POSTYPE PULSE|BASE|ROBOT|USER   ///RCONF …
//! C00001=n,n,n,n,n,n                     pulses of the axes, or X,Y,Z in mm and Rx,Ry,Rz in degrees
//! //INST      (MOVJ|MOVL|MOVC|MOVS) C00001 …     another motion is refused
//! ```
//!
//! The values of user frames and tools are in files of their own (see `frames`): `USER 1`, `TOOL 0` name them. So are pulses per degree
//! (see `parameters`).

mod frames;
mod parameters;
mod stations;

use crate::definitions::{Definition, Definitions, PULSES};
use crate::event::{Event, Visit};
use crate::lines::{Line, lines};
use crate::note::Note;
use crate::number::{Form, Slot, number_at};
use crate::program::{Branch, Point, Value};
use crate::reference::Reference;
use crate::{ControllerError, Dialect, Program};
use stations::Stations;
use std::collections::HashMap;

pub(crate) fn read(text: &[u8], others: &[&[u8]]) -> Result<Program, ControllerError> {
    let lines = lines(text);
    let mut definitions = Definitions::default();
    for text in others.iter().copied().chain([text]).filter(|text| frames::is(text)) {
        frames::read(text, &mut definitions);
    }
    let robot = parameters::robot(text);
    for text in others.iter().copied().chain([text]).filter(|text| parameters::is(text)) {
        if let Some(pulses) = parameters::pulses_per_degree(text, robot) {
            definitions.put(PULSES.into(), Definition::PulsesPerDegree(pulses));
        }
    }
    if !definitions.0.is_empty() && (frames::is(text) || parameters::is(text)) {
        return Ok(Program::of_frames(Dialect::Inform, text, definitions));
    }
    if !lines.iter().any(|line| line.after("/JOB").is_some_and(<[u8]>::is_empty)) {
        let words = match parameters::is(text) {
            true => {
                "it has parameters of the controller (ALL.PRM, RC.PRM), of another layout than those that are read: state the pulses per degree \
                 with --pulses; frames and tools are in UFRAME.CND and TOOL.CND"
            }
            false => {
                "it has no line /JOB: it is no job of INFORM, and it has no frames or tools (UFRAME.CND, TOOL.CND)"
            }
        };
        return Err(ControllerError::NotAProgram(words.into()));
    }
    let head = |word: &str| lines.iter().position(|line| line.after(word).is_some_and(<[u8]>::is_empty));
    let inst = head("//INST").unwrap_or(lines.len());
    for (name, line) in lines.iter().skip(inst).filter_map(changed) {
        let words = format!("line {line} changes {name} while the job runs");
        definitions.0.insert(name, Definition::Unusable(words));
    }
    let mut points = Vec::new();
    let mut stations = Stations::default();
    if let Some(pos) = head("//POS").filter(|&pos| pos < inst) {
        let mut state = State::default();
        for line in &lines[pos + 1..inst] {
            stations.line(line, state.kind.eq_ignore_ascii_case("PULSE"));
            let tool = Reference::Named(format!("{}.W", state.tool()));
            let point = state.line(text, line);
            points.extend(point.map(|point| Point { carried: definitions.load(&tool), ..point }));
        }
    }
    let mut job = Job {
        stations,
        places: HashMap::new(),
        jumps: false,
        shift: None,
        route: Vec::new(),
        notes: Vec::new(),
    };
    for (k, point) in points.iter().enumerate() {
        job.places.extend(key(&point.name).map(|key| (key, k)));
    }
    job.jumps = lines
        .iter()
        .skip(inst + 1)
        .any(|line| ["JUMP", "CALL", "PSTART"].iter().any(|word| line.after(word).is_some()));
    for line in lines.iter().skip(inst + 1) {
        job.instruction(line, &mut points);
    }
    let route = vec![job.route];
    Ok(Program {
        dialect: Dialect::Inform,
        text: text.to_vec(),
        points,
        definitions,
        route,
        notes: job.notes,
    })
}

/// A frame or a tool that an instruction sets: `MFRAME UF#(1) …`, `SETTOOL TL#(2) P000`.
fn changed(line: &Line<'_>) -> Option<(String, usize)> {
    let text = String::from_utf8_lossy(line.trimmed());
    let (kind, list, rest) = [("USER", "UF#(", "MFRAME"), ("TOOL", "TL#(", "SETTOOL")]
        .into_iter()
        .find_map(|(kind, list, verb)| Some((kind, list, text.strip_prefix(verb)?)))?;
    let number: u32 = rest.split_once(list)?.1.split(')').next()?.trim().parse().ok()?;
    Some((format!("{kind} {number}"), line.number))
}

/// What the lines before state about the positions that follow.
#[derive(Debug, Default)]
struct State {
    kind: String,
    user: String,
    tool: String,
    configuration: String,
}

impl State {
    fn line(&mut self, text: &[u8], line: &Line<'_>) -> Option<Point> {
        let rest = |word: &str| line.after(word).map(|rest| String::from_utf8_lossy(rest).trim().to_owned());
        for (word, slot) in [
            ("///POSTYPE", &mut self.kind),
            ("///USER", &mut self.user),
            ("///TOOL", &mut self.tool),
            ("///RCONF", &mut self.configuration),
        ] {
            if let Some(rest) = rest(word) {
                *slot = rest;
                return None;
            }
        }
        let equals = line.bytes.iter().position(|&byte| byte == b'=')?;
        let name = String::from_utf8_lossy(line.bytes[..equals].trim_ascii()).into_owned();
        key(&name)?;
        let mut point = Point::new(name, line.number);
        self.fill(text, line.fields(equals + 1), &mut point);
        Some(point)
    }

    /// Several tools are listed where the job has several groups: the first is the robot's.
    fn tool(&self) -> String {
        format!("TOOL {}", self.tool.split(',').next().unwrap_or("").trim())
    }

    fn fill(&self, text: &[u8], fields: Vec<std::ops::Range<usize>>, point: &mut Point) {
        let one = |range: &std::ops::Range<usize>| {
            let bytes = &text[range.clone()];
            number_at(bytes).filter(|(_, length)| *length == bytes.len()).map(|(value, _)| value)
        };
        let numbers: Option<Vec<f64>> = fields.iter().map(one).collect();
        let Some(numbers) = numbers.filter(|numbers| (1..=8).contains(&numbers.len())) else {
            point.fixed = Some("it is not a list of numbers".into());
            return;
        };
        // The seventh and eighth are of arms with more axes.
        if numbers.iter().skip(6).any(|&value| value != 0.0) {
            point.fixed = Some("it has more than six axes".into());
        }
        let pulses = self.kind.eq_ignore_ascii_case("PULSE");
        let slot = |(k, range): (usize, &std::ops::Range<usize>)| {
            let form = if pulses { Form::Whole } else { Form::Real(if k < 3 { 3 } else { 4 }) };
            Slot { range: range.clone(), form }
        };
        let mut six = numbers;
        six.truncate(6);
        point.slots = fields.iter().take(six.len()).enumerate().map(slot).collect();
        if pulses {
            point.value = Value::Joints(six);
            return;
        }
        let frame = match self.kind.to_ascii_uppercase().as_str() {
            "BASE" | "ROBOT" => Reference::Identity,
            "USER" => Reference::Named(format!("USER {}", self.user)),
            other => {
                point.fixed.get_or_insert_with(|| format!("positions of the type `{other}` are not read"));
                return;
            }
        };
        let tool = match self.tool.is_empty() {
            true => Reference::Unknown("///TOOL is absent".into()),
            false => Reference::Named(self.tool()),
        };
        let branch = if self.configuration.is_empty() {
            Branch::Continuous
        } else {
            Branch::Opaque(self.configuration.clone())
        };
        match Dialect::Inform.pose(&six) {
            Some(pose) => {
                point.value = Value::Pose { pose, frame, tool, branch };
                point.written = six;
            }
            None => point.fixed = Some("it has not six components".into()),
        }
    }
}

/// `C00012` and `C0012` are one; `P` are variables.
fn key(name: &str) -> Option<(char, u64)> {
    let letter = name.chars().next().filter(|c| matches!(c, 'C' | 'P'))?;
    let digits = &name[1..];
    digits
        .chars()
        .all(|c| c.is_ascii_digit())
        .then(|| digits.parse().ok())
        .flatten()
        .map(|number| (letter, number))
}

/// Instructions that use a point and move nothing there: reference points of weaving and of the tool's direction.
const REFERENCES: [&str; 1] = ["REFP"];

/// Words behind a point that leave it where it is.
const HARMLESS: [&str; 12] =
    ["NWAIT", "UNTIL", "FPT", "SRCH", "ON", "OFF", "AND", "OR", "FINE", "ALL", "ENWAIT", "SAVE"];

/// What the instructions of a job do.
struct Job {
    stations: Stations,
    places: HashMap<(char, u64), usize>,
    /// Whether the order of the lines is not that in which they run.
    jumps: bool,
    /// The line of a shift that is on.
    shift: Option<usize>,
    route: Vec<Event>,
    notes: Vec<Note>,
}

impl Job {
    fn instruction(&mut self, line: &Line<'_>, points: &mut [Point]) {
        let text = String::from_utf8_lossy(line.bytes);
        let text = text.split('\'').next().unwrap_or("").trim();
        let mut words = text.split_whitespace();
        let Some(verb) = words.next().filter(|verb| !verb.starts_with('/')) else { return };
        // `+MOVL`, `SMOVL`: of robots that work together.
        let bare = verb.trim_start_matches('+');
        let linear = ["MOVL", "MOVC", "MOVS"].contains(&bare);
        let named: Vec<(char, u64)> =
            text.split(|c: char| !c.is_ascii_alphanumeric()).skip(1).filter_map(key).collect();
        match verb {
            "SFTON" => self.shifted(line.number, points),
            "SFTOF" => self.shift = None,
            "MOVJ" | "MOVL" | "MOVC" | "MOVS" => {
                // Another robot, or a station, that moves at the same time, each for itself.
                let (text, beside) = text.split_once(" +").unwrap_or((text, ""));
                for name in beside.split(|c: char| !c.is_ascii_alphanumeric()).filter_map(key) {
                    if let Some(&at) = self.places.get(&name) {
                        let words =
                            format!("it is that of another robot or of a station (line {})", line.number);
                        points[at].fixed.get_or_insert(words);
                    }
                }
                let options = text.split_whitespace().skip(1).filter(|word| key(word).is_none());
                let odd = |word: &&str| !harmless(word);
                if let Some(word) = options.into_iter().find(odd) {
                    let words = format!("`{word}` behind its point is not understood");
                    self.notes.push(Note::refusing(line.number, text.into(), words));
                }
                let at = named.first().and_then(|name| self.places.get(name)).copied();
                self.route.push(Visit::event(at.into_iter().collect(), linear, line.number));
                let name = named.first().map(|name| format!("{}{:05}", name.0, name.1));
                let name = name.unwrap_or_else(|| words.next().unwrap_or(verb).into());
                match at {
                    Some(at) => {
                        self.displaced(&mut points[at]);
                        let words = text.split_whitespace().chain(beside.split_whitespace());
                        self.stations.move_to(words, &mut points[at], line.number);
                    }
                    None => self.notes.push(Note::missing(line.number, text.into(), name)),
                }
            }
            _ if verb.contains("IMOV") => {
                let words =
                    format!("{verb} in line {} moves by a distance from where the robot is", line.number);
                self.notes.push(Note::refusing(line.number, text.into(), words));
                self.route.push(Visit::event(Vec::new(), true, line.number));
            }
            _ if verb.contains("MOV") => {
                let words = "a motion that is not understood: where the robot moves is not known";
                self.notes.push(Note::refusing(line.number, text.into(), words.into()));
                self.route.push(Visit::event(Vec::new(), false, line.number));
            }
            "GETPOS" => {
                let words = "a position is computed from a step of the job: from a compensated point it comes out displaced";
                self.notes.push(Note::refusing(line.number, text.into(), words.into()));
            }
            _ => {
                let used = named.iter().filter_map(|name| self.places.get(name));
                let why = match REFERENCES.contains(&verb) {
                    true => format!(
                        "{verb} in line {} uses it as a reference point, not as a destination",
                        line.number
                    ),
                    false => format!("{verb} in line {} uses it", line.number),
                };
                used.for_each(|&k| {
                    points[k].fixed.get_or_insert_with(|| why.clone());
                });
            }
        }
    }

    /// A shift begins.
    fn shifted(&mut self, line: usize, points: &mut [Point]) {
        self.shift = Some(line);
        // Where lines run in another order, or other jobs are called, every point may be displaced.
        if self.jumps {
            points.iter_mut().for_each(|point| self.displaced(point));
        }
    }

    fn displaced(&self, point: &mut Point) {
        if let Some(line) = self.shift {
            let words = format!("SFTON in line {line} displaces positions while the job runs");
            point.fixed.get_or_insert(words);
        }
    }
}

/// `V=93.0`, `CV#(1)`, `NWAIT`, `BC00001` of another group.
fn harmless(word: &str) -> bool {
    let word = word.trim_end_matches(',');
    let group = |word: &str| word.len() > 2 && ["BC", "EC", "BP", "EX"].contains(&&word[..2]);
    // Another frame or tool than that of its position.
    let other = ["UF#", "TL#", "USER#", "TOOL#"].iter().any(|list| word.starts_with(list));
    !other
        && (word.contains(['=', '#', '(', ')', '>', '<'])
            || HARMLESS.contains(&word)
            || (word.is_ascii() && group(word) && word[2..].bytes().all(|byte| byte.is_ascii_digit()))
            || word.bytes().all(|byte| byte.is_ascii_digit() || byte == b'.'))
}
