//! Frames and tools of a controller: `UFRAME.CND` and `TOOL.CND`.
//!
//! ```text
//! //UFRAME 1                       //TOOL 1
//! ///NAME TABLE                    ///NAME GUN
//! ////BUSER x,y,z,Rx,Ry,Rz         x,y,z,Rx,Ry,Rz
//! ```

use crate::Dialect;
use crate::lines::lines;
use crate::number::number_at;
use crate::program::{Definition, Definitions};

/// Whether a text is one of these.
pub(super) fn is(text: &[u8]) -> bool {
    lines(text).iter().any(|line| head(line.trimmed()).is_some())
}

/// `USER 1`, `TOOL 1`, … with their values.
pub(super) fn read(text: &[u8], definitions: &mut Definitions) {
    let mut name: Option<String> = None;
    for line in lines(text) {
        if let Some(found) = head(line.trimmed()) {
            name = Some(found);
            continue;
        }
        let user = name.as_ref().is_some_and(|name| name.starts_with("USER"));
        let numbers = if user { line.after("////BUSER") } else { Some(line.trimmed()) };
        let Some(numbers) = numbers.map(|bytes| six(bytes.trim_ascii())) else { continue };
        if numbers.len() == 6
            && let Some(name) = name.take()
        {
            let found = Dialect::Inform.pose(&numbers);
            let unusable = || Definition::Unusable(format!("{name} is not made of numbers"));
            definitions.put(name.clone(), found.map_or_else(unusable, Definition::Value));
        }
    }
}

/// `//UFRAME 1`, `//TOOL 1`.
fn head(bytes: &[u8]) -> Option<String> {
    let text = std::str::from_utf8(bytes).ok()?;
    let mut words = text.split_whitespace();
    let kind = match words.next()? {
        "//UFRAME" => "USER",
        "//TOOL" => "TOOL",
        _ => return None,
    };
    let number: u32 = words.next()?.parse().ok()?;
    Some(format!("{kind} {number}"))
}

/// Six numbers between commas.
fn six(bytes: &[u8]) -> Vec<f64> {
    let one = |part: &[u8]| {
        let part = part.trim_ascii();
        number_at(part).filter(|(_, length)| *length == part.len()).map(|(value, _)| value)
    };
    let all: Option<Vec<f64>> = bytes.split(|&byte| byte == b',').map(one).collect();
    all.filter(|numbers| numbers.len() == 6).unwrap_or_default()
}
