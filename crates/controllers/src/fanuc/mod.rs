//! FANUC TP as text, `.ls`.
//!
//! ```text
//! /MN     n: (J|L|C|A|S) P[n] … ;                       which points are reached; options as Offset and INC displace them
//! /POS    P[n:"name"]{
//!           GP1:
//!             UF : n, UT : n, CONFIG : 'N U T, 0, 0, 0',      CONFIG in the language of the controller
//!             X = … mm, Y = … mm, Z = … mm, W = … deg, P = … deg, R = … deg
//!           | UF : n, UT : n,  J1= … deg, …
//!           GP2: …
//!         };
//! ```
//!
//! The values of user frames and tools are in a file of their own (see `frames`): `UF1`, `UT1` name them; 0 is none.

mod frames;
mod motions;
mod position;
mod registers;
mod settings;
mod statements;
mod subprograms;

use crate::definitions::{Definition, Definitions};
use crate::event::{Event, Visit};
use crate::lines::{Line, lines};
use crate::tokens::{Lexis, tokens_from};
use crate::{ControllerError, Dialect, Program};
use motions::{Motions, Place, Registered};
use std::collections::{BTreeMap, BTreeSet};
use subprograms::Subprograms;

const LEXIS: Lexis = Lexis { comment: 0, quotes: b"\"'", header: None, escapes: false };

pub(crate) fn read(text: &[u8], others: &[&[u8]]) -> Result<Program, ControllerError> {
    let mut definitions = Definitions::default();
    for text in others.iter().copied().chain([text]).filter(|text| frames::is(text)) {
        frames::read(text, &mut definitions);
    }
    if frames::is(text) {
        return Ok(Program::of_frames(Dialect::Fanuc, text, definitions));
    }
    if registers::is(text) {
        return Ok(of_registers(text, others, definitions));
    }
    let lines = lines(text);
    let head = |word: &str| lines.iter().position(|line| line.after(word).is_some_and(<[u8]>::is_empty));
    let Some(mn) = head("/MN") else {
        return Err(ControllerError::NotAProgram(
            "it has no line /MN: it is no program of FANUC's TP language, and it has no frames, tools or payloads ($MNUFRAME, $MNUTOOL, $PLST_GRP1)"
                .into(),
        ));
    };
    let pos = head("/POS").filter(|&pos| pos > mn).unwrap_or(lines.len());
    let end = (pos..lines.len()).find(|&k| lines[k].after("/END").is_some_and(<[u8]>::is_empty));
    let mut points = Vec::new();
    if let Some(first) = lines.get(pos + 1) {
        let until = end.map_or(text.len(), |end| lines[end].start);
        let all = tokens_from(&text[..until], first.start.min(until), first.number, LEXIS)?;
        points = position::points(&text[..until], &all)?;
    }
    let known: Vec<i64> = points.iter().filter_map(position::number_of).collect();
    for (name, line) in std::iter::once(text).chain(others.iter().copied()).flat_map(frames::changed) {
        let words = format!("line {line} changes {name} while the program runs");
        definitions.0.insert(name, Definition::Unusable(words));
    }
    let subprograms = Subprograms::of(others.iter().copied());
    let registers: BTreeSet<i64> =
        others.iter().filter(|text| registers::is(text)).flat_map(|text| registers::known(text)).collect();
    let motions = motions::read(&lines[mn + 1..pos], &known, &registers, &subprograms);
    let place: BTreeMap<i64, usize> =
        points.iter().enumerate().filter_map(|(k, point)| Some((position::number_of(point)?, k))).collect();
    for (number, words) in &motions.displaced {
        if let Some(&k) = place.get(number) {
            points[k].fixed.get_or_insert_with(|| words.clone());
        }
    }
    if let Some(words) = conveyor(&lines[..mn]) {
        points.iter_mut().for_each(|point| point.fixed = Some(words.clone()));
    }
    for (number, load) in &motions.carried {
        if let Some(&k) = place.get(number) {
            points[k].carried = definitions.load(load);
        }
    }
    let route = vec![visits(&motions, |to| match to {
        Place::Point(number) => place.get(&number).copied(),
        _ => None,
    })];
    Ok(Program {
        dialect: Dialect::Fanuc,
        text: text.to_vec(),
        points,
        definitions,
        route,
        notes: motions.notes,
    })
}

/// What happens, with the points that are these places.
fn visits(motions: &Motions<'_>, point: impl Fn(Place) -> Option<usize>) -> Vec<Event> {
    let visit = |&(to, linear, line): &(Place, bool, usize)| {
        Visit::event(point(to).into_iter().collect(), linear, line)
    };
    motions.reached.iter().map(visit).collect()
}

/// Position registers as points of the programs that move there.
fn of_registers(text: &[u8], others: &[&[u8]], definitions: Definitions) -> Program {
    let known: BTreeSet<i64> = registers::known(text).collect();
    let mut route = vec![Vec::new()];
    let mut used: Vec<Vec<Registered>> = Vec::new();
    let mut changed: Vec<(Option<i64>, usize)> = Vec::new();
    // The points are those of the registers in their order.
    let place: BTreeMap<i64, usize> = known.iter().enumerate().map(|(k, &number)| (number, k)).collect();
    let all = lines_of(others);
    for (k, lines) in all.iter().enumerate() {
        let of_calls = Subprograms::of(
            others.iter().enumerate().filter(|(other, _)| *other != k).map(|(_, text)| *text),
        );
        let motions = motions::read(lines, &[], &known, &of_calls);
        route.push(visits(&motions, |to| match to {
            Place::Register(number) => place.get(&number).copied(),
            _ => None,
        }));
        changed.extend(motions.changed);
        used.push(motions.registered);
    }
    let mut points = Vec::new();
    for (number, mut point) in registers::points(text, &used, &definitions) {
        let mut changes = changed.iter().filter(|(other, _)| other.is_none_or(|other| other == number));
        if let Some((_, line)) = changes.next() {
            let words = format!("line {line} gives it another value while the program runs");
            point.fixed.get_or_insert(words);
        }
        points.push(point);
    }
    Program { points, route, ..Program::of_frames(Dialect::Fanuc, text, definitions) }
}

/// The instructions of programs; none of what is no program.
fn lines_of<'t>(texts: &[&'t [u8]]) -> Vec<Vec<Line<'t>>> {
    let one = |text: &&'t [u8]| {
        let mut lines = lines(text);
        let head = |word: &str| lines.iter().position(|line| line.after(word).is_some_and(<[u8]>::is_empty));
        let Some(mn) = head("/MN") else { return Vec::new() };
        let pos = head("/POS").filter(|&pos| pos > mn).unwrap_or(lines.len());
        lines.truncate(pos);
        lines.split_off(mn + 1)
    };
    texts.iter().map(one).collect()
}

/// `LINE_TRACK_SCHEDULE_NUMBER : 1;` in front of /MN: positions are those on a conveyor that moves.
fn conveyor(head: &[Line<'_>]) -> Option<String> {
    let line = head.iter().find(|line| line.after("LINE_TRACK_SCHEDULE_NUMBER").is_some())?;
    let shown = String::from_utf8_lossy(line.trimmed());
    let number = shown.split(':').nth(1)?.trim().trim_end_matches(';').trim();
    (number != "0").then(|| format!("the program follows a conveyor (line {}: {shown})", line.number))
}
