//! Position registers of a controller: `POSREG.VA`.
//!
//! ```text
//! [*POSREG*]$POSREG  …  : ARRAY[2,100] OF Position Reg
//!     [1,1] =   'HOME'   Group: 1
//!   J1 =     9.998 deg   J2 =   -45.000 deg   …
//!   EXT1:   700.000 mm
//!     [1,2] =   '' Uninitialized
//!     [1,3] =   'PICK'
//!   Group: 1   Config: N U T, 0, 0, 0
//!   X:   500.000   Y:     0.000   Z:     0.000
//!   W:     0.000   P:     0.000   R:    90.000
//! ```
//!
//! A register has no frame and no tool: they are those that a program has selected (UFRAME_NUM, UTOOL_NUM) where it moves there.

use super::motions::Registered;
use super::position::branch;
use crate::Dialect;
use crate::definitions::Definitions;
use crate::lines::{Line, lines};
use crate::number::{Form, Slot, number_at};
use crate::program::{Point, Value};
use crate::reference::{Carried, Reference};
use std::collections::BTreeMap;
use std::ops::Range;

/// Whether a text is one of these.
pub(super) fn is(text: &[u8]) -> bool {
    lines(text).iter().any(|line| line.bytes.windows(9).any(|part| part == b"]$POSREG "))
}

/// Numbers of the registers that have a value.
pub(super) fn known(text: &[u8]) -> impl Iterator<Item = i64> {
    read(text).into_iter().filter(|(_, register)| !register.parts.is_empty()).map(|(number, _)| number)
}

/// A register with its value.
#[derive(Debug, Default)]
struct Register {
    line: usize,
    /// Of group 1: name, value and place of each component.
    parts: Vec<(String, f64, Range<usize>)>,
    config: Option<Range<usize>>,
    external: Vec<(String, f64)>,
}

fn read(text: &[u8]) -> BTreeMap<i64, Register> {
    let mut all: BTreeMap<i64, Register> = BTreeMap::new();
    let mut at: Option<(u32, i64)> = None;
    let mut inside = false;
    for line in lines(text) {
        let trimmed = line.trimmed();
        if trimmed.starts_with(b"[*") {
            inside = line.bytes.windows(9).any(|part| part == b"]$POSREG ");
            at = None;
            continue;
        }
        if !inside {
            continue;
        }
        // The comment in quotes may hold anything.
        let mut from = 0;
        if trimmed.starts_with(b"[") {
            at = index(trimmed);
            if let Some((1, number)) = at {
                all.insert(number, Register { line: line.number, ..Register::default() });
            }
            from = line.bytes.iter().rposition(|&byte| byte == b'\'').map_or(line.bytes.len(), |end| end + 1);
        }
        if let Some((group, number)) = at
            && let Some(register) = all.get_mut(&number)
        {
            register.components(&line, from, group);
        }
    }
    all
}

/// `[1,3] = …`
fn index(line: &[u8]) -> Option<(u32, i64)> {
    let text = String::from_utf8_lossy(line);
    let (group, number) = text.strip_prefix('[')?.split(']').next()?.split_once(',')?;
    Some((group.trim().parse().ok()?, number.trim().parse().ok()?))
}

