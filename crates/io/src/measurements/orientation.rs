//! Orientations as controllers and instruments write them.
//!
//! ```text
//! rpy, wpr   R = Rz(c) Ry(b) Rx(a)     angles a, b, c about the fixed axes x, y, z   (URDF; FANUC; SpatialAnalyzer: fixed XYZ)
//! abc        R = Rz(a) Ry(b) Rx(c)     KUKA: A about z, B about y, C about x
//! xyz        R = Rx(a) Ry(b) Rz(c)     about moving axes (Stäubli, Mecademic)
//! zyz        R = Rz(a) Ry(b) Rz(c)     about moving axes (Kawasaki: O, A, T)
//! q1q2q3q4   (w, x, y, z)              ABB
//! ```

use truepose_kinematics::nalgebra::{Matrix3, Vector3};
use truepose_kinematics::{Pose, rotation_log};

/// How angles describe an orientation.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum OrientationConvention {
    /// Roll, pitch, yaw about the fixed axes x, y, z: columns `roll pitch yaw`, or `rx ry rz`.
    Rpy,
    /// KUKA: columns `A B C`.
    KukaAbc,
    /// FANUC: columns `W P R`.
    FanucWpr,
    /// Moving axes x, y, z (Stäubli, Mecademic): columns `rx ry rz`.
    Xyz,
    /// Moving axes z, y, z (Kawasaki): columns `O A T`.
    Zyz,
    /// ABB: a quaternion in the columns `q1 q2 q3 q4`, scalar first.
    AbbQuaternion,
    /// A rotation vector (Universal Robots): columns `rx ry rz`, as without a convention.
    RotationVector,
}

use OrientationConvention as Convention;

