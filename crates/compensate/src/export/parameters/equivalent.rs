//! The numbers of a description with which it is the same robot as another one of the same joints.
//!
//! ```text
//! U_k(x) = G_k⁻¹ S_k G_{k+1}        for k = 0 … n,   G_0 = G_{n+1} = 1
//! ```
//!
//! | symbol | here | shape | unit | |
//! | --- | --- | --- | --- | --- |
//! | x | values of the description | numbers | m, rad | changes from nominal; those that are not kept are zero |
//! | U, S | segments of the description and of the other robot | pose | m | between the motions |
//! | G_k | a screw about joint k's axis; for a slide a turn about it and any shift | pose | m, rad | it commutes with the motion |
//!
//! More numbers than the robot has parameters: a number is kept where, in the order of [`Class`](super::described::Class), its column is independent of
//! the columns before it. Rows of Denavit and Hartenberg thus come back near the ones that were given, whatever the signs of a and d,
//! and between nearly parallel axes d stays and Hayati's β takes the tilt. Newton's method with differences; the solution is exact.

use super::described::Described;
use nalgebra::{DMatrix, DVector, Unit, Vector3};
use truepose_kinematics::{JointKind, Pose, rotation_log, rotation_vector};

/// Steps of differences, in rad and characteristic lengths.
const STEP: f64 = 1e-6;
/// What is left, in rad and characteristic lengths, of a solution.
const SOLVED: f64 = 1e-10;
const ROUNDS: usize = 30;
/// Independent fraction of a column below which it is not kept: that of `AxisTableOptions::parallel`, then less where a robot needs it.
const INDEPENDENT: [f64; 3] = [0.02, 1e-3, 1e-5];
/// Of one class, those that are clearly independent come first: a length across an offset of a few millimetres would take up a change of the distance of
/// two axes thirtyfold, with a false zero of the joint.
const CLEARLY: [f64; 2] = [0.5, 0.1];

/// Solutions, and which numbers are kept.
pub(super) struct Equivalent<'a> {
    pub described: &'a Described<'a>,
    motions: Vec<(JointKind, Unit<Vector3<f64>>)>,
    size: f64,
    /// Numbers that may differ from nominal.
    pub kept: Vec<usize>,
}

/// Values of all numbers, and the screws.
pub(super) struct Solution {
    pub values: Vec<f64>,
    screws: Vec<f64>,
}

impl<'a> Equivalent<'a> {
    /// Of a description, with its solution for a robot of these segments; none where its rows cannot describe that robot.
    pub fn solve(described: &'a Described<'a>, segments: &[Pose]) -> Option<(Self, Solution)> {
        INDEPENDENT.iter().find_map(|&independent| {
            let found = Equivalent::new(described, independent);
            let solution = found.newton(segments)?;
            Some((found, solution))
        })
    }

    fn new(described: &'a Described<'a>, independent: f64) -> Self {
        let size = described.chain.characteristic_length().max(1e-3);
        let mut this = Equivalent { described, motions: described.motions(), size, kept: Vec::new() };
        let nominal =
            Solution { values: vec![0.0; described.numbers.len()], screws: vec![0.0; this.screw_count()] };
        let segments = described.segments(&nominal.values);
        let all: Vec<usize> = (0..described.numbers.len()).collect();
        let columns = this.jacobian(&all, &nominal, &segments);
        let mut order = all;
        order.sort_by_key(|&k| (described.numbers[k].class, k));
        // Screws take part in any case.
        let mut basis: Vec<DVector<f64>> = Vec::new();
        for k in columns.ncols() - nominal.screws.len()..columns.ncols() {
            independent_part(&mut basis, columns.column(k).into_owned(), 1e-9);
        }
        for class in order.chunk_by(|&a, &b| described.numbers[a].class == described.numbers[b].class) {
            for least in CLEARLY.into_iter().filter(|clearly| *clearly > independent).chain([independent]) {
                for &k in class {
                    if !this.kept.contains(&k)
                        && independent_part(&mut basis, columns.column(k).into_owned(), least)
                    {
                        this.kept.push(k);
                    }
                }
            }
        }
        this.kept.sort_unstable();
        this
    }

    fn screw_count(&self) -> usize {
        self.motions.iter().map(|(kind, _)| if *kind == JointKind::Prismatic { 4 } else { 2 }).sum()
    }

    fn screws(&self, values: &[f64]) -> Vec<Pose> {
        let mut next = values.iter();
        let mut take = || next.next().copied().unwrap_or(0.0);
        let one = |(kind, axis): &(JointKind, Unit<Vector3<f64>>)| {
            let turn = rotation_vector(&(axis.into_inner() * take()));
            let shift = match kind {
                JointKind::Prismatic => Vector3::new(take(), take(), take()) * self.size,
                _ => axis.into_inner() * (take() * self.size),
            };
            Pose::new(turn, shift)
        };
        self.motions.iter().map(one).collect()
    }

