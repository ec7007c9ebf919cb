//! The section /POS.

use crate::error::syntax;
use crate::number::{Form, Slot, number_at};
use crate::program::{Branch, Point, Value};
use crate::reference::Reference;
use crate::tokens::{Cursor, Kind, Token};
use crate::{ControllerError, Dialect};
use std::collections::BTreeSet;

const POSE: [&str; 6] = ["X", "Y", "Z", "W", "P", "R"];
const JOINTS: [&str; 6] = ["J1", "J2", "J3", "J4", "J5", "J6"];

/// The number of `P[3]`.
pub(super) fn number_of(point: &Point) -> Option<i64> {
    point.name.strip_prefix("P[")?.split([':', ']']).next()?.parse().ok()
}

pub(super) fn points(text: &[u8], all: &[Token]) -> Result<Vec<Point>, ControllerError> {
    let tokens: Vec<Token> = all.iter().filter(|token| token.kind != Kind::End).cloned().collect();
    let mut at = Cursor::new(text, &tokens);
    let mut points: Vec<Point> = Vec::new();
    let mut numbers = BTreeSet::new();
    while let Some(token) = at.peek() {
        if at.peek_word() != Some("P") {
            return Err(syntax(text, token.range.start, "expected a position P[n]{ … };"));
        }
        let point = position(&mut at)?;
        if !numbers.insert(number_of(&point)) {
            return Err(syntax(text, token.range.start, format!("{} is there twice", point.name)));
        }
        points.push(point);
    }
    Ok(points)
}

/// `P[1:"name"]{ … };`
fn position(at: &mut Cursor<'_>) -> Result<Point, ControllerError> {
    let (line, begin) = at.peek().map_or((0, 0), |token| (token.line, token.range.start));
    let wrong = |at: &Cursor<'_>, message: &str| {
        let place = at.peek().map_or(at.text.len(), |token| token.range.start);
        syntax(at.text, place, message)
    };
    at.word();
    let number = if at.take(b'[') { at.number() } else { None };
    let Some((number, _)) = number.filter(|(number, _)| number.fract() == 0.0 && *number >= 0.0) else {
        return Err(wrong(at, "expected the number of a position"));
    };
    while at.peek().is_some_and(|token| !token.is(b']')) {
        at.at += 1;
    }
    if !(at.take(b']') && at.take(b'{')) {
        return Err(wrong(at, "expected ]{ behind the number of a position"));
    }
    let open = at.at;
    at.skip_closed();
    if !at.tokens.get(at.at - 1).is_some_and(|token| token.is(b'}')) || !at.take(b';') {
        return Err(syntax(at.text, begin, "a position is not closed with };"));
    }
    let inside = &at.tokens[open..at.at - 2];
    let mut point = Point::new(format!("P[{number:.0}]"), line);
    groups(at.text, inside, &mut point);
    Ok(point)
}

/// A component `X = 1.0 mm`.
struct Entry {
    name: String,
    value: Option<(f64, std::ops::Range<usize>)>,
    unit: String,
}

fn groups(text: &[u8], inside: &[Token], point: &mut Point) {
    let mut at = Cursor::new(text, inside);
    let (mut frame, mut tool) =
        (Reference::Unknown("UF is absent".into()), Reference::Unknown("UT is absent".into()));
    let mut config = None;
    let mut entries: Vec<Entry> = Vec::new();
    let mut group = 0;
    while let Some(word) = at.word() {
        let word = word.to_ascii_uppercase();
        if let Some(number) = word.strip_prefix("GP").and_then(|digits| digits.parse::<u32>().ok()) {
            group = number;
            at.take(b':');
            continue;
        }
        if at.take(b':') {
            let from = at.at;
            let numbered = at.number().map(|(number, _)| number);
            at.at = from;
            let slot = match word.as_str() {
                "UF" => Some((&mut frame, "UF")),
                "UT" => Some((&mut tool, "UT")),
                _ => None,
            };
            if let Some((slot, name)) = slot.filter(|_| group == 1) {
                *slot = match numbered {
                    Some(0.0) => Reference::Identity,
                    Some(number) => Reference::Named(format!("{name}{number:.0}")),
                    None => Reference::Unknown(format!("{name} is the one that is active, not a number")),
                };
            } else if let Some(token) = at.peek().filter(|token| token.kind == Kind::Text && group == 1) {
                // `CONFIG`, `KONFIG`: the word is that of the controller's language.
                config = Some(token.clone());
            }
            to_comma(&mut at);
            continue;
        }
        if !at.take(b'=') {
            point.fixed.get_or_insert_with(|| format!("`{word}` is not understood"));
            to_comma(&mut at);
            continue;
        }
        let value = at.number();
        if value.is_none() {
            // An untaught component is a row of stars.
            let unit = |token: &Token| token.kind == Kind::Word || token.is(b',');
            while at.peek().is_some_and(|token| !unit(token)) {
                at.at += 1;
            }
        }
        let unit = at.peek_word().unwrap_or("").to_ascii_lowercase();
        if !unit.is_empty() {
            at.at += 1;
        }
        if group == 1 && !word.starts_with('E') {
            entries.push(Entry { name: word, value, unit });
        } else {
            let name = if group == 1 { word } else { format!("GP{group} {word}") };
            point.external.push((name, value.map_or(f64::NAN, |(value, _)| value)));
        }
        // The last component of a group has no comma behind it.
        at.take(b',');
    }
    if !at.done() {
        point.fixed.get_or_insert_with(|| "its group 1 is not understood".into());
    }
    fill(text, point, &entries, [frame, tool], config.as_ref());
}