impl Convention {
    /// The words of files and of the command line.
    pub const WORDS: [(&'static str, Convention); 9] = [
        ("rpy", Convention::Rpy),
        ("fixed_xyz", Convention::Rpy),
        ("abc", Convention::KukaAbc),
        ("wpr", Convention::FanucWpr),
        ("xyz", Convention::Xyz),
        ("zyz", Convention::Zyz),
        ("oat", Convention::Zyz),
        ("q1q2q3q4", Convention::AbbQuaternion),
        ("rotation_vector", Convention::RotationVector),
    ];

    /// The convention of this name.
    pub fn named(word: &str) -> Option<Convention> {
        Convention::WORDS.iter().find(|(known, _)| *known == word).map(|(_, convention)| *convention)
    }

    /// The rotation of three angles, rad; none where the convention has no angles.
    pub fn rotation(self, [a, b, c]: [f64; 3]) -> Option<Matrix3<f64>> {
        let turn = |axis: usize, angle: f64| Pose::rot(axis, angle).rotation;
        Some(match self {
            Convention::Rpy | Convention::FanucWpr => turn(2, c) * turn(1, b) * turn(0, a),
            Convention::KukaAbc => turn(2, a) * turn(1, b) * turn(0, c),
            Convention::Xyz => turn(0, a) * turn(1, b) * turn(2, c),
            Convention::Zyz => turn(2, a) * turn(1, b) * turn(2, c),
            Convention::AbbQuaternion | Convention::RotationVector => return None,
        })
    }

    /// Three angles of a rotation, rad, or its rotation vector; none of a quaternion. Where an angle is not determined the last one is 0.
    pub fn angles(self, rotation: &Matrix3<f64>) -> Option<[f64; 3]> {
        let rpy = |of: Matrix3<f64>| Pose::new(of, Vector3::zeros()).rpy();
        Some(match self {
            Convention::Rpy | Convention::FanucWpr => rpy(*rotation),
            Convention::KukaAbc => {
                let [c, b, a] = rpy(*rotation);
                [a, b, c]
            }
            // The inverse is about the same axes in the opposite order.
            Convention::Xyz => rpy(rotation.transpose()).map(|angle| -angle),
            Convention::Zyz => {
                let r = rotation;
                let sine = r[(0, 2)].hypot(r[(1, 2)]);
                let b = sine.atan2(r[(2, 2)]);
                if sine > 1e-9 {
                    [r[(1, 2)].atan2(r[(0, 2)]), b, r[(2, 1)].atan2(-r[(2, 0)])]
                } else {
                    let sign = r[(2, 2)].signum();
                    [(sign * r[(1, 0)]).atan2(sign * r[(0, 0)]), b, 0.0]
                }
            }
            Convention::RotationVector => rotation_log(rotation).into(),
            Convention::AbbQuaternion => return None,
        })
    }

    /// Names of its three numbers; none of a quaternion.
    pub fn names(self) -> Option<[&'static str; 3]> {
        match self {
            Convention::Rpy => Some(["roll", "pitch", "yaw"]),
            Convention::KukaAbc => Some(["a", "b", "c"]),
            Convention::FanucWpr => Some(["w", "p", "r"]),
            Convention::Xyz | Convention::RotationVector => Some(["rx", "ry", "rz"]),
            Convention::Zyz => Some(["o", "a", "t"]),
            Convention::AbbQuaternion => None,
        }
    }

    /// Which of its angles a column of this name is.
    pub(super) fn angle(self, name: &str) -> Option<usize> {
        let names: &[[&str; 3]] = match self {
            Convention::Rpy => &[["roll", "pitch", "yaw"], ["rx", "ry", "rz"]],
            Convention::KukaAbc => &[["a", "b", "c"]],
            Convention::FanucWpr => &[["w", "p", "r"]],
            Convention::Xyz => &[["rx", "ry", "rz"]],
            Convention::Zyz => &[["o", "a", "t"], ["rx", "ry", "rz"]],
            Convention::AbbQuaternion | Convention::RotationVector => &[],
        };
        let name = name.to_lowercase();
        names.iter().find_map(|names| names.iter().position(|known| *known == name))
    }

    /// Which number of its quaternion a column of this name is.
    pub(super) fn quaternion(self, name: &str) -> Option<usize> {
        let names = ["q1", "q2", "q3", "q4"];
        if self != Convention::AbbQuaternion {
            return None;
        }
        names.iter().position(|known| name.eq_ignore_ascii_case(known))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_same_orientation_in_every_convention() {
        // 90° about x, then 90° about the fixed z.
        let quarter = std::f64::consts::FRAC_PI_2;
        let wanted = Matrix3::new(0.0, 0.0, 1.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0);
        for (convention, angles) in [
            (Convention::Rpy, [quarter, 0.0, quarter]),
            (Convention::FanucWpr, [quarter, 0.0, quarter]),
            (Convention::KukaAbc, [quarter, 0.0, quarter]),
            (Convention::Xyz, [quarter, quarter, 0.0]),
            (Convention::Zyz, [0.0, quarter, quarter]),
        ] {
            let found = convention.rotation(angles).unwrap();
            assert!((found - wanted).amax() < 1e-15, "{convention:?} {found}");
        }
        // What distinguishes KUKA's order from roll, pitch, yaw.
        let [abc, rpy] = [Convention::KukaAbc, Convention::Rpy].map(|c| c.rotation([0.3, 0.2, 0.1]).unwrap());
        assert!((abc - rpy).amax() > 0.1);
        let back = Convention::Rpy.rotation([0.1, 0.2, 0.3]).unwrap();
        assert!((abc - back).amax() < 1e-15);
    }

    #[test]
    fn angles_are_those_of_the_rotation() {
        let all =
            [Convention::Rpy, Convention::FanucWpr, Convention::KukaAbc, Convention::Xyz, Convention::Zyz];
        for angles in [[0.3, 0.9, -2.0], [-3.0, 0.2, 1.0], [0.4, 0.0, 0.0], [0.7, std::f64::consts::PI, 0.0]]
        {
            for convention in all {
                let wanted = convention.rotation(angles).unwrap();
                let found = convention.rotation(convention.angles(&wanted).unwrap()).unwrap();
                assert!((found - wanted).amax() < 1e-12, "{convention:?} {angles:?}");
            }
        }
        let turned = Convention::RotationVector.angles(&Pose::rot(1, 0.4).rotation).unwrap();
        assert!((turned[1] - 0.4).abs() < 1e-12 && turned[0].abs() < 1e-12);
        assert_eq!(Convention::AbbQuaternion.angles(&Matrix3::identity()), None);
    }

    #[test]
    fn names_of_columns() {
        assert_eq!(Convention::named("abc"), Some(Convention::KukaAbc));
        assert_eq!(Convention::KukaAbc.angle("C"), Some(2));
        assert_eq!(Convention::Rpy.angle("yaw"), Some(2));
        assert_eq!(Convention::RotationVector.angle("rx"), None);
        assert_eq!(Convention::AbbQuaternion.quaternion("q1"), Some(0));
    }
}
