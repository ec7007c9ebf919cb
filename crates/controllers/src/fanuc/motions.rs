//! Instructions: which points are reached, and which are displaced on the way.

use crate::lines::Line;
use crate::program::Note;

#[derive(Debug, Default)]
pub(super) struct Motions {
    /// Numbers of the points in the order of the program; none: another place.
    pub(super) reached: Vec<Option<i64>>,
    /// Points that an instruction displaces, and why.
    pub(super) displaced: Vec<(i64, String)>,
    pub(super) notes: Vec<Note>,
    /// Numbers of the points that have a value.
    known: Vec<i64>,
}

/// Words behind a point that move it, or the robot relative to something.
const DISPLACING: [&str; 5] = ["OFFSET", "TOOL_OFFSET", "VOFFSET", "INC", "COORD"];

pub(super) fn read(lines: &[Line<'_>], known: &[i64]) -> Motions {
    let mut found = Motions { known: known.to_vec(), ..Motions::default() };
    let mut statement: Vec<u8> = Vec::new();
    let mut begun = 0;
    for line in lines {
        let text = line.trimmed();
        let digits = text.iter().take_while(|byte| byte.is_ascii_digit()).count();
        let Some(rest) = text[digits..].strip_prefix(b":") else { continue };
        if digits > 0 {
            found.statement(&statement, begun);
            statement.clear();
            begun = line.number;
        }
        statement.extend_from_slice(rest);
        statement.push(b' ');
    }
    found.statement(&statement, begun);
    found
}

impl Motions {
    fn statement(&mut self, bytes: &[u8], line: usize) {
        let text = String::from_utf8_lossy(bytes);
        let text = text.trim();
        if text.is_empty() || text.starts_with(['!', '/', '-']) {
            return;
        }
        let rest = text.strip_prefix(['J', 'L', 'C', 'A', 'S']).unwrap_or("");
        let goes = rest.trim_start().starts_with("P[") || rest.trim_start().starts_with("PR[");
        if goes {
            self.motion(rest, text, line);
        } else if text.starts_with("PR[") && references(text).iter().any(|name| name.0 == "P") {
            let words =
                "a position register is computed from a point: from a compensated one it comes out displaced";
            self.notes.push(Note::refusing(line, shown(text), words.into()));
        }
    }

    fn motion(&mut self, rest: &str, text: &str, line: usize) {
        let all = references(rest);
        let words = rest.split(|c: char| !(c.is_ascii_alphanumeric() || c == '_'));
        let displacing = words.map(str::to_ascii_uppercase).find(|word| DISPLACING.contains(&word.as_str()));
        // Register arguments behind Offset are none of the destinations: at most two stand in front.
        let places = if text.starts_with('C') { 2 } else { 1 };
        for (list, number) in all.into_iter().take(places) {
            match number.filter(|_| list == "P") {
                Some(number) if !self.known.contains(&number) => {
                    self.reached.push(None);
                    self.notes.push(Note::missing(line, shown(text), format!("P[{number}]")));
                }
                Some(number) => {
                    self.reached.push(Some(number));
                    if let Some(word) = &displacing {
                        self.displaced.push((
                            number,
                            format!("{word} in line {line} displaces it while the program runs"),
                        ));
                    }
                }
                None => {
                    self.reached.push(None);
                    let number = number.map_or("…".into(), |number| number.to_string());
                    self.notes.push(Note::missing(line, shown(text), format!("{list}[{number}]")));
                }
            }
        }
    }
}

fn shown(text: &str) -> String {
    text.split_whitespace().collect::<Vec<_>>().join(" ").trim_end_matches(" ;").chars().take(60).collect()
}

/// `P[3:name]`, `PR[1]`, `P[R[2]]`: list and number, none where that is computed.
fn references(text: &str) -> Vec<(&str, Option<i64>)> {
    let mut found = Vec::new();
    let mut from = 0;
    while let Some(at) = text[from..]
        .find("P[")
        .map(|at| from + at)
        .into_iter()
        .chain(text[from..].find("PR[").map(|at| from + at))
        .min()
    {
        let joined = text[..at].ends_with(|c: char| c.is_ascii_alphanumeric() || c == '_');
        let list = if text[at..].starts_with("PR[") { "PR" } else { "P" };
        let inside = &text[at + list.len() + 1..];
        from = at + list.len() + 1;
        if joined {
            continue;
        }
        let digits: String = inside.trim_start().chars().take_while(char::is_ascii_digit).collect();
        let behind = inside.trim_start()[digits.len()..].trim_start();
        let whole = behind.starts_with(']') || behind.starts_with(':') || behind.starts_with(',');
        found.push((list, digits.parse().ok().filter(|_| whole)));
        // A name behind the number may hold anything.
        from += inside.find(']').map_or(inside.len(), |end| end + 1);
    }
    found
}
