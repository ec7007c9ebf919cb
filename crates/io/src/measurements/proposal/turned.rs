//! Which columns hold measured orientations, and in which convention: by their names, held against the robot.

use super::super::columns::Role;
use super::super::names::Names;
use super::super::orientation::OrientationConvention as Convention;
use super::fitting::{Measured, Turns};
use super::groups::{Group, coordinates, runs, unit_length};
use super::seen::Seen;
use super::{Proposal, units};
use crate::Quantity;

/// Below this an orientation agrees with the robot, rad; the next reading has to be so many times worse.
const AGREES: f64 = 0.1;
const WORSE: f64 = 5.0;

/// A way to read columns: in the order of the names.
struct Reading {
    /// What it is called in messages.
    called: String,
    columns: Vec<usize>,
    names: Vec<&'static str>,
    orientation: Option<&'static str>,
    turns: Turns,
    /// The header names the convention.
    by_header: bool,
}

/// Proposes columns and convention of measured orientations.
pub(super) fn propose(
    seen: &mut [Seen<'_>],
    names: &Names<'_>,
    joints: Option<&[(usize, crate::Unit)]>,
    all: &mut Proposal,
) {
    let turned = |column: &Seen<'_>| {
        matches!(column.role, Some(Role::Quaternion(_) | Role::RotationVector(_) | Role::Angle(_)))
    };
    if names.map.orientation.is_some() || seen.iter().any(turned) {
        return;
    }
    let mut readings = quaternions(seen);
    if readings.is_empty() {
        readings = angles(seen);
    }
    if readings.is_empty() {
        return;
    }
    let chosen = match joints.and_then(|joints| Measured::of(seen, names.chain, joints)) {
        // Three angles about x, y and z have four readings, which the robot alone tells apart.
        None if readings[0].names == ["rx", "ry", "rz"] && !readings[0].by_header => None,
        None => readings.into_iter().next().map(|reading| (reading, String::new())),
        Some(measured) => choose(seen, readings, &measured, all),
    };
    let Some((reading, told)) = chosen else { return };
    let unit = match reading.turns {
        Turns::Quaternion => None,
        _ => units::of_angles(seen, &reading.columns).map(|unit| unit.word),
    };
    for (&k, name) in reading.columns.iter().zip(&reading.names) {
        // A column that has the name in the convention and its unit needs no line.
        let named =
            reading.orientation.is_some() && seen[k].header.eq_ignore_ascii_case(name) && unit.is_none();
        if named {
            seen[k].free = false;
        } else {
            all.pair(&mut seen[k], name, unit);
        }
    }
    all.orientation = reading.orientation;
    all.notes.extend((!told.is_empty()).then_some(told));
}