    /// What is left of every segment, in rad and characteristic lengths.
    fn gaps(&self, solution: &Solution, segments: &[Pose]) -> DVector<f64> {
        let ours = self.described.segments(&solution.values);
        let screws = self.screws(&solution.screws);
        let mut gaps = DVector::zeros(6 * ours.len());
        for (k, (ours, theirs)) in ours.iter().zip(segments).enumerate() {
            let front = k.checked_sub(1).map_or(Pose::IDENTITY, |k| screws[k].inverse());
            let back = screws.get(k).copied().unwrap_or(Pose::IDENTITY);
            let gap = (front * *theirs * back).inverse() * *ours;
            gaps.fixed_rows_mut::<3>(6 * k).copy_from(&(gap.translation / self.size));
            gaps.fixed_rows_mut::<3>(6 * k + 3).copy_from(&rotation_log(&gap.rotation));
        }
        gaps
    }

    fn scale(&self, number: usize) -> f64 {
        if self.described.numbers[number].length { self.size } else { 1.0 }
    }

    /// How the gaps move with these numbers, in their scale, and with the screws behind them.
    fn jacobian(&self, numbers: &[usize], at: &Solution, segments: &[Pose]) -> DMatrix<f64> {
        let rows = 6 * segments.len();
        let mut columns = DMatrix::zeros(rows, numbers.len() + at.screws.len());
        for (column, &number) in numbers.iter().enumerate() {
            let moved = |by: f64| {
                let mut values = at.values.clone();
                values[number] += by * self.scale(number);
                self.gaps(&Solution { values, screws: at.screws.clone() }, segments)
            };
            columns.set_column(column, &((moved(STEP) - moved(-STEP)) / (2.0 * STEP)));
        }
        for k in 0..at.screws.len() {
            let moved = |by: f64| {
                let mut screws = at.screws.clone();
                screws[k] += by;
                self.gaps(&Solution { values: at.values.clone(), screws }, segments)
            };
            columns.set_column(numbers.len() + k, &((moved(STEP) - moved(-STEP)) / (2.0 * STEP)));
        }
        columns
    }

    fn newton(&self, segments: &[Pose]) -> Option<Solution> {
        let mut at = Solution {
            values: vec![0.0; self.described.numbers.len()],
            screws: vec![0.0; self.screw_count()],
        };
        for _ in 0..ROUNDS {
            let gaps = self.gaps(&at, segments);
            if gaps.amax() < SOLVED * 1e-2 {
                break;
            }
            let step = solve(self.jacobian(&self.kept, &at, segments), &-gaps)?;
            for (k, &number) in self.kept.iter().enumerate() {
                at.values[number] += step[k] * self.scale(number);
            }
            for (k, screw) in at.screws.iter_mut().enumerate() {
                *screw += step[self.kept.len() + k];
            }
        }
        (self.gaps(&at, segments).amax() < SOLVED).then_some(at)
    }

    /// How the kept numbers move (m, rad) when the segments move like this: a column for each direction, `2 · step` apart.
    pub fn derivative(
        &self,
        at: &Solution,
        segments: &[Pose],
        ways: &[[Vec<Pose>; 2]],
        step: f64,
    ) -> Option<DMatrix<f64>> {
        let jacobian = self.jacobian(&self.kept, at, segments);
        let mut derivative = DMatrix::zeros(self.kept.len(), ways.len());
        for (way, [forward, back]) in ways.iter().enumerate() {
            let pull = (self.gaps(at, forward) - self.gaps(at, back)) / (2.0 * step);
            let moved = solve(jacobian.clone(), &-pull)?;
            for (k, &number) in self.kept.iter().enumerate() {
                derivative[(k, way)] = moved[k] * self.scale(number);
            }
        }
        Some(derivative)
    }
}

/// Least squares by singular values.
fn solve(a: DMatrix<f64>, b: &DVector<f64>) -> Option<DVector<f64>> {
    if a.is_empty() {
        return Some(DVector::zeros(a.ncols()));
    }
    let svd = a.svd(true, true);
    let largest = svd.singular_values.iter().copied().fold(0.0, f64::max);
    svd.solve(b, 1e-9 * largest).ok().filter(|x| x.iter().all(|v| v.is_finite()))
}

/// Adds the part of a column that is independent of a basis (orthonormal) to it, if it is more than this fraction.
fn independent_part(basis: &mut Vec<DVector<f64>>, mut column: DVector<f64>, fraction: f64) -> bool {
    let whole = column.norm();
    for _ in 0..2 {
        for unit in basis.iter() {
            let along = unit.dot(&column);
            column.axpy(-along, unit, 1.0);
        }
    }
    let left = column.norm();
    if left <= fraction * whole || whole <= 0.0 {
        return false;
    }
    basis.push(column / left);
    true
}
