//! Frames, tools and payloads of a controller: its system variables as text (`SYSFRAME.VA`, `SYMOTN.VA`).
//!
//! ```text
//! [*SYSTEM*]$MNUFRAME  …  : ARRAY[1,10] OF POSITION
//!      [1,2] =   Group: 1   Config: N U T, 0, 0, 0
//!   X:   500.000   Y:     0.000   Z:     0.000
//!   W:     0.000   P:     0.000   R:    90.000
//! ```
//!
//! `$MNUFRAME[1,n]` is the user frame n, `$MNUTOOL[1,n]` the tool n. Payload schedule n is in kg and cm:
//!
//! ```text
//!      Field: $PLST_GRP1[2].$PAYLOAD Access: RW: REAL = 1.480000e+02
//!      Field: $PLST_GRP1[2].$PAYLOAD_X Access: RW: REAL = 0.000000e+00        _Y, _Z
//! ```

use super::statements::statements;
use crate::Dialect;
use crate::definitions::{Definition, Definitions};
use crate::lines::lines;
use crate::number::number_at;
use std::collections::BTreeMap;
use truepose_kinematics::nalgebra::Vector3;

/// Whether a text is one of these.
pub(super) fn is(text: &[u8]) -> bool {
    lines(text).iter().any(|line| variable(line.bytes).is_some() || payload(line.trimmed()).is_some())
}

/// `UF1`, `UT1`, `PAYLOAD[1]`, … with their values.
pub(super) fn read(text: &[u8], definitions: &mut Definitions) {
    let mut payloads: BTreeMap<u32, [f64; 4]> = BTreeMap::new();
    for (number, part, value) in lines(text).iter().filter_map(|line| payload(line.trimmed())) {
        payloads.entry(number).or_insert([f64::NAN; 4])[part] = value;
    }
    for (number, [mass, x, y, z]) in payloads {
        let name = format!("PAYLOAD[{number}]");
        let load = match mass >= 0.0 && [x, y, z].iter().all(|v| v.is_finite()) {
            true => Definition::Load(mass, 1e-2 * Vector3::new(x, y, z)),
            false => Definition::Unusable(format!("{name} is not set")),
        };
        definitions.put(name, load);
    }
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

/// Frames and tools to which a program gives another value, with the line: `UFRAME[1]=PR[3]`, `$MNUTOOL[1,2]=…`.
pub(super) fn changed(text: &[u8]) -> Vec<(String, usize)> {
    let one = |(text, line): (String, usize)| {
        let (name, _) = text.split_once('=')?;
        let name = name.replace(' ', "");
        let (list, inside) = name.split_once('[')?;
        let kind = match list {
            "UFRAME" | "$MNUFRAME" => "UF",
            "UTOOL" | "$MNUTOOL" => "UT",
            _ => return None,
        };
        let number = inside.strip_suffix(']')?.rsplit([',', ':']).find_map(|part| part.parse::<u32>().ok());
        // One that is computed may be any.
        Some(match number {
            Some(number) => vec![(format!("{kind}{number}"), line)],
            None => (1..MOST_FRAMES).map(|number| (format!("{kind}{number}"), line)).collect(),
        })
    };
    statements(&lines(text)).into_iter().filter_map(one).flatten().collect()
}

/// Controllers have fewer frames and tools.
const MOST_FRAMES: u32 = 100;

fn variable(bytes: &[u8]) -> Option<&'static str> {
    let text = String::from_utf8_lossy(bytes);
    let name = text.split(']').nth(1)?.split_whitespace().next()?;
    match name {
        "$MNUFRAME" => Some("UF"),
        "$MNUTOOL" => Some("UT"),
        _ => None,
    }
}

/// Schedule, part (mass, x, y, z) and value of a payload.
fn payload(bytes: &[u8]) -> Option<(u32, usize, f64)> {
    let text = std::str::from_utf8(bytes).ok()?;
    let (number, rest) = text.strip_prefix("Field: $PLST_GRP1[")?.split_once("].$PAYLOAD")?;
    let part = match rest.split_whitespace().next()? {
        "Access:" => 0,
        "_X" => 1,
        "_Y" => 2,
        "_Z" => 3,
        _ => return None,
    };
    let value = rest.rsplit_once('=')?.1.trim();
    Some((number.trim().parse().ok()?, part, value.parse().ok()?))
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