impl Register {
    /// `X: 500.000`, `J1 = 9.998 deg`, `Config: N U T, 0, 0, 0`, `EXT1: ******** mm`
    fn components(&mut self, line: &Line<'_>, from: usize, group: u32) {
        let mut at = from;
        let word = |byte: &u8| byte.is_ascii_alphanumeric();
        while at < line.bytes.len() {
            if !line.bytes[at].is_ascii_alphabetic() {
                at += 1;
                continue;
            }
            let length = line.bytes[at..].iter().take_while(|byte| word(byte)).count();
            let name = String::from_utf8_lossy(&line.bytes[at..at + length]).to_uppercase();
            at += length;
            let blank =
                |at: usize| line.bytes[at..].iter().take_while(|byte| byte.is_ascii_whitespace()).count();
            at += blank(at);
            if !matches!(line.bytes.get(at), Some(b':' | b'=')) {
                continue;
            }
            at += 1;
            at += blank(at);
            let start = line.start + at;
            if name == "CONFIG" {
                self.config = Some(start..line.start + line.bytes.trim_ascii_end().len());
                return;
            }
            let found = number_at(&line.bytes[at..]);
            let (value, length) = found.unwrap_or((f64::NAN, 0));
            at += length;
            match (name.strip_prefix("EXT"), group) {
                _ if name == "GROUP" => {}
                (Some(axis), 1) => self.external.push((format!("E{axis}"), value)),
                (_, 1) => self.parts.push((name, value, start..start + length)),
                _ => self.external.push((format!("GP{group} {name}"), value)),
            }
        }
    }

    fn point(&self, text: &[u8], number: i64) -> Point {
        let mut point = Point::new(format!("PR[{number}]"), self.line);
        point.external.clone_from(&self.external);
        let joints = self.parts.first().is_some_and(|(name, ..)| name.starts_with('J'));
        let names: &[&str] =
            if joints { &["J1", "J2", "J3", "J4", "J5", "J6"] } else { &["X", "Y", "Z", "W", "P", "R"] };
        let fits = self.parts.len() <= names.len()
            && self
                .parts
                .iter()
                .zip(names)
                .all(|((name, value, _), wanted)| name == wanted && value.is_finite());
        if !fits || (!joints && self.parts.len() < 6) {
            point.fixed = Some("its components are not understood, or are not set".into());
            return point;
        }
        let slot =
            |(_, _, range): &(String, f64, Range<usize>)| Slot::padded(text, range.clone(), Form::Real(3));
        point.slots = self.parts.iter().map(slot).collect();
        let numbers: Vec<f64> = self.parts.iter().map(|(_, value, _)| *value).collect();
        if joints {
            point.value = Value::Joints(numbers);
            return point;
        }
        let branch = self.config.clone().and_then(|config| branch(text, config, &mut point.turns));
        match Dialect::Fanuc.pose(&numbers).zip(branch) {
            Some((pose, branch)) => {
                let [frame, tool] =
                    [0, 1].map(|_| Reference::Unknown("no motion in the files given goes to it".into()));
                point.value = Value::Pose { pose, frame, tool, branch };
                point.written = numbers;
            }
            None => {
                point.turns.clear();
                point.fixed = Some("its Config is not three letters and three numbers".into());
            }
        }
        point
    }
}

/// The registers to which motions of the programs go, as points with the frame and tool that are selected there. `programs` have their motions to registers.
pub(super) fn points(
    text: &[u8],
    programs: &[Vec<Registered>],
    definitions: &Definitions,
) -> Vec<(i64, Point)> {
    let mut all = Vec::new();
    for (number, register) in read(text) {
        if register.parts.is_empty() {
            continue;
        }
        let mut point = register.point(text, number);
        let mut uses = programs.iter().flatten().filter(|used| used.number == number);
        if let Some(first) = uses.next() {
            let mut selected = first.selected.clone();
            let mut fixed = first.fixed.clone();
            for used in uses {
                for (mine, other) in selected.iter_mut().zip(&used.selected) {
                    if mine != other && !matches!(mine, Reference::Unknown(_)) {
                        let words = format!("it is used with {} and with {}", mine.words(), other.words());
                        *mine = Reference::Unknown(words);
                    }
                }
                fixed = fixed.or_else(|| used.fixed.clone());
            }
            point.fixed = point.fixed.or(fixed);
            point.carried = match &selected[2] {
                Reference::Unknown(words) => Carried::Open(words.clone()),
                load => definitions.load(load),
            };
            if let Value::Pose { frame, tool, .. } = &mut point.value {
                [*frame, *tool, _] = selected;
            }
        }
        all.push((number, point));
    }
    all
}
