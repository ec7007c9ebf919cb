//! How well measured orientations agree with the robot, whatever its base and tool.
//!
//! With `R = B F(q) T` and unknown rotations B and T, the angles of `RᵢᵀRⱼ` and of `RᵢᵀRⱼRₖᵀRₗ` are those of the same products of F: T turns the
//! axes alone. The second kind tells orders of a quaternion apart, which the first does not.

use super::super::orientation::OrientationConvention;
use super::seen::Seen;
use crate::Unit;
use truepose_kinematics::nalgebra::{Matrix3, Rotation3, Vector3};
use truepose_kinematics::{Chain, Pose};

/// Rows that are held against each other, and the fewest that show something.
const MOST: usize = 60;
const FEWEST: usize = 6;

/// How numbers describe an orientation.
#[derive(Debug, Clone, Copy)]
pub(super) enum Turns {
    /// w, x, y, z.
    Quaternion,
    Vector,
    Angles(OrientationConvention),
}

/// Rotations of the nominal robot in the first rows.
pub(super) struct Measured {
    rows: Vec<usize>,
    nominal: Vec<Matrix3<f64>>,
}

impl Measured {
    /// From the columns of all joints; none where there are too few rows, or the tool changes.
    pub fn of(seen: &[Seen<'_>], chain: &Chain, joints: &[(usize, Unit)]) -> Option<Measured> {
        if chain.tools().len() > 1 {
            return None;
        }
        let values: Option<Vec<Vec<f64>>> = joints
            .iter()
            .map(|(k, unit)| Some(seen[*k].numbers()?.iter().map(|value| unit.to_si(*value)).collect()))
            .collect();
        let values = values?;
        let count = values.iter().map(Vec::len).min()?;
        let row = |row: usize| -> Vec<f64> {
            let mut joints: Vec<f64> = values.iter().map(|column| column[row]).collect();
            if !chain.couplings().is_empty() {
                chain.joints_from_controller(&mut joints);
            }
            joints
        };
        let rows: Vec<usize> =
            (0..count).filter(|&k| row(k).iter().all(|value| value.is_finite())).take(MOST).collect();
        let nominal = rows.iter().map(|&k| chain.forward(&row(k)).rotation).collect();
        (rows.len() >= FEWEST).then_some(Measured { rows, nominal })
    }

    /// RMS by which angles between the measured orientations are not those of the robot, rad.
    pub fn misfit(
        &self,
        seen: &[Seen<'_>],
        columns: &[usize],
        turns: Turns,
        unit: Option<&Unit>,
    ) -> Option<f64> {
        let of_angle =
            |k: usize, value: f64| seen[k].measure().or(unit).map_or(value, |unit| unit.to_si(value));
        let values: Option<Vec<Vec<f64>>> = columns.iter().map(|&k| seen[k].numbers()).collect();
        let values = values?;
        let (mut measured, mut nominal) = (Vec::new(), Vec::new());
        for (&row, known) in self.rows.iter().zip(&self.nominal) {
            let raw = |k: usize| values[k].get(row).copied().unwrap_or(f64::NAN);
            let angle = |k: usize| of_angle(columns[k], raw(k));
            let rotation = match turns {
                Turns::Quaternion => Pose::rotation_from_quaternion([raw(0), raw(1), raw(2), raw(3)]),
                Turns::Vector => Rotation3::new(Vector3::new(angle(0), angle(1), angle(2))).into_inner(),
                Turns::Angles(convention) => convention.rotation([angle(0), angle(1), angle(2)])?,
            };
            if rotation.iter().all(|value| value.is_finite()) {
                measured.push(rotation);
                nominal.push(*known);
            }
        }
        if measured.len() < FEWEST {
            return None;
        }
        let (of_measured, of_nominal) = (invariants(&measured), invariants(&nominal));
        let squares: f64 = of_measured.iter().zip(&of_nominal).map(|(a, b)| (a - b).powi(2)).sum();
        Some((squares / of_measured.len() as f64).sqrt())
    }
}

/// Angles of products of neighbouring rotations, rad.
fn invariants(all: &[Matrix3<f64>]) -> Vec<f64> {
    let angle = |m: Matrix3<f64>| Rotation3::from_matrix_unchecked(m).angle();
    let pairs = all.windows(2).map(|pair| angle(pair[0].transpose() * pair[1]));
    let fours =
        all.windows(4).map(|four| angle(four[0].transpose() * four[1] * four[2].transpose() * four[3]));
    pairs.chain(fours).collect()
}
