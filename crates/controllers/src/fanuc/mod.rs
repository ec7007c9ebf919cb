//! FANUC TP as text, `.ls`.
//!
//! ```text
//! /MN     n: (J|L|C|A|S) P[n] … [Offset|Tool_Offset|VOFFSET|INC|COORD] ;         which points are reached, and how
//! /POS    P[n:"name"]{
//!           GP1:
//!             UF : n, UT : n, CONFIG : 'N U T, 0, 0, 0',
//!             X = … mm, Y = … mm, Z = … mm, W = … deg, P = … deg, R = … deg
//!           | UF : n, UT : n,  J1= … deg, …
//!           GP2: …
//!         };
//! ```
//!
//! The values of user frames and tools are in the controller, not in the program: `UF1`, `UT1` name them; 0 is none.

mod motions;
mod position;

use crate::lines::lines;
use crate::program::{Definitions, Step};
use crate::tokens::{Lexis, tokens_from};
use crate::{ControllerError, Dialect, Program};

const LEXIS: Lexis = Lexis { comment: 0, quotes: b"\"'", header: None, escapes: false };

pub(crate) fn read(text: &[u8], _others: &[&[u8]]) -> Result<Program, ControllerError> {
    let lines = lines(text);
    let head = |word: &str| lines.iter().position(|line| line.after(word).is_some_and(<[u8]>::is_empty));
    let Some(mn) = head("/MN") else {
        return Err(ControllerError::NotAProgram(
            "it has no line /MN: it is no program of FANUC's TP language".into(),
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
    let motions = motions::read(&lines[mn + 1..pos], &known);
    for (number, words) in &motions.displaced {
        for point in points.iter_mut().filter(|point| position::number_of(point) == Some(*number)) {
            point.fixed.get_or_insert_with(|| words.clone());
        }
    }
    let place = |number: i64| points.iter().position(|point| position::number_of(point) == Some(number));
    let order = motions
        .reached
        .iter()
        .map(|number| number.and_then(place).map_or(Step::Elsewhere, Step::Point))
        .collect();
    let definitions = Definitions::default();
    Ok(Program {
        dialect: Dialect::Fanuc,
        text: text.to_vec(),
        points,
        definitions,
        order,
        notes: motions.notes,
    })
}
