//! Frames and tools of a controller: its system variables as text (`SYSFRAME.VA`).
//!
//! ```text
//! [*SYSTEM*]$MNUFRAME  …  : ARRAY[1,10] OF POSITION
//!      [1,2] =   Group: 1   Config: N U T, 0, 0, 0
//!   X:   500.000   Y:     0.000   Z:     0.000
//!   W:     0.000   P:     0.000   R:    90.000
//! ```
//!
//! `$MNUFRAME[1,n]` is the user frame n, `$MNUTOOL[1,n]` the tool n.

use crate::Dialect;
use crate::lines::lines;
use crate::number::number_at;
use crate::program::{Definition, Definitions};

/// Whether a text is one of these.
pub(super) fn is(text: &[u8]) -> bool {
    lines(text).iter().any(|line| variable(line.bytes).is_some())
}

/// `UF1`, `UT1`, … with their values.
pub(super) fn read(text: &[u8], definitions: &mut Definitions) {
    let mut kind: Option<&str> = None;
    let mut at: Option<(String, Vec<f64>)> = None;
    for line in lines(text) {
        let bytes = line.trimmed();
        if bytes.starts_with(b"[*") {
            (kind, at) = (variable(bytes), None);
        } else if let (Some(kind), true) = (kind, bytes.starts_with(b"[")) {
            at = element(bytes).map(|number| (format!("{kind}{number}"), Vec::new()));
        } else if let Some((name, numbers)) = &mut at {
            numbers.extend(components(bytes, numbers.len()));
            if numbers.len() == 6 {
                let found = Dialect::Fanuc.pose(numbers);
                let unusable = || Definition::Unusable(format!("{name} is not made of numbers"));
                definitions.put(name.clone(), found.map_or_else(unusable, Definition::Value));
                at = None;
            }
        }
    }
}

fn variable(bytes: &[u8]) -> Option<&'static str> {
    let text = String::from_utf8_lossy(bytes);
    let name = text.split(']').nth(1)?.split_whitespace().next()?;
    match name {
        "$MNUFRAME" => Some("UF"),
        "$MNUTOOL" => Some("UT"),
        _ => None,
    }
}

/// The number of `[1,2] = …`; those of other groups are none.
fn element(bytes: &[u8]) -> Option<u32> {
    let text = String::from_utf8_lossy(bytes);
    let (group, number) = text.strip_prefix('[')?.split(']').next()?.split_once(',')?;
    (group.trim() == "1").then(|| number.trim().parse().ok()).flatten()
}

/// `X: 500.000  Y: …` in the order of a pose, from this component on.
fn components(bytes: &[u8], from: usize) -> Vec<f64> {
    let text = String::from_utf8_lossy(bytes);
    let mut words = text.split([':', ' ', '\t']).filter(|word| !word.is_empty());
    let mut found = Vec::new();
    for name in ["X", "Y", "Z", "W", "P", "R"].iter().skip(from) {
        let number = words.next().filter(|word| word == name).and_then(|_| words.next());
        let Some((value, _)) = number.and_then(|word| number_at(word.as_bytes())) else { break };
        found.push(value);
    }
    found
}
