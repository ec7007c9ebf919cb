//! A likely mistake in a table, in words.

use crate::{count, significant};
use truepose_identify::{Cause, Suspicion};
use truepose_kinematics::{Chain, JointKind};

/// What was probably done to a table, what says so, and what to do. `lines` are the file's line of each row, where there is a file.
pub fn suspicion_words(chain: &Chain, found: &Suspicion, lines: &[u64]) -> String {
    let mm = |v: f64| format!("{} mm", significant(v * 1e3, 3));
    let axis = |k: usize| ["x", "y", "z"].get(k).copied().unwrap_or("?");
    let joint = |k: usize| chain.movable().get(k).map_or("?", |&j| chain.joint(j).name.as_str());
    let target = |k: usize| chain.targets().get(k).map_or("?", |t| t.name.as_str());
    let with_base = chain.base().known;
    let (what, undone) = match found.cause.clone() {
        Cause::SwappedAxes { a, b } if with_base => {
            (format!("{} and {} look swapped", axis(a), axis(b)), "swapping them")
        }
        Cause::MirroredAxis { axis: k } if with_base => {
            (format!("{} looks as if it had the wrong sign", axis(k)), "turning it round")
        }
        // Wherever the base stands, all mirror images are the same.
        Cause::SwappedAxes { .. } | Cause::MirroredAxis { .. } => (
            "the measurement frame looks left-handed: two of x, y, z swapped, or one with the wrong sign"
                .into(),
            "putting that right",
        ),
        Cause::PositionUnit { factor } => (format!("positions look like {}", unit(factor)), "scaling them"),
        Cause::JointUnit { kind, factor } => {
            let (kind, words) = match (kind, factor > 1.0) {
                (JointKind::Prismatic, true) => ("slides", "metres under a header in mm"),
                (JointKind::Prismatic, false) => ("slides", "millimetres under a header in m"),
                (_, true) => ("turning joints", "radians under a header in deg"),
                (_, false) => ("turning joints", "degrees under a header in rad"),
            };
            (format!("values of {kind} look like {words}"), "converting them")
        }
        Cause::ShiftedJoints { by } => {
            let n = chain.movable().len();
            let places = count(usize::min(by, n.saturating_sub(by)), "place");
            (
                format!(
                    "joint columns look moved by {places}: {} holds what belongs to {}",
                    joint(by),
                    joint(0)
                ),
                "moving them back",
            )
        }
        Cause::ReversedJoints => ("joint columns look reversed, from tip to base".into(), "reversing them"),
        Cause::SwappedJoints { a, b } => {
            (format!("the columns of {} and {} look swapped", joint(a), joint(b)), "swapping them")
        }
        Cause::NegatedJoint { joint: k } => {
            (format!("{} looks as if it counted the other way", joint(k)), "turning its sign")
        }
        Cause::OffsetJoint { joint: k, by } => (
            format!("the zero of {} looks {}° off", joint(k), significant(by.to_degrees(), 3)),
            "adding that",
        ),
        Cause::StaleJoints { late } => (
            format!("joint values look like those of the visit {}", if late { "before" } else { "after" }),
            "moving them by one visit",
        ),
        Cause::SwappedTargets { a, b } => {
            (format!("targets {} and {} look swapped", target(a), target(b)), "swapping them")
        }
        Cause::SwappedLabels { a, b, rows } => {
            return format!(
                "targets {} and {} look swapped in {}, up to {} off: with the names exchanged they lie where the others say ({} RMS); correct the \
                 names",
                target(a),
                target(b),
                named(&rows, lines),
                mm(found.before),
                mm(found.after)
            );
        }
        Cause::StrayRows { rows } => {
            return format!(
                "{} {} far from where the others say, up to {}, against {} RMS of theirs: look at {}, or take `--solver tukey(qr)`",
                named(&rows, lines),
                if rows.len() == 1 { "lies" } else { "lie" },
                mm(found.before),
                mm(found.after),
                if rows.len() == 1 { "it" } else { "them" },
            );
        }
        Cause::BaseElsewhere => {
            return format!(
                "the base is not where the description has it: as it stands the robot misses by {}, with the base where it fits \
                 best {}; correct [base], or say `known = false` there",
                mm(found.before),
                mm(found.after)
            );
        }
    };
    format!("{what}: registration leaves {}, after {undone} {}", mm(found.before), mm(found.after))
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

/// What a factor that puts positions right says about their unit.
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
    fn causes_in_words() {
        let chain = samples::ur10();
        let words =
            |cause: Cause| suspicion_words(&chain, &Suspicion { cause, before: 0.812, after: 4e-4 }, &[]);
        assert_eq!(
            words(Cause::SwappedAxes { a: 0, b: 1 }),
            "x and y look swapped: registration leaves 812 mm, after swapping them 0.400 mm"
        );
        assert!(
            words(Cause::PositionUnit { factor: 1e3 })
                .starts_with("positions look like metres taken for millimetres (a factor of 1000):")
        );
        let names: Vec<&str> = chain.movable().iter().map(|&j| chain.joint(j).name.as_str()).collect();
        let shifted = words(Cause::ShiftedJoints { by: 1 });
        assert!(
            shifted.starts_with(&format!(
                "joint columns look moved by 1 place: {} holds what belongs to {}",
                names[1], names[0]
            )),
            "{shifted}"
        );
        let lost = chain.clone().with_base(Placed { known: false, ..*chain.base() });
        let lost = lost.map(|c| {
            suspicion_words(
                &c,
                &Suspicion { cause: Cause::MirroredAxis { axis: 2 }, before: 0.8, after: 0.0 },
                &[],
            )
        });
        assert!(lost.is_ok_and(|w| w.starts_with("the measurement frame looks left-handed")));
    }
}
