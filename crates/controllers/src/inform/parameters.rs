//! Parameters of a controller, `ALL.PRM` and `RC.PRM`: how many pulses of an axis make a degree.
//!
//! ```text
//! ///RC1G                          the first robot, ///RC2G the second
//! n,n,n,n,n,n,n,n,n,n              lines of parameters
//! pulses per degree = 4096 n / (360 d)
//! ```
//!
//! | controller | lines of a group | d, gear's denominators | n, numerators |
//! | --- | --- | --- | --- |
//! | up to DX200 | 100 to 199 | line 97 from the third value on (972 to 977) | line 98 (980 to 985) |
//! | YRC | 200 and more | line 109 | line 110 |
//!
//! Lines count from zero. The sign of an axis is not among them, and a motor is taken to have 4096 pulses a turn: these figures propose a value
//! of `--pulses`, and refuse one that contradicts them.

use crate::lines::lines;
use crate::number::number_at;

/// Axes of a robot in a group.
const AXES: usize = 6;
/// Pulses of a motor's turn.
const TURN: f64 = 4096.0;
/// Pulses per degree that a robot's axis can have.
const PLAUSIBLE: std::ops::RangeInclusive<f64> = 10.0..=100_000.0;

/// Whether a text has parameters of a controller.
pub(super) fn is(text: &[u8]) -> bool {
    lines(text).iter().any(|line| is_head(line.trimmed()))
}

/// `///RC1G`, `///S1C1G`: the head of a group of parameters.
fn is_head(line: &[u8]) -> bool {
    let name = line.strip_prefix(b"///").unwrap_or_default();
    name.len() > 3 && name.ends_with(b"G") && (name.starts_with(b"RC") || name.starts_with(b"S1C"))
}

/// Pulses per degree of the six axes of a robot (1, 2, …), without their signs; none where the layout is another one.
pub(super) fn pulses_per_degree(text: &[u8], robot: u32) -> Option<Vec<f64>> {
    let head = format!("///RC{robot}G");
    let lines = lines(text);
    let group = lines.iter().skip_while(|line| line.trimmed() != head.as_bytes()).skip(1);
    let group: Vec<&[u8]> = group
        .map(|line| line.trimmed())
        .take_while(|line| !line.starts_with(b"/"))
        .filter(|line| !line.is_empty())
        .collect();
    let values = |at: usize, skipped: usize| -> Option<Vec<f64>> {
        let one = |part: &[u8]| {
            let part = part.trim_ascii();
            number_at(part).filter(|(_, length)| *length == part.len()).map(|(value, _)| value)
        };
        let all: Vec<f64> = group.get(at)?.split(|&byte| byte == b',').map(one).collect::<Option<_>>()?;
        // Short lines begin with the first axis.
        let from = if all.len() >= skipped + 8 { skipped } else { 0 };
        all.get(from..from + AXES).map(<[f64]>::to_vec)
    };
    let (denominators, numerators) = match group.len() {
        0..100 => return None,
        100..200 => (values(97, 2)?, values(98, 0)?),
        _ => (values(109, 0)?, values(110, 0)?),
    };
    let each = numerators.iter().zip(&denominators).map(|(n, d)| (TURN * n / (360.0 * d)).abs());
    let all: Vec<f64> = each.collect();
    all.iter().all(|pulses| PLAUSIBLE.contains(pulses)).then_some(all)
}

/// The robot of a job, by `///GROUP1 RB1,…`; the first where none is stated.
pub(super) fn robot(text: &[u8]) -> u32 {
    let lines = lines(text);
    let group = lines.iter().find_map(|line| line.after("///GROUP1"));
    let words = group.map(|rest| String::from_utf8_lossy(rest).into_owned()).unwrap_or_default();
    words.split(',').find_map(|word| word.trim().strip_prefix("RB")?.parse().ok()).unwrap_or(1)
}
