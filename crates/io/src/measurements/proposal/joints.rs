//! Which columns hold the joints.

use super::super::columns::{Role, joint_names, joint_quantity};
use super::groups::{MEASURED, runs, unit_length};
use super::seen::{Seen, words};
use super::{Proposal, units};
use crate::nearest::nearest;
use crate::{Quantity, Unit};
use truepose_kinematics::Chain;

/// Words that stand for a joint before its number.
const JOINT_WORDS: [&str; 20] = [
    "j", "a", "q", "s", "axis", "axe", "ax", "achse", "joint", "joints", "gelenk", "theta", "jt", "rob",
    "rax", "angle", "winkel", "position", "pos", "th",
];

/// Words of what joints have besides a place.
const NO_JOINT: [&str; 19] = [
    "vel",
    "velocity",
    "speed",
    "effort",
    "torque",
    "current",
    "temp",
    "temperature",
    "std",
    "sd",
    "err",
    "error",
    "acc",
    "force",
    "moment",
    "voltage",
    "quat",
    "cmd",
    "command",
];

/// Names that Universal Robots' joints have in descriptions, and on the pendant.
const UNIVERSAL: [[&str; 6]; 2] = [
    ["shoulder pan", "shoulder lift", "elbow", "wrist 1", "wrist 2", "wrist 3"],
    ["base", "shoulder", "elbow", "wrist 1", "wrist 2", "wrist 3"],
];

/// The column of every joint, and its unit.
pub(super) type Joints = Vec<(usize, Unit)>;

/// Proposes columns for the joints that have none, and units for those that cannot be meant without.
pub(super) fn propose(seen: &mut [Seen<'_>], chain: &Chain, all: &mut Proposal) -> Option<Joints> {
    let names: Vec<&str> = joint_names(chain).collect();
    let mut found: Vec<Option<usize>> = (0..names.len())
        .map(|k| seen.iter().position(|column| column.role == Some(Role::Joint(k))))
        .collect();
    let known: Vec<bool> = found.iter().map(Option::is_some).collect();
    if known.iter().any(|known| !known) {
        by_cells(seen, &names, &mut found, all);
        by_name(seen, &names, &mut found);
        if found.iter().any(Option::is_none) {
            by_number(seen, &known, &mut found, all);
        }
        if found.iter().any(Option::is_some) {
            nearly(seen, &names, &mut found);
        }
        for usual in UNIVERSAL {
            if found.iter().all(Option::is_none) && names.len() == usual.len() {
                by_name(seen, &usual, &mut found);
                // Some of them would be a guess.
                if found.iter().any(Option::is_none) {
                    found.fill(None);
                }
            }
        }
    }
    let mut joints = Vec::new();
    let columns: Vec<usize> = found.iter().flatten().copied().collect();
    for (k, at) in found.iter().enumerate() {
        let Some(at) = *at else { continue };
        let quantity = joint_quantity(chain, k);
        let unit = match seen[at].measure() {
            Some(unit) if unit.quantity == quantity => Some(unit),
            Some(_) => None,
            None => units::of_joints(seen, &columns, chain, k),
        };
        if !known[k] {
            all.pair(&mut seen[at], names[k], unit.map(|unit| unit.word));
        } else if seen[at].unit.is_none()
            && let Some(unit) = unit.filter(|unit| !unit.is_si())
        {
            all.pair(&mut seen[at], names[k], Some(unit.word));
        }
        joints.push((at, *unit.unwrap_or(quantity.si())));
    }
    (joints.len() == names.len()).then_some(joints)
}

/// Columns beside those whose cells are the joints' names: `field.position2` where every cell of `field.name2` is a joint's, as `rostopic echo -p` writes
/// the state of joints.
fn by_cells(seen: &mut [Seen<'_>], names: &[&str], found: &mut [Option<usize>], all: &mut Proposal) {
    let (mut beside, mut of_names) = (vec![None; names.len()], Vec::new());
    for (name, slot) in names.iter().zip(&mut beside) {
        let named = |column: &&Seen<'_>| {
            column.free && !column.cells.is_empty() && column.cells.iter().all(|cell| cell == name)
        };
        let place = |column: &Seen<'_>| {
            let (front, number) = column.header.rsplit_once("name")?;
            let wanted = format!("{front}position{number}");
            seen.iter().position(|column| usable(column) && column.header == wanted)
        };
        let mut these = seen.iter().filter(named).filter_map(|column| Some((place(column)?, column.header)));
        if let (Some((at, header)), None) = (these.next(), these.next()) {
            *slot = Some(at);
            of_names.push(header);
        }
    }
    // Some of them would be a guess.
    if beside.iter().zip(found.iter()).all(|(beside, found)| beside.is_some() && found.is_none()) {
        found.copy_from_slice(&beside);
        all.ignore.extend(of_names.iter().map(|header| (*header).to_owned()));
        let listed = |column: &mut Seen<'_>| column.free = !of_names.contains(&column.header) && column.free;
        seen.iter_mut().for_each(listed);
        all.notes
            .push("the names of the joints are those in the first rows: all rows need the same order".into());
    }
}

