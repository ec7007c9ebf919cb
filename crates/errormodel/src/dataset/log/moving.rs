//! Whether rows were measured while the robot moved.

use super::streams::median_step;
use crate::Dataset;

/// What is known of the motion in the rows of a table.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Moving {
    /// Rows that were measured on the way.
    pub rows: usize,
    /// Median speed of the fastest joint in them, rad/s or m/s, and its number; none where the data has no time.
    pub speed: Option<(f64, usize)>,
    /// Rows per second; none where the data has no time.
    pub rate: Option<f64>,
}

/// With a time: rows nearer to each other than this, s, leave no time to move and to stand still.
const NEAR: f64 = 0.6;
/// With a time: over how long a speed is taken, s, and from which speed on a joint moves, rad/s or m/s: a joint at rest flickers by less.
const OVER: f64 = 0.1;
const SLOW: f64 = 5e-3;
/// Without a time: the largest step of a fine path, as a part of the joint's range.
const FINE: f64 = 0.01;
/// Without a time: the cosine between successive steps from which on they are one motion.
const ALONG: f64 = 0.9;
/// Fewest rows on the way, and their smallest part of all rows.
const FEWEST: usize = 100;
const PART: f64 = 0.2;

impl Moving {
    /// Of rows in the order in which they were measured; none where the robot stood still for its rows, as far as they show.
    pub fn of(data: &Dataset) -> Option<Moving> {
        let (rows, speed, rate) = match data.schema.time {
            true => {
                let interval = median_step(&data.time);
                if !(interval > 0.0 && interval < NEAR) {
                    return None;
                }
                let moves = on_the_way(data);
                (moves.len(), fastest(data, &moves), Some(1.0 / interval))
            }
            false => (along_a_path(data), None, None),
        };
        (rows >= FEWEST && rows as f64 > PART * data.len() as f64).then_some(Moving { rows, speed, rate })
    }
}

/// Rows in which a joint moves, each with a later one over which its speed is taken.
fn on_the_way(data: &Dataset) -> Vec<[usize; 2]> {
    let mut later = 0;
    let mut found = Vec::new();
    for row in 0..data.len() {
        later = later.max(row + 1);
        while later + 1 < data.len() && data.time[later] - data.time[row] < OVER {
            later += 1;
        }
        if later < data.len() {
            let time = data.time[later] - data.time[row];
            let moves = |column: &Vec<f64>| (column[later] - column[row]).abs() > SLOW * time;
            if time > 0.0 && time < NEAR && data.joints.iter().any(moves) {
                found.push([row, later]);
            }
        }
    }
    found
}

/// The median speed of the joint that is the fastest on the way, and its number.
fn fastest(data: &Dataset, rows: &[[usize; 2]]) -> Option<(f64, usize)> {
    let of = |column: &Vec<f64>| {
        let speed = |&[a, b]: &[usize; 2]| (column[b] - column[a]).abs() / (data.time[b] - data.time[a]);
        let mut speeds: Vec<f64> = rows.iter().map(speed).collect();
        let middle = speeds.len() / 2;
        if speeds.is_empty() { 0.0 } else { *speeds.select_nth_unstable_by(middle, f64::total_cmp).1 }
    };
    let each = data.joints.iter().map(of).zip(0..);
    each.max_by(|a, b| a.0.total_cmp(&b.0)).filter(|fastest| fastest.0 > 0.0)
}

/// Rows that go on in the direction of the row before by a small step.
fn along_a_path(data: &Dataset) -> usize {
    let ranges: Vec<f64> = data.joints.iter().map(|column| range(column)).collect();
    let step = |row: usize| -> Vec<f64> {
        let one = |(k, column): (usize, &Vec<f64>)| {
            let change = column[row] - column[row - 1];
            let moves = change.abs() > data.dwell.tolerance(k) && ranges[k] > 0.0;
            if moves { change / ranges[k] } else { 0.0 }
        };
        data.joints.iter().enumerate().map(one).collect()
    };
    let product = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    let (mut along, mut before) = (0, vec![0.0; data.joints.len()]);
    for row in 1..data.len() {
        let here = step(row);
        let (size, last) = (product(&here, &here).sqrt(), product(&before, &before).sqrt());
        let fine = size > 0.0 && size < FINE;
        along += usize::from(fine && last > 0.0 && product(&here, &before) > ALONG * size * last);
        before = here;
    }
    along
}

fn range(column: &[f64]) -> f64 {
    let ends =
        column.iter().fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], &v| [low.min(v), high.max(v)]);
    if ends[1] > ends[0] { ends[1] - ends[0] } else { 0.0 }
}
