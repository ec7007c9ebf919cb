//! What goes wrong with the record: what a robot's user gets wrong, or his controller.

use crate::prelude::*;
use truepose_errormodel::{approach_from_order, visits_from_rows};

/// Kinds of spoiling.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
#[value(rename_all = "snake_case")]
pub enum Spoil {
    Nothing,
    /// Encoders flicker by 1e-5 to 1e-4 degrees (micrometres), and the file has no column `visit`.
    Flicker,
    /// One to three rows are 5 to 50 mm off.
    WrongRows,
    /// One to three rows contain (0, 0, 0).
    Zeros,
    /// All targets of one pose are off by the same 5 to 50 mm.
    PoseOff,
    /// Two targets' labels are swapped at two to five poses.
    Swapped,
    /// One pose lies far from all others.
    Leverage,
    /// A target that was declared unknown has two or three rows.
    FewRows,
    /// Flicker and a wrong row.
    FlickerWrong,
}

/// In turn: three in eleven are as they should be.
pub const SPOILS: [Spoil; 11] = {
    use Spoil::*;
    [Nothing, WrongRows, Flicker, Leverage, Nothing, Swapped, Zeros, PoseOff, Nothing, FewRows, FlickerWrong]
};

impl Spoil {
    /// How many targets it takes.
    pub fn targets(self) -> usize {
        if matches!(self, Spoil::Swapped | Spoil::FewRows) { 2 } else { 0 }
    }

    /// Whether there is a record without it of the same poses and targets.
    pub fn has_clean(self) -> bool {
        !matches!(self, Spoil::Nothing | Spoil::Leverage | Spoil::FewRows)
    }

    /// The changed record. Directions of approach are derived from the order, as of a file that does not state them.
    pub fn spoiled(self, data: &Dataset, draw: &mut Draw) -> Dataset {
        let mut data = match self {
            Spoil::FewRows => few_rows(data, draw),
            _ => data.clone(),
        };
        let visits = Visits::of(&data).rows;
        match self {
            Spoil::WrongRows | Spoil::FlickerWrong => {
                let count = 1 + draw.below(3);
                for row in draw.some(count, data.len()) {
                    let off = draw.direction() * draw.logarithmic(5e-3, 0.05);
                    moved(&mut data, row, &off);
                }
            }
            Spoil::Zeros => {
                let count = 1 + draw.below(3);
                for row in draw.some(count, data.len()) {
                    data.position[row] = [0.0; 3];
                }
            }
            Spoil::PoseOff => {
                let off = draw.direction() * draw.logarithmic(5e-3, 0.05);
                for &row in &visits[draw.below(visits.len())] {
                    moved(&mut data, row, &off);
                }
            }
            Spoil::Swapped => swapped(&mut data, &visits, draw),
            Spoil::Nothing | Spoil::Flicker | Spoil::Leverage | Spoil::FewRows => {}
        }
        if matches!(self, Spoil::Flicker | Spoil::FlickerWrong) {
            let size = draw.logarithmic(1e-5, 1e-4).to_radians();
            for value in data.joints.iter_mut().flatten() {
                *value += size * draw.normal();
            }
            data.visit = visits_from_rows(&data);
        }
        data.approach = approach_from_order(&data);
        data
    }
}

fn moved(data: &mut Dataset, row: usize, off: &Vector3<f64>) {
    for (value, off) in data.position[row].iter_mut().zip(off.iter()) {
        *value += off;
    }
}

/// All but two or three rows of the last target are missing.
fn few_rows(data: &Dataset, draw: &mut Draw) -> Dataset {
    let last = data.target.iter().flatten().map(|target| target.0).max();
    let of_last: Vec<usize> =
        (0..data.len()).filter(|&row| data.target[row].map(|target| target.0) == last).collect();
    let count = 2 + draw.below(2);
    let keep: Vec<usize> = draw.some(count, of_last.len()).into_iter().map(|k| of_last[k]).collect();
    let rows: Vec<usize> =
        (0..data.len()).filter(|row| !of_last.contains(row) || keep.contains(row)).collect();
    data.select(&rows)
}

/// Labels of the first two targets that a visit has, at some visits that have two.
fn swapped(data: &mut Dataset, visits: &[Vec<usize>], draw: &mut Draw) {
    let two: Vec<&Vec<usize>> = visits.iter().filter(|rows| rows.len() >= 2).collect();
    let count = 2 + draw.below(4);
    for k in draw.some(count, two.len()) {
        let (a, b) = (two[k][0], two[k][1]);
        let labels: [Option<TargetId>; 2] = [data.target[a], data.target[b]];
        (data.target[a], data.target[b]) = (labels[1], labels[0]);
    }
}

#[cfg(test)]
mod tests {
    use super::super::robots::{Robot, Stream};
    use super::*;

    /// A record with three targets a pose.
    fn record() -> Dataset {
        let of_three = |number: &u64| {
            let robot = Robot::of(*number).expect("a robot");
            robot.spoil == Spoil::Nothing && Visits::of(&robot.data).rows.iter().all(|rows| rows.len() >= 2)
        };
        let number = (0..200).find(of_three).expect("one of them");
        Robot::of(number).expect("a robot").data
    }

    #[test]
    fn each_kind_spoils_what_it_says() {
        let clean = record();
        let spoiled = |spoil: Spoil| spoil.spoiled(&clean, &mut Stream::Spoil.draw(2));
        let moved = |data: &Dataset| {
            (0..data.len()).filter(|&row| data.measured_position(row) != clean.measured_position(row)).count()
        };
        assert!((1..=3).contains(&moved(&spoiled(Spoil::WrongRows))));
        assert!((1..=3).contains(&moved(&spoiled(Spoil::Zeros))));
        assert!(moved(&spoiled(Spoil::PoseOff)) >= 2);
        assert_eq!(moved(&spoiled(Spoil::Nothing)), 0);
        let labels = spoiled(Spoil::Swapped).target;
        let changed = labels.iter().zip(&clean.target).filter(|(a, b)| a != b).count();
        assert!((4..=10).contains(&changed) && changed % 2 == 0, "{changed}");
        let few = spoiled(Spoil::FewRows);
        let last = few.target.iter().flatten().map(|t| t.0).max();
        let rows = few.target.iter().filter(|t| t.map(|t| t.0) == last).count();
        assert!((2..=3).contains(&rows));
    }

    #[test]
    fn flicker_is_what_an_encoder_shows() {
        let clean = record();
        let data = Spoil::Flicker.spoiled(&clean, &mut Stream::Spoil.draw(2));
        let off = data.joints[0].iter().zip(&clean.joints[0]).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        // Five deviations of a ten-thousandth of a degree.
        assert!(off > 1e-8 && off < 5e-4f64.to_radians(), "{off}");
    }
}