/// Columns that bear a joint's name, whole or as a part of a path.
fn by_name(seen: &[Seen<'_>], names: &[&str], found: &mut [Option<usize>]) {
    let plain = |text: &str| {
        let words = words(text);
        let bare: Vec<String> = words.iter().filter(|word| *word != "joint").cloned().collect();
        if bare.iter().all(|word| word.parse::<u32>().is_ok()) { words.concat() } else { bare.concat() }
    };
    for (name, slot) in names.iter().zip(found).filter(|(_, slot)| slot.is_none()) {
        let wanted = plain(name);
        let bears = |column: &Seen<'_>| {
            let name = super::super::spelled_units::split_unit(column.header).0;
            plain(name) == wanted
                || name.split(['/', '.', ':']).any(|part| plain(part) == wanted)
                || (wanted.len() > 3
                    && plain(name).strip_suffix("position").is_some_and(|name| name == wanted))
        };
        let mut these = seen.iter().enumerate().filter(|(_, column)| usable(column) && bears(column));
        *slot = these.next().filter(|_| these.next().is_none()).map(|(k, _)| k);
    }
}

fn usable(column: &Seen<'_>) -> bool {
    column.free && column.may_be_numbers() && !column.has(&NO_JOINT)
}

/// A run of numbered columns, as many as the robot has joints.
fn by_number(seen: &[Seen<'_>], known: &[bool], found: &mut [Option<usize>], all: &mut Proposal) {
    let quantity = |column: &Seen<'_>| column.measure().map(|unit| unit.quantity);
    let of_joints = |k: usize| {
        let column = &seen[k];
        let known = matches!(column.role, Some(Role::Joint(_)));
        let named = match quantity(column) {
            Some(Quantity::Angle) => true,
            Some(Quantity::Length) | None => column.has(&JOINT_WORDS) || column.words.len() == 1,
            _ => false,
        };
        known || (usable(column) && named)
    };
    let mut runs = runs(seen, found.len(), of_joints);
    // A joint that is known keeps its column, and its number.
    let agrees = |run: &Vec<usize>| {
        run.iter().enumerate().all(|(k, column)| match seen[*column].role {
            Some(Role::Joint(joint)) => joint == k,
            _ => !known[k],
        })
    };
    runs.retain(agrees);
    runs.retain(|run| !unit_length(seen, run));
    if runs.len() > 1 {
        let measured: Vec<Vec<usize>> =
            runs.iter().filter(|run| run.iter().all(|&k| seen[k].has(&MEASURED))).cloned().collect();
        if measured.len() == 1 {
            runs = measured;
        }
    }
    match &runs[..] {
        [run] => found.iter_mut().zip(run).for_each(|(slot, k)| *slot = slot.or(Some(*k))),
        [] => {}
        several => {
            let firsts: Vec<String> =
                several.iter().map(|run| format!("`{}` …", seen[run[0]].header)).collect();
            all.notes.push(format!("several runs of columns may be the joints: {}", firsts.join(", ")));
        }
    }
}

/// A mistyped name beside others that are right.
fn nearly(seen: &[Seen<'_>], names: &[&str], found: &mut [Option<usize>]) {
    for k in 0..names.len() {
        if found[k].is_some() || names[k].len() < 3 {
            continue;
        }
        let free = |at: &usize| usable(&seen[*at]) && !found.contains(&Some(*at));
        let name = |at: usize| super::super::spelled_units::split_unit(seen[at].header).0;
        let near = nearest(names[k], (0..seen.len()).filter(free).map(name));
        found[k] = near.and_then(|near| (0..seen.len()).filter(free).find(|&at| name(at) == near));
    }
}
