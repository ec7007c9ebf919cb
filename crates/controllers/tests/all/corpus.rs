//! 200 programs of every language and their mutations: what is no point stays byte for byte, what is read is what was written.

use crate::programs::{Draw, mutated, program};
use std::ops::Range;
use truepose_controllers::{Dialect, Point, Program, Replacement, Value};
use truepose_kinematics::Pose;
use truepose_kinematics::nalgebra::Vector3;

/// Programs of each language.
const PROGRAMS: u64 = 200;

/// Mutations of each language in the suite.
const MUTATIONS: u64 = 10_000;

/// Another pose or other joints near those of a point, in the program's numbers.
fn moved(point: &Point, dialect: Dialect, draw: &mut Draw) -> Replacement {
    let turns = Vec::new();
    match &point.value {
        Value::Joints(values) => {
            let scale = if dialect == Dialect::Inform { 1000.0 } else { 0.5 };
            let numbers = values.iter().map(|v| v + scale * draw.within(-1.0, 1.0)).collect();
            Replacement { numbers, turns }
        }
        Value::Pose { pose, .. } => {
            let by = Pose::from_xyz_rpy(
                [0; 3].map(|_| draw.within(-3e-3, 3e-3)),
                [0; 3].map(|_| draw.within(-2e-3, 2e-3)),
            );
            let new = Pose::new(pose.rotation * by.rotation, pose.translation + by.translation);
            let like = dialect.orientation().write(&pose.rotation, &[0.0; 4]);
            Replacement { numbers: point.numbers_of(&new, dialect, &like), turns }
        }
    }
}

/// Every point that may be changed, changed.
fn changed(read: &Program, draw: &mut Draw) -> Vec<Option<Replacement>> {
    read.points()
        .iter()
        .map(|point| point.fixed.is_none().then(|| moved(point, read.dialect(), draw)))
        // Numbers above are not read.
        .map(|new| new.filter(|new| new.numbers.iter().all(|value| value.abs() < 1e9)))
        .collect()
}

/// The text without these ranges and without the blanks in front of them.
fn without(text: &[u8], ranges: &[Range<usize>]) -> Vec<u8> {
    let mut ranges = ranges.to_vec();
    ranges.sort_by_key(|range| range.start);
    let mut left = Vec::new();
    let mut from = 0;
    for range in ranges {
        let piece = &text[from..range.start];
        let blanks = piece.iter().rev().take_while(|&&byte| byte == b' ').count();
        left.extend_from_slice(&piece[..piece.len() - blanks]);
        left.push(b'~');
        from = range.end;
    }
    left.extend_from_slice(&text[from..]);
    left
}

fn ranges(read: &Program) -> Vec<Range<usize>> {
    read.points().iter().flat_map(Point::ranges).collect()
}

/// Whether the pose or joints of a point are these numbers, to the rounding of what is written.
fn reads_as(point: &Point, numbers: &[f64], dialect: Dialect) -> bool {
    // Pulses are whole, millimetres have three decimals or more; the numbers' own size limits their digits.
    let tolerance = match dialect {
        Dialect::Inform => 0.5,
        Dialect::Fanuc => 5e-4,
        _ => 2e-5,
    };
    let near = |a: f64, b: f64| (a - b).abs() <= tolerance + 1e-12 * a.abs();
    match &point.value {
        Value::Joints(values) => values.iter().zip(numbers).all(|(a, b)| near(*a, *b)),
        Value::Pose { pose, .. } => {
            let turn = dialect.orientation().read(&numbers[3..]).unwrap();
            let place = Vector3::new(numbers[0], numbers[1], numbers[2]) * dialect.length();
            let off = (pose.translation - place).norm();
            off < 1e-6 + 1e-12 * place.norm()
                && (pose.rotation - turn).norm() < if dialect == Dialect::Fanuc { 4e-5 } else { 1e-5 }
        }
    }
}