/// The reading that agrees with the robot; the first where none does, or several do alike.
fn choose(
    seen: &[Seen<'_>],
    readings: Vec<Reading>,
    measured: &Measured,
    all: &mut Proposal,
) -> Option<(Reading, String)> {
    let mut judged: Vec<(f64, Reading)> = readings
        .into_iter()
        .filter_map(|reading| {
            let unit = units::of_angles(seen, &reading.columns);
            Some((measured.misfit(seen, &reading.columns, reading.turns, unit)?, reading))
        })
        .collect();
    let first = judged.first()?.1.called.clone();
    judged.sort_by(|a, b| a.0.total_cmp(&b.0));
    let told: Vec<String> =
        judged.iter().map(|(misfit, reading)| format!("{} {:.3}", reading.called, misfit)).collect();
    let told = format!("orientations against the nominal robot, RMS in rad: {}", told.join(", "));
    let clear =
        judged[0].0 < AGREES && judged.iter().skip(1).all(|(misfit, _)| *misfit > WORSE * judged[0].0);
    if clear {
        let (_, reading) = judged.swap_remove(0);
        return Some((reading, told));
    }
    if judged[0].0 >= AGREES {
        let told = if told.is_empty() {
            format!("orientations are {:.3} rad RMS off the nominal robot", judged[0].0)
        } else {
            told
        };
        all.notes.push(format!(
            "{told}; none of them agrees, so that no orientation is proposed (by name they would be {first})"
        ));
        return None;
    }
    let at = judged.iter().position(|(_, reading)| reading.called == first)?;
    let told = format!("{told}; the rows do not tell them apart: check --orientation");
    (judged[at].0 < AGREES).then(|| (judged.swap_remove(at).1, told))
}

/// Four columns of unit length: named x y z w, or numbered, scalar first or last.
fn quaternions(seen: &[Seen<'_>]) -> Vec<Reading> {
    let reading = |called: &str, columns: Vec<usize>| Reading {
        called: called.into(),
        columns,
        names: vec!["qw", "qx", "qy", "qz"],
        orientation: None,
        turns: Turns::Quaternion,
        by_header: false,
    };
    let known = |columns: &[usize]| seen[columns[0]].cells.is_empty() || unit_length(seen, columns);
    let groups = coordinates(seen);
    let mut named = groups.iter().filter(|group| group.columns.len() == 4 && known(&group.columns));
    if let (Some(Group { columns, .. }), None) = (named.next(), named.next()) {
        return vec![reading("named", vec![columns[3], columns[0], columns[1], columns[2]])];
    }
    let runs = runs(seen, 4, |k| seen[k].free && seen[k].unit.is_none() && seen[k].may_be_numbers());
    let mut runs = runs.iter().filter(|run| unit_length(seen, run));
    let (Some(run), None) = (runs.next(), runs.next()) else { return Vec::new() };
    let mut first = reading("scalar first", run.clone());
    if run.iter().zip(["q1", "q2", "q3", "q4"]).all(|(&k, name)| seen[k].header.eq_ignore_ascii_case(name)) {
        first.orientation = Some("q1q2q3q4");
        first.names = vec!["q1", "q2", "q3", "q4"];
    }
    vec![first, reading("scalar last", vec![run[3], run[0], run[1], run[2]])]
}

/// Names of three angles, and the conventions that use them, the usual one first.
const ANGLES: [([&str; 3], &[&str]); 5] = [
    (["w", "p", "r"], &["wpr"]),
    (["a", "b", "c"], &["abc"]),
    (["roll", "pitch", "yaw"], &["rpy"]),
    (["o", "a", "t"], &["zyz"]),
    (["rx", "ry", "rz"], &["fixed_xyz", "xyz", "zyz", "rotation_vector"]),
];

/// Three columns of angles.
fn angles(seen: &[Seen<'_>]) -> Vec<Reading> {
    let angle = |column: &Seen<'_>| match column.measure() {
        Some(unit) => unit.quantity == Quantity::Angle,
        None => column.unit.is_none(),
    };
    let free = |k: &usize| seen[*k].free && angle(&seen[*k]) && seen[*k].may_be_numbers();
    for (words, conventions) in ANGLES {
        let one = |word: &str| {
            let bears = |k: &usize| seen[*k].has(&[word]) && free(k);
            let mut these = (0..seen.len()).filter(bears);
            these.next().filter(|_| these.next().is_none())
        };
        let found: Option<Vec<usize>> = words.iter().map(|word| one(word)).collect();
        let Some(columns) = found else { continue };
        // What else their headers say is the same.
        let rest = |k: usize, word: &str| -> Vec<String> {
            seen[k].words.iter().filter(|other| *other != word).cloned().collect()
        };
        if (1..3).any(|k| rest(columns[k], words[k]) != rest(columns[0], words[0])) {
            continue;
        }
        return readings(seen, &columns, words, conventions);
    }
    let mut groups = coordinates(seen);
    groups.retain(|group| group.is_turn() && group.columns.len() == 3 && group.columns.iter().all(&free));
    match &groups[..] {
        [group] => readings(seen, &group.columns, ["rx", "ry", "rz"], ANGLES[4].1),
        _ => Vec::new(),
    }
}

/// These columns in each of the conventions, and those that the header names first.
fn readings(
    seen: &[Seen<'_>],
    columns: &[usize],
    words: [&'static str; 3],
    usual: &[&'static str],
) -> Vec<Reading> {
    let column = &seen[columns[0]];
    let mut conventions: Vec<&'static str> = usual.to_vec();
    if column.has(&["fixed"]) {
        conventions.retain(|word| *word == "fixed_xyz");
    } else if column.has(&["rotvec", "vector"]) {
        conventions.retain(|word| *word == "rotation_vector");
    }
    let by_header = conventions.len() < usual.len();
    let reading = |convention: &'static str, names: Vec<&'static str>| {
        let turns = Convention::named(convention).map_or(Turns::Vector, Turns::Angles);
        let turns = if convention == "rotation_vector" { Turns::Vector } else { turns };
        Reading {
            called: convention.into(),
            columns: columns.to_vec(),
            names,
            orientation: Some(convention),
            turns,
            by_header,
        }
    };
    let mut all: Vec<Reading> =
        conventions.iter().map(|convention| reading(convention, words.to_vec())).collect();
    // The others, for headers that are wrong.
    for (names, others) in [
        (["rx", "ry", "rz"], &["fixed_xyz", "xyz", "zyz", "rotation_vector"][..]),
        (["a", "b", "c"], &["abc"]),
    ] {
        for other in others {
            let same = |known: &Reading| Convention::named(&known.called) == Convention::named(other);
            let alike =
                all.iter().any(|known| same(known) || (known.called == "wpr" && *other == "fixed_xyz"));
            if !alike {
                all.push(reading(other, names.to_vec()));
            }
        }
    }
    all
}
