//! The numbers by which controllers write an orientation.

use std::f64::consts::TAU;
use truepose_kinematics::Pose;
use truepose_kinematics::nalgebra::{Matrix3, Vector3};

/// How three or four numbers are an orientation.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Orientation {
    /// KUKA's A, B, C in degrees: `Rz(A) Ry(B) Rx(C)`.
    Abc,
    /// FANUC's W, P, R and Yaskawa's Rx, Ry, Rz in degrees: `Rz(R) Ry(P) Rx(W)`.
    Wpr,
    /// Stäubli's rx, ry, rz in degrees, about moving axes: `Rx Ry Rz`.
    MovingXyz,
    /// ABB's q1 … q4: a unit quaternion, real part first.
    Quaternion,
    /// Universal Robots' rx, ry, rz in rad: axis times angle.
    RotationVector,
}

impl Orientation {
    /// How many numbers it has.
    pub fn count(self) -> usize {
        if self == Orientation::Quaternion { 4 } else { 3 }
    }

    /// The rotation of these numbers; none when a quaternion is not of length 1 within 0.01 (RAPID's own rounding is far below).
    pub fn read(self, numbers: &[f64]) -> Option<Matrix3<f64>> {
        if numbers.len() != self.count() || !numbers.iter().all(|v| v.is_finite()) {
            return None;
        }
        let degrees = |k: usize| numbers[k].to_radians();
        let fixed = |x: f64, y: f64, z: f64| Pose::from_xyz_rpy([0.0; 3], [x, y, z]).rotation;
        Some(match self {
            Orientation::Abc => fixed(degrees(2), degrees(1), degrees(0)),
            Orientation::Wpr => fixed(degrees(0), degrees(1), degrees(2)),
            // About moving axes x, y, z: the transpose of the rotation about fixed axes by the opposite angles.
            Orientation::MovingXyz => fixed(-degrees(0), -degrees(1), -degrees(2)).transpose(),
            Orientation::Quaternion => {
                let length = numbers.iter().map(|v| v * v).sum::<f64>().sqrt();
                if (length - 1.0).abs() > 0.01 {
                    return None;
                }
                let unit = [0, 1, 2, 3].map(|k| numbers[k] / length);
                Pose::rotation_from_quaternion(unit)
            }
            Orientation::RotationVector => {
                truepose_kinematics::rotation_vector(&Vector3::new(numbers[0], numbers[1], numbers[2]))
            }
        })
    }

    /// The numbers of a rotation: of those that mean the same, the ones nearest to `like`.
    pub fn write(self, rotation: &Matrix3<f64>, like: &[f64]) -> Vec<f64> {
        let rpy = |r: &Matrix3<f64>| Pose::new(*r, Vector3::zeros()).rpy().map(f64::to_degrees);
        match self {
            Orientation::Abc => {
                let [c, b, a] = rpy(rotation);
                vec![a, b, c]
            }
            Orientation::Wpr => rpy(rotation).to_vec(),
            Orientation::MovingXyz => rpy(&rotation.transpose()).map(|angle| -angle).to_vec(),
            Orientation::Quaternion => {
                let found = Pose::new(*rotation, Vector3::zeros()).quaternion();
                let along: f64 = found.iter().zip(like).map(|(a, b)| a * b).sum();
                found.iter().map(|v| if along < 0.0 { -v } else { *v }).collect()
            }
            Orientation::RotationVector => {
                let short = truepose_kinematics::rotation_log(rotation);
                let angle = short.norm();
                let wanted = Vector3::from_iterator(like.iter().copied().chain([0.0; 3]).take(3));
                let axis =
                    if angle > 1e-12 { short / angle } else { wanted.try_normalize(0.0).unwrap_or_default() };
                let turns = [-1.0, 0.0, 1.0].map(|k| axis * (angle + k * TAU));
                let near = |a: &&Vector3<f64>, b: &&Vector3<f64>| {
                    (*a - wanted).norm().total_cmp(&(*b - wanted).norm())
                };
                turns.iter().min_by(near).unwrap_or(&short).iter().copied().collect()
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn written_numbers_read_back_and_stay_near() {
        let cases = [
            (Orientation::Abc, vec![30.0, -20.0, 170.0]),
            (Orientation::Wpr, vec![-179.5, 12.0, 95.0]),
            (Orientation::MovingXyz, vec![10.0, -70.0, 140.0]),
            (Orientation::Quaternion, vec![-0.5, 0.5, -0.5, 0.5]),
            (Orientation::RotationVector, vec![3.0, 0.9, 0.1]),
            (Orientation::RotationVector, vec![0.0, 4.2, 0.0]),
        ];
        for (form, numbers) in cases {
            let rotation = form.read(&numbers).unwrap();
            let again = form.write(&rotation, &numbers);
            for (a, b) in numbers.iter().zip(&again) {
                assert!((a - b).abs() < 1e-9, "{form:?} {numbers:?} {again:?}");
            }
        }
        // About moving axes: the first turn is about the base's x, the second about the y that has moved along.
        let turned = Orientation::MovingXyz.read(&[90.0, 90.0, 0.0]).unwrap() * Vector3::z();
        assert!((turned - Vector3::x()).norm() < 1e-12, "{turned}");
        assert!(Orientation::Quaternion.read(&[0.0; 4]).is_none());
    }
}
