//! Yaskawa INFORM, `.jbi`.
//!
//! ```text
//! //POS
//! ///TOOL n   ///USER n   ///POSTYPE PULSE|BASE|ROBOT|USER   ///RCONF …
//! C00001=n,n,n,n,n,n                     pulses of the axes, or X,Y,Z in mm and Rx,Ry,Rz in degrees
//! //INST      (MOVJ|MOVL|MOVC|MOVS) C00001 …
//! ```
//!
//! The values of user frames and tools are in the controller: `USER 1`, `TOOL 0` name them.

use crate::lines::{Line, lines};
use crate::number::{Form, Slot, number_at};
use crate::program::{Branch, Definitions, Note, Point, Reference, Step, Value};
use crate::{ControllerError, Dialect, Program};

pub(crate) fn read(text: &[u8], _others: &[&[u8]]) -> Result<Program, ControllerError> {
    let lines = lines(text);
    if !lines.iter().any(|line| line.after("/JOB").is_some_and(<[u8]>::is_empty)) {
        return Err(ControllerError::NotAProgram("it has no line /JOB: it is no job of INFORM".into()));
    }
    let head = |word: &str| lines.iter().position(|line| line.after(word).is_some_and(<[u8]>::is_empty));
    let inst = head("//INST").unwrap_or(lines.len());
    let mut points = Vec::new();
    if let Some(pos) = head("//POS").filter(|&pos| pos < inst) {
        let mut state = State::default();
        for line in &lines[pos + 1..inst] {
            points.extend(state.line(text, line));
        }
    }
    let mut order = Vec::new();
    let mut notes = Vec::new();
    for line in lines.iter().skip(inst + 1) {
        instruction(line, &mut points, &mut order, &mut notes);
    }
    let definitions = Definitions::default();
    Ok(Program { dialect: Dialect::Inform, text: text.to_vec(), points, definitions, order, notes })
}

/// What the lines before say of the positions that follow.
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
        let mut point = Point {
            name,
            line: line.number,
            value: Value::Joints(Vec::new()),
            external: Vec::new(),
            fixed: None,
            slots: Vec::new(),
            written: Vec::new(),
            turns: Vec::new(),
        };
        self.fill(text, line.fields(equals + 1), &mut point);
        Some(point)
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
        let tool = if self.tool.is_empty() {
            Reference::Unknown("///TOOL is absent".into())
        } else {
            // Several tools are listed where the job has several groups: the first is the robot's.
            let first = self.tool.split(',').next().unwrap_or("").trim();
            Reference::Named(format!("TOOL {first}"))
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

fn instruction(line: &Line<'_>, points: &mut [Point], order: &mut Vec<Step>, notes: &mut Vec<Note>) {
    let text = String::from_utf8_lossy(line.bytes);
    let text = text.split('\'').next().unwrap_or("").trim();
    let mut words = text.split_whitespace();
    let Some(verb) = words.next().filter(|verb| !verb.starts_with('/')) else { return };
    let named: Vec<(char, u64)> =
        text.split(|c: char| !c.is_ascii_alphanumeric()).skip(1).filter_map(key).collect();
    let moves = ["MOVJ", "MOVL", "MOVC", "MOVS"].contains(&verb);
    if verb == "SFTON" || verb == "IMOV" {
        let words = format!("{verb} in line {} displaces positions while the job runs", line.number);
        if verb == "SFTON" {
            points.iter_mut().for_each(|point| {
                point.fixed.get_or_insert_with(|| words.clone());
            });
        } else {
            notes.push(Note::refusing(line.number, text.into(), words));
            order.push(Step::Elsewhere);
        }
        return;
    }
    let Some(first) = named.first() else {
        if moves {
            order.push(Step::Elsewhere);
            notes.push(Note::missing(line.number, text.into(), words.next().unwrap_or(verb).into()));
        }
        return;
    };
    if moves {
        let at = points.iter().position(|point| key(&point.name) == Some(*first));
        order.push(at.map_or(Step::Elsewhere, Step::Point));
        if at.is_none() {
            notes.push(Note::missing(line.number, text.into(), format!("{}{:05}", first.0, first.1)));
        }
        return;
    }
    for name in named {
        for point in points.iter_mut().filter(|point| key(&point.name) == Some(name)) {
            point.fixed.get_or_insert_with(|| format!("{verb} in line {} uses it", line.number));
        }
    }
}
