//! A suspected mistake in a table of measurements, as text.

use crate::{count, significant};
use truepose_identify::{Cause, Suspicion};
use truepose_kinematics::{Chain, JointKind};

/// The suspected mistake, the evidence for it, and what to do. `lines` are the line numbers of the rows in the file, if any.
pub fn suspicion_text(chain: &Chain, found: &Suspicion, lines: &[u64]) -> String {
    let mm = |v: f64| format!("{} mm", significant(v * 1e3, 3));
    let target = |k: usize| chain.targets().get(k).map_or("?", |t| t.name.as_str());
    match &found.cause {
        Cause::SwappedLabels { a, b, rows } => format!(
            "targets {} and {} seem swapped in {}, up to {} off: with the names exchanged they agree with the other rows ({} RMS); correct \
             the names",
            target(*a),
            target(*b),
            named(rows, lines),
            mm(found.before),
            mm(found.after)
        ),
        Cause::InSomeRows { rows, mistake } => {
            let (what, undone) = mistake_text(chain, mistake);
            format!(
                "in {}, up to {} off, {what}: after {undone} they agree with the other rows ({} RMS with the robot as described); correct {}",
                ranges(rows, lines),
                mm(found.before),
                mm(found.after),
                if rows.len() == 1 { "it" } else { "them" }
            )
        }
        Cause::StrayRows { rows } => format!(
            "{} {} with the other rows: errors up to {}, against {} RMS of the others; check {}, or use `--solver tukey(qr)`",
            named(rows, lines),
            if rows.len() == 1 { "disagrees" } else { "disagree" },
            mm(found.before),
            mm(found.after),
            if rows.len() == 1 { "it" } else { "them" },
        ),
        Cause::BaseElsewhere => format!(
            "the base differs from the description: the position error is {} with the described base and {} with the base that fits \
             best; correct [base], or set `known = false` there",
            mm(found.before),
            mm(found.after)
        ),
        cause => {
            let (what, undone) = mistake_text(chain, cause);
            format!("{what}: registration RMS {}, after {undone} {}", mm(found.before), mm(found.after))
        }
    }
}

/// What was done, and what undoes it; of what is done to a table, or to some of its rows.
fn mistake_text(chain: &Chain, cause: &Cause) -> (String, &'static str) {
    let axis = |k: usize| ["x", "y", "z"].get(k).copied().unwrap_or("?");
    let joint = |k: usize| chain.movable().get(k).map_or("?", |&j| chain.joint(j).name.as_str());
    let target = |k: usize| chain.targets().get(k).map_or("?", |t| t.name.as_str());
    let with_base = chain.base().known;
    match cause.clone() {
        Cause::SwappedAxes { a, b } if with_base => {
            (format!("{} and {} seem swapped", axis(a), axis(b)), "swapping them")
        }
        Cause::MirroredAxis { axis: k } if with_base => {
            (format!("{} seems to have the wrong sign", axis(k)), "changing it")
        }
        // Wherever the base stands, all mirror images are the same.
        Cause::SwappedAxes { .. } | Cause::MirroredAxis { .. } => (
            "the measurement frame seems left-handed: two of x, y, z swapped, or one with the wrong sign"
                .into(),
            "correcting that",
        ),
        Cause::PositionUnit { factor } => (format!("positions seem to be {}", unit(factor)), "scaling them"),
        Cause::JointUnit { kind, factor } => {
            let (kind, words) = match (kind, factor > 1.0) {
                (JointKind::Prismatic, true) => ("prismatic joints", "metres under a header in mm"),
                (JointKind::Prismatic, false) => ("prismatic joints", "millimetres under a header in m"),
                (_, true) => ("revolute joints", "radians under a header in deg"),
                (_, false) => ("revolute joints", "degrees under a header in rad"),
            };
            (format!("values of {kind} seem to be {words}"), "converting them")
        }
        Cause::ShiftedJoints { by } => {
            let n = chain.movable().len();
            let places = count(usize::min(by, n.saturating_sub(by)), "place");
            (
                format!(
                    "joint columns seem shifted by {places}: {} contains the values of {}",
                    joint(by),
                    joint(0)
                ),
                "shifting them back",
            )
        }
        Cause::ReversedJoints => ("joint columns seem reversed, from tip to base".into(), "reversing them"),
        Cause::SwappedJoints { a, b } => {
            (format!("the columns of {} and {} seem swapped", joint(a), joint(b)), "swapping them")
        }
        Cause::NegatedJoint { joint: k } => {
            (format!("{} seems to have the opposite sign", joint(k)), "changing its sign")
        }
        Cause::OffsetJoint { joint: k, by } => (
            format!("the zero of {} seems {}° off", joint(k), significant(by.to_degrees(), 3)),
            "correcting it",
        ),
        Cause::StaleJoints { late } => (
            format!(
                "joint values seem to be those of the pose measurement {}",
                if late { "before" } else { "after" }
            ),
            "shifting them by one pose measurement",
        ),
        Cause::SwappedTargets { a, b } => {
            (format!("targets {} and {} seem swapped", target(a), target(b)), "swapping them")
        }
        _ => ("the rows seem mistaken".into(), "correcting them"),
    }
}