fn to_comma(at: &mut Cursor<'_>) {
    while at.peek().is_some_and(|token| !token.is(b',')) {
        at.at += 1;
    }
    at.take(b',');
}

fn fill(text: &[u8], point: &mut Point, entries: &[Entry], active: [Reference; 2], config: Option<&Token>) {
    if entries.iter().any(|entry| entry.name == "RX") {
        // Positions of a remote tool centre point.
        let words = "the tool stands still and the robot holds the work (RX, RY, RZ: remote TCP), which is not compensated";
        point.fixed.get_or_insert_with(|| words.into());
        return;
    }
    let joints = entries.iter().any(|entry| entry.name == "J1");
    let names: &[&str] = if joints { &JOINTS } else { &POSE };
    let mut numbers = Vec::new();
    for (k, name) in names.iter().enumerate() {
        let Some(entry) = entries.iter().find(|entry| entry.name == *name) else {
            // Arms of fewer axes.
            if joints && k > 0 {
                break;
            }
            point.fixed.get_or_insert_with(|| format!("{name} is absent"));
            return;
        };
        let unit = if !joints && k < 3 { "mm" } else { "deg" };
        let Some((value, range)) =
            entry.value.clone().filter(|_| entry.unit == unit || (joints && entry.unit == "mm"))
        else {
            point.fixed.get_or_insert_with(|| format!("{name} is not a number in {unit}"));
            return;
        };
        numbers.push(value);
        point.slots.push(Slot::padded(text, range, Form::Real(3)));
    }
    if entries.len() != numbers.len() {
        point.fixed.get_or_insert_with(|| "it has components that are not understood".into());
        return;
    }
    if joints {
        point.value = Value::Joints(numbers);
        return;
    }
    let inside = config.map(|token| token.range.start + 1..token.range.end - 1);
    let branch = inside.and_then(|inside| branch(text, inside, &mut point.turns));
    let Some((pose, branch)) = Dialect::Fanuc.pose(&numbers).zip(branch) else {
        point.fixed.get_or_insert_with(|| "its CONFIG is not three letters and three numbers".into());
        point.turns.clear();
        return;
    };
    let [frame, tool] = active;
    point.written = numbers;
    point.value = Value::Pose { pose, frame, tool, branch };
}

/// `N U T, 0, 0, 0`
pub(super) fn branch(text: &[u8], inside: std::ops::Range<usize>, turns: &mut Vec<Slot>) -> Option<Branch> {
    let mut at = inside.start;
    let mut fields = Vec::new();
    for part in text[inside].split(|&byte| byte == b',') {
        fields.push((at, part));
        at += part.len() + 1;
    }
    let [(_, letters), numbers @ ..] = &fields[..] else { return None };
    let letters: Vec<u8> = letters.iter().filter(|byte| !byte.is_ascii_whitespace()).copied().collect();
    let mut values = Vec::new();
    for (at, part) in numbers {
        let lead = part.len() - part.trim_ascii_start().len();
        let (value, length) = number_at(part.trim_ascii())?;
        if length != part.trim_ascii().len() || value.fract() != 0.0 {
            return None;
        }
        values.push(value as i64);
        turns.push(Slot { range: at + lead..at + lead + length, form: Form::Whole });
    }
    let turns: [i64; 3] = values.try_into().ok()?;
    Some(match letters[..] {
        [flip @ (b'N' | b'F'), up @ (b'U' | b'D'), toward @ (b'T' | b'B')] => {
            Branch::Fanuc { flip: flip == b'F', up: up == b'U', toward: toward == b'T', turns }
        }
        // With L or R: of arms whose shoulder is aside.
        [b'N' | b'F', b'L' | b'R', b'U' | b'D', b'T' | b'B'] => {
            Branch::Opaque(format!("{} {turns:?}", String::from_utf8_lossy(&letters)))
        }
        _ => return None,
    })
}
