//! Twenty changes of the files that change nothing of the robot.

use super::case::Case;
use super::rigid::{gravity, moved, si, turned};
use rand::seq::SliceRandom;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use truepose_kinematics::nalgebra::{Isometry3, Rotation3, Translation3, Unit, Vector3};

/// A change of the files, and what it allows.
pub struct Relation {
    pub name: &'static str,
    pub change: fn(&mut Case),
    /// All lengths, and so all position errors, are so many times as large.
    pub lengths: f64,
    /// Relative change of a held-out RMS that it allows. Cells that are written anew are rounded; a search amplifies that in the refits.
    pub tolerance: f64,
    /// Whether outliers may be reported beside the findings.
    pub spoils: bool,
    /// Whether coefficients keep their values, to half an interval. Beside outliers only those of a finding with as many coefficients are compared.
    pub same_coefficients: bool,
}

const fn same(name: &'static str, change: fn(&mut Case)) -> Relation {
    Relation { name, change, lengths: 1.0, tolerance: 0.01, spoils: false, same_coefficients: true }
}

/// Coefficients are those along other axes, or in other sizes.
const fn moving(name: &'static str, change: fn(&mut Case)) -> Relation {
    Relation { same_coefficients: false, ..rounded(name, change) }
}

const fn rounded(name: &'static str, change: fn(&mut Case)) -> Relation {
    Relation { tolerance: 0.05, ..same(name, change) }
}

pub const RELATIONS: [Relation; 20] = [
    rounded("rows permuted", permuted),
    rounded("every pose copied as a new one", copied),
    Relation { lengths: 1e-3, ..moving("lengths x 0.001", |case| scaled(case, -3)) },
    Relation { lengths: 1e3, ..moving("lengths x 1000", |case| scaled(case, 3)) },
    rounded("other units", other_units),
    rounded("degrees and radians", radians),
    same("joints renamed", joints_renamed),
    moving("base moved", base_moved),
    moving("measurement frame turned", frame_turned),
    rounded("irrelevant channel", irrelevant_channel),
    rounded("equal channel twice", equal_channel),
    same("constant channel", |case| case.add("setpoint", Some("%"), |_| "45.0".into())),
    rounded("flicker of the joints", flicker),
    // A pose that is held out is predicted as badly as it is; the figures without outliers are compared.
    Relation { tolerance: 0.15, spoils: true, ..same("one bad pose", bad_pose) },
    same("columns in another order", |case| {
        case.columns.reverse();
        case.rows.iter_mut().for_each(|row| row.reverse());
    }),
    same("one session", |case| case.add("session", None, |_| "hall 1".into())),
    same("ids", |case| case.add("id", None, |k| format!("M-{:04}", k + 1))),
    same("targets renamed", targets_renamed),
    same("another dialect", |case| case.spreadsheet = true),
    same("three threads", |case| case.threads = 3),
];

fn permuted(case: &mut Case) {
    case.rows.shuffle(&mut ChaCha8Rng::seed_from_u64(5));
}

/// At the end of the file, under new numbers.
fn copied(case: &mut Case) {
    let visit = case.column("visit").unwrap();
    let after = 1 + case.numbers(visit).into_iter().fold(0.0, f64::max) as i64;
    let mut copies = case.rows.clone();
    copies.iter_mut().for_each(|row| row[visit] = (row[visit].parse::<i64>().unwrap() + after).to_string());
    case.rows.extend(copies);
}

/// A decimal shift of a number as it is written: no digit changes.
fn shifted(cell: &str, by: i32) -> String {
    match cell.split_once('e') {
        Some((digits, exponent)) => format!("{digits}e{}", exponent.parse::<i32>().unwrap() + by),
        None => format!("{cell}e{by}"),
    }
}

fn shift(value: f64, by: i32) -> f64 {
    shifted(&format!("{value:?}"), by).parse().unwrap()
}

fn is_length(unit: Option<&str>) -> bool {
    matches!(unit, Some("m" | "mm" | "um" | "in"))
}

fn scaled(case: &mut Case, by: i32) {
    case.lengths(&|v| shift(v, by));
    for k in 0..case.columns.len() {
        if is_length(case.columns[k].1.as_deref()) {
            case.cells(k, |cell| shifted(cell, by));
        }
    }
}

/// Lengths in m, masses in the other unit, time in minutes, temperatures in K.
fn other_units(case: &mut Case) {
    /// kg.
    const POUND: f64 = 0.45359237;
    for k in 0..case.columns.len() {
        let number = |cell: &str| cell.parse::<f64>().unwrap();
        let unit = match case.columns[k].1.as_deref() {
            Some("mm") => {
                case.cells(k, |cell| shifted(cell, -3));
                "m"
            }
            Some("kg") => {
                case.cells(k, |cell| format!("{:?}", number(cell) / POUND));
                "lb"
            }
            Some("lb") => {
                case.cells(k, |cell| format!("{:?}", number(cell) * POUND));
                "kg"
            }
            Some("s") => {
                case.cells(k, |cell| format!("{:?}", number(cell) / 60.0));
                "min"
            }
            Some("degC") => {
                case.cells(k, |cell| format!("{:.4}", number(cell) + 273.15));
                "K"
            }
            _ => continue,
        };
        case.columns[k].1 = Some(unit.into());
    }
    if case.unit("length") == "mm" {
        case.lengths(&|v| shift(v, -3));
        case.set_unit("length", "m");
    }
}