/// Rows by their numbers, with their lines in the file.
fn named(rows: &[usize], lines: &[u64]) -> String {
    const NAMED: usize = 10;
    let one = |row: &usize| match lines.get(*row) {
        Some(line) => format!("{} (line {line})", row + 1),
        None => (row + 1).to_string(),
    };
    let listed: Vec<String> = rows.iter().take(NAMED).map(one).collect();
    let more = match rows.len().saturating_sub(NAMED) {
        0 => String::new(),
        n => format!(" and {n} more"),
    };
    format!("{} {}{more}", if rows.len() == 1 { "row" } else { "rows" }, listed.join(", "))
}

/// Rows by their numbers, and their lines in the file, as ranges.
fn ranges(rows: &[usize], lines: &[u64]) -> String {
    const NAMED: usize = 5;
    let mut all: Vec<(usize, usize)> = Vec::new();
    for &row in rows {
        match all.last_mut().filter(|(_, last)| last + 1 == row) {
            Some((_, last)) => *last = row,
            None => all.push((row, row)),
        }
    }
    let one = |&(first, last): &(usize, usize)| {
        let line = |row: usize| lines.get(row).map_or_else(String::new, ToString::to_string);
        match (first == last, lines.get(last).is_some()) {
            (true, true) => format!("{} (line {})", first + 1, line(first)),
            (true, false) => (first + 1).to_string(),
            (false, true) => {
                format!("{} to {} (lines {} to {})", first + 1, last + 1, line(first), line(last))
            }
            (false, false) => format!("{} to {}", first + 1, last + 1),
        }
    };
    let listed: Vec<String> = all.iter().take(NAMED).map(one).collect();
    let named: usize = all.iter().take(NAMED).map(|(first, last)| last - first + 1).sum();
    let more = match rows.len() - named {
        0 => String::new(),
        n => format!(" and {n} more"),
    };
    format!("{} {}{more}", if rows.len() == 1 { "row" } else { "rows" }, listed.join(", "))
}

/// The mistake in the unit that a factor on positions corrects.
fn unit(factor: f64) -> &'static str {
    match factor {
        f if f > 500.0 => "metres taken for millimetres (a factor of 1000)",
        f if f > 30.0 => "metres taken for inches",
        f if f > 2.0 => "inches taken for millimetres",
        f if f > 0.035 => "millimetres taken for inches",
        f if f > 2e-3 => "inches taken for metres",
        _ => "millimetres taken for metres (a factor of 1000)",
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use truepose_kinematics::{Placed, samples};

    #[test]
    fn causes_as_text() {
        let chain = samples::ur10();
        let text =
            |cause: Cause| suspicion_text(&chain, &Suspicion { cause, before: 0.812, after: 4e-4 }, &[]);
        assert_eq!(
            text(Cause::SwappedAxes { a: 0, b: 1 }),
            "x and y seem swapped: registration RMS 812 mm, after swapping them 0.400 mm"
        );
        assert!(
            text(Cause::PositionUnit { factor: 1e3 })
                .starts_with("positions seem to be metres taken for millimetres (a factor of 1000):")
        );
        let names: Vec<&str> = chain.movable().iter().map(|&j| chain.joint(j).name.as_str()).collect();
        let shifted = text(Cause::ShiftedJoints { by: 1 });
        assert!(
            shifted.starts_with(&format!(
                "joint columns seem shifted by 1 place: {} contains the values of {}",
                names[1], names[0]
            )),
            "{shifted}"
        );
        let lost = chain.clone().with_base(Placed { known: false, ..*chain.base() });
        let lost = lost.map(|c| {
            suspicion_text(
                &c,
                &Suspicion { cause: Cause::MirroredAxis { axis: 2 }, before: 0.8, after: 0.0 },
                &[],
            )
        });
        assert!(lost.is_ok_and(|w| w.starts_with("the measurement frame seems left-handed")));
    }
}