/// Rewrites all points of a program that was read, reads it again, and holds the two against each other.
#[track_caller]
fn check(text: &[u8], read: &Program, draw: &mut Draw) {
    let dialect = read.dialect();
    assert_eq!(read.rewritten(&vec![None; read.points().len()]).unwrap(), text, "nothing is changed");
    let new = changed(read, draw);
    let out = read.rewritten(&new).unwrap();
    let again = Program::read(&out, &[], dialect).expect("the rewritten program is read");
    assert_eq!(read.points().len(), again.points().len(), "points");
    if dialect != Dialect::Val3 {
        // Attributes that were absent are added there.
        assert_eq!(
            String::from_utf8_lossy(&without(text, &ranges(read))),
            String::from_utf8_lossy(&without(&out, &ranges(&again)))
        );
    }
    for ((old, point), new) in read.points().iter().zip(again.points()).zip(&new) {
        assert_eq!((&old.name, old.line), (&point.name, point.line));
        if let Some(new) = new {
            assert!(
                reads_as(point, &new.numbers, dialect),
                "{} in line {}: {new:?} {point:?}",
                point.name,
                point.line
            );
        }
    }
}

#[test]
fn programs_are_read_whole_and_come_back_byte_for_byte() {
    for dialect in Dialect::ALL {
        for seed in 0..PROGRAMS {
            let mut draw = Draw::new(seed);
            let points = 1 + draw.below(30);
            let written = program(dialect, points, &mut draw);
            let read = Program::read(&written.text, &[], dialect).expect("a program");
            let which = format!("{dialect:?} {seed}\n{}", String::from_utf8_lossy(&written.text));
            assert_eq!(read.points().len(), written.points, "{which}");
            assert!(read.points().iter().all(|point| point.fixed.is_none()), "{which} {:?}", read.points());
            // Turn numbers of configurations are not among those that the generator lists.
            let found = ranges(&read);
            let is = |number: &Range<usize>| {
                found.iter().any(|range| range.end == number.end && range.start <= number.start)
            };
            assert!(written.numbers.iter().all(is), "{which}");
            check(&written.text, &read, &mut draw);
        }
    }
}

fn fuzz(dialect: Dialect, count: u64) -> (u64, u64) {
    let (mut refused, mut points) = (0, 0);
    for seed in 0..count {
        let mut draw = Draw::new(seed.wrapping_mul(7919) + 13);
        let size = 1 + draw.below(4);
        let text = mutated(&program(dialect, size, &mut draw).text, &mut draw);
        match Program::read(&text, &[], dialect) {
            Err(_) => refused += 1,
            Ok(read) => {
                points += read.points().len() as u64;
                outside_of_comments(&text, &read);
                check(&text, &read, &mut draw);
            }
        }
    }
    (refused, points)
}

/// No number of a point stands behind the sign of a comment, outside of quotes.
#[track_caller]
fn outside_of_comments(text: &[u8], read: &Program) {
    let (sign, quotes): (u8, &[u8]) = match read.dialect() {
        Dialect::Krl => (b';', b"\"'"),
        Dialect::Rapid => (b'!', b"\""),
        Dialect::UrScript => (b'#', b"\"'"),
        _ => return,
    };
    for range in ranges(read) {
        let line =
            text[..range.start].iter().rposition(|byte| matches!(byte, b'\n' | b'\r')).map_or(0, |k| k + 1);
        let mut quote = None;
        for &byte in &text[line..range.start] {
            match quote {
                Some(open) if byte == open => quote = None,
                None if quotes.contains(&byte) => quote = Some(byte),
                None => assert!(byte != sign, "a number in a comment"),
                _ => {}
            }
        }
        assert!(quote.is_none() || text[range.start] == b'\'', "a number in a text");
    }
}

#[test]
fn mutated_programs_are_refused_or_right() {
    let count =
        std::env::var("TRUEPOSE_MUTATIONS").ok().and_then(|count| count.parse().ok()).unwrap_or(MUTATIONS);
    for dialect in Dialect::ALL {
        let (refused, points) = fuzz(dialect, count);
        assert!(
            refused < count && points > count / 4,
            "{dialect:?}: {refused} of {count} refused, {points} points"
        );
        if count > MUTATIONS {
            eprintln!("{dialect:?}: {count} programs, {refused} refused, {points} points in the others");
        }
    }
}