fn other_angle(unit: &str) -> (&'static str, f64) {
    let to = if unit == "deg" { "rad" } else { "deg" };
    (to, si(unit) / si(to))
}

fn radians(case: &mut Case) {
    for name in case.joints(false) {
        let k = case.column(&name).unwrap();
        let (unit, factor) = other_angle(&case.columns[k].1.clone().unwrap());
        case.cells(k, |cell| format!("{:?}", cell.parse::<f64>().unwrap() * factor));
        case.columns[k].1 = Some(unit.into());
    }
    let (unit, factor) = other_angle(&case.unit("angle"));
    case.angles(&|v| v * factor);
    case.set_unit("angle", unit);
}

/// New names of a list of the robot file, in the opposite order of the alphabet.
fn renamed(case: &mut Case, list: &str, word: &str) -> Vec<(String, String)> {
    let Some(all) = case.robot.get_mut(list).and_then(|list| list.as_array_mut()) else { return Vec::new() };
    let new = |k: usize| format!("{word}{}", char::from(b'z' - k as u8));
    let names: Vec<(String, String)> = all
        .iter_mut()
        .enumerate()
        .map(|(k, part)| {
            let part = part.as_table_mut().unwrap();
            let old = part.insert("name".into(), new(k).into()).unwrap();
            (old.as_str().unwrap().to_owned(), new(k))
        })
        .collect();
    case.names.extend(names.iter().map(|(old, new)| (new.clone(), old.clone())));
    names
}

fn joints_renamed(case: &mut Case) {
    for (old, new) in renamed(case, "joints", "axis_") {
        for (name, _) in &mut case.columns {
            if *name == old {
                name.clone_from(&new);
            } else if name.strip_prefix("approach_") == Some(&old) {
                *name = format!("approach_{new}");
            }
        }
        // Joints are named nowhere else in a model but as texts.
        let model =
            toml::to_string(&case.model).unwrap().replace(&format!("\"{old}\""), &format!("\"{new}\""));
        case.model = model.parse().unwrap();
    }
}

fn targets_renamed(case: &mut Case) {
    let names = renamed(case, "targets", "prism_");
    if let Some(k) = case.column("target") {
        let new =
            |cell: &str| names.iter().find(|(old, _)| old == cell).map_or(cell, |(_, new)| new).to_owned();
        case.cells(k, new);
    }
}

/// By metres, and about the vertical.
fn base_moved(case: &mut Case) {
    let about = Rotation3::from_axis_angle(&Unit::new_normalize(gravity(case)), 0.7);
    moved(case, &Isometry3::from_parts(Translation3::new(3.0, -2.0, 1.0), about.into()));
}

fn frame_turned(case: &mut Case) {
    turned(case, &Rotation3::new(Vector3::new(0.4, 0.8, -0.6)));
}

fn irrelevant_channel(case: &mut Case) {
    let mut random = ChaCha8Rng::seed_from_u64(11);
    case.add("batch_size", None, |_| format!("{:.2}", 1013.0 + random.random_range(-9.0..9.0)));
}

fn equal_channel(case: &mut Case) {
    let own = |(_, unit): &(String, Option<String>)| matches!(unit.as_deref(), Some("degC" | "%"));
    let k = case.columns.iter().position(own).unwrap_or_else(|| {
        irrelevant_channel(case);
        case.columns.len() - 1
    });
    let ((name, unit), cells) = (case.columns[k].clone(), case.rows.clone());
    case.add(&format!("{name}_logged"), unit.as_deref(), |row| cells[row][k].clone());
}

/// Up to 2e-5° on either side, in each row.
fn flicker(case: &mut Case) {
    let random = std::cell::RefCell::new(ChaCha8Rng::seed_from_u64(3));
    for name in case.joints(false) {
        let k = case.column(&name).unwrap();
        let most = si("deg") * 2e-5 / si(case.columns[k].1.as_deref().unwrap());
        let by = || random.borrow_mut().random_range(-most..most);
        case.cells(k, |cell| format!("{:.10}", cell.parse::<f64>().unwrap() + by()));
    }
}

/// All rows of one dwell are displaced by 11 mm.
fn bad_pose(case: &mut Case) {
    let visit = case.column("visit").unwrap();
    let which = case.rows[case.rows.len() / 2][visit].clone();
    for (axis, by) in [("x", 8.0), ("y", -5.0), ("z", 6.0)] {
        let k = case.column(axis).unwrap();
        let by = 1e-3 * by / si(case.columns[k].1.as_deref().unwrap());
        for row in case.rows.iter_mut().filter(|row| row[visit] == which) {
            row[k] = format!("{:.6}", row[k].parse::<f64>().unwrap() + by);
        }
    }
}
