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
mod statements;
mod subprograms;

use crate::event::Visit;
use crate::lines::{Line, lines};
use crate::program::{Definition, Definitions};
use crate::tokens::{Lexis, tokens_from};
use crate::{ControllerError, Dialect, Program};
use std::collections::BTreeMap;
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
    let motions = motions::read(&lines[mn + 1..pos], &known, &subprograms);
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
    let visit = |&(number, linear, line): &(Option<i64>, bool, usize)| {
        let at = number.and_then(|number| place.get(&number).copied());
        Visit::event(at.into_iter().collect(), linear, line)
    };
    let route = vec![motions.reached.iter().map(visit).collect()];
    Ok(Program {
        dialect: Dialect::Fanuc,
        text: text.to_vec(),
        points,
        definitions,
        route,
        notes: motions.notes,
    })
}

/// `LINE_TRACK_SCHEDULE_NUMBER : 1;` in front of /MN: positions are those on a conveyor that moves.
fn conveyor(head: &[Line<'_>]) -> Option<String> {
    let line = head.iter().find(|line| line.after("LINE_TRACK_SCHEDULE_NUMBER").is_some())?;
    let shown = String::from_utf8_lossy(line.trimmed());
    let number = shown.split(':').nth(1)?.trim().trim_end_matches(';').trim();
    (number != "0").then(|| format!("the program follows a conveyor (line {}: {shown})", line.number))
}
