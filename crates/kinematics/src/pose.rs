//! Rigid transforms as a rotation matrix and a translation.
//!
//! | symbol | here | shape | unit |
//! | --- | --- | --- | --- |
//! | R | `rotation` | 3×3 orthonormal | 1 |
//! | p | `translation` | 3 | m |
//!
//! A pose `t_a_b` takes coordinates in frame b to coordinates in frame a: `x_a = R x_b + p`.

use nalgebra::{Matrix3, Vector3};
use serde::{Deserialize, Serialize};

/// A rigid transform.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Pose {
    /// Orthonormal 3×3 rotation.
    pub rotation: Matrix3<f64>,
    /// Translation, m.
    pub translation: Vector3<f64>,
}

impl Default for Pose {
    fn default() -> Self {
        Pose::IDENTITY
    }
}

impl Pose {
    /// No displacement.
    pub const IDENTITY: Pose = Pose {
        rotation: Matrix3::new(1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0),
        translation: Vector3::new(0.0, 0.0, 0.0),
    };

    /// From its parts; the rotation has to be orthonormal.
    #[inline]
    pub fn new(rotation: Matrix3<f64>, translation: Vector3<f64>) -> Self {
        Pose { rotation, translation }
    }

    /// From a translation (m) and rotations about the fixed axes x, y, z (rad), as in URDF.
    pub fn from_xyz_rpy(xyz: [f64; 3], rpy: [f64; 3]) -> Self {
        let [roll, pitch, yaw] = rpy;
        let rotation =
            Pose::rot(2, yaw).rotation * Pose::rot(1, pitch).rotation * Pose::rot(0, roll).rotation;
        Pose::new(rotation, Vector3::from(xyz))
    }

    /// Roll, pitch and yaw about the fixed axes x, y, z (rad), pitch in ±π/2.
    pub fn rpy(&self) -> [f64; 3] {
        let r = &self.rotation;
        let cos_pitch = r[(0, 0)].hypot(r[(1, 0)]);
        if cos_pitch > 1e-12 {
            [r[(2, 1)].atan2(r[(2, 2)]), (-r[(2, 0)]).atan2(cos_pitch), r[(1, 0)].atan2(r[(0, 0)])]
        } else {
            [(-r[(1, 2)]).atan2(r[(1, 1)]), (-r[(2, 0)]).atan2(cos_pitch), 0.0]
        }
    }

    /// Rotation by `angle` (rad) about coordinate axis 0, 1 or 2.
    pub fn rot(direction: usize, angle: f64) -> Self {
        let (s, c) = sin_cos_exact(angle);
        let rotation = match direction {
            0 => Matrix3::new(1.0, 0.0, 0.0, 0.0, c, -s, 0.0, s, c),
            1 => Matrix3::new(c, 0.0, s, 0.0, 1.0, 0.0, -s, 0.0, c),
            _ => Matrix3::new(c, -s, 0.0, s, c, 0.0, 0.0, 0.0, 1.0),
        };
        Pose::new(rotation, Vector3::zeros())
    }

    /// Translation by `distance` (m) along coordinate axis 0, 1 or 2.
    pub fn trans(direction: usize, distance: f64) -> Self {
        let mut translation = Vector3::zeros();
        translation[direction] = distance;
        Pose::new(Matrix3::identity(), translation)
    }

    /// From a quaternion (w, x, y, z), which is normalised here.
    pub fn rotation_from_quaternion([w, x, y, z]: [f64; 4]) -> Matrix3<f64> {
        let n = 2.0 / (w * w + x * x + y * y + z * z);
        Matrix3::new(
            1.0 - n * (y * y + z * z),
            n * (x * y - w * z),
            n * (x * z + w * y),
            n * (x * y + w * z),
            1.0 - n * (x * x + z * z),
            n * (y * z - w * x),
            n * (x * z - w * y),
            n * (y * z + w * x),
            1.0 - n * (x * x + y * y),
        )
    }

    /// Unit quaternion (w, x, y, z) with w ≥ 0.
    pub fn quaternion(&self) -> [f64; 4] {
        let r = &self.rotation;
        // The largest of the four is taken from the diagonal, the others by division (Shepperd 1978).
        let diagonal = [r[(0, 0)] + r[(1, 1)] + r[(2, 2)], r[(0, 0)], r[(1, 1)], r[(2, 2)]];
        let largest = (0..4).fold(0, |best, k| if diagonal[k] > diagonal[best] { k } else { best });
        let mut q = [0.0; 4];
        if largest == 0 {
            let s = 2.0 * (1.0 + diagonal[0]).max(0.0).sqrt();
            q[0] = 0.25 * s;
            q[1] = (r[(2, 1)] - r[(1, 2)]) / s;
            q[2] = (r[(0, 2)] - r[(2, 0)]) / s;
            q[3] = (r[(1, 0)] - r[(0, 1)]) / s;
        } else {
            let i = largest - 1;
            let (j, k) = ((i + 1) % 3, (i + 2) % 3);
            let s = 2.0 * (1.0 + r[(i, i)] - r[(j, j)] - r[(k, k)]).max(0.0).sqrt();
            q[1 + i] = 0.25 * s;
            q[0] = (r[(k, j)] - r[(j, k)]) / s;
            q[1 + j] = (r[(j, i)] + r[(i, j)]) / s;
            q[1 + k] = (r[(k, i)] + r[(i, k)]) / s;
        }
        let norm = q.iter().map(|v| v * v).sum::<f64>().sqrt() * if q[0] < 0.0 { -1.0 } else { 1.0 };
        q.map(|v| v / norm)
    }

    /// The transform that takes this one back.
    #[inline]
    pub fn inverse(&self) -> Pose {
        let rotation = self.rotation.transpose();
        Pose::new(rotation, -(rotation * self.translation))
    }

    /// The product, written out.
    #[inline]
    fn times(&self, inner: &Pose) -> Pose {
        let [x, y, z] = self.rotation.data.0;
        let through = |v: [f64; 3]| -> [f64; 3] {
            [
                x[0] * v[0] + y[0] * v[1] + z[0] * v[2],
                x[1] * v[0] + y[1] * v[1] + z[1] * v[2],
                x[2] * v[0] + y[2] * v[1] + z[2] * v[2],
            ]
        };
        let [a, b, c] = inner.rotation.data.0;
        let mut rotation = Matrix3::zeros();
        rotation.data.0 = [through(a), through(b), through(c)];
        Pose::new(rotation, Vector3::from(through(inner.translation.into())) + self.translation)
    }

    /// A point given in the inner frame, in the outer frame.
    #[inline]
    pub fn apply(&self, point: &Vector3<f64>) -> Vector3<f64> {
        self.rotation * point + self.translation
    }

    /// The nearest orthonormal rotation to a slightly drifted one (one step of Newton's polar iteration).
    pub fn renormalised(&self) -> Pose {
        let r = self.rotation;
        Pose::new(r * (Matrix3::identity() * 1.5 - r.transpose() * r * 0.5), self.translation)
    }

    /// True when every entry is finite.
    pub fn is_finite(&self) -> bool {
        self.rotation.iter().chain(self.translation.iter()).all(|v| v.is_finite())
    }
}

impl std::ops::Mul for Pose {
    type Output = Pose;
    #[inline]
    fn mul(self, inner: Pose) -> Pose {
        self.times(&inner)
    }
}

impl std::ops::Mul for &Pose {
    type Output = Pose;
    #[inline]
    fn mul(self, inner: &Pose) -> Pose {
        self.times(inner)
    }
}

/// `[v]×`, the matrix of the cross product with v.
pub fn skew(v: &Vector3<f64>) -> Matrix3<f64> {
    Matrix3::new(0.0, -v.z, v.y, v.z, 0.0, -v.x, -v.y, v.x, 0.0)
}

/// Rotation matrix of a rotation vector (axis × angle, rad), by Rodrigues' formula.
pub fn rotation_vector(v: &Vector3<f64>) -> Matrix3<f64> {
    let angle = v.norm();
    let k = skew(v);
    let (a, b) = if angle < 1e-4 {
        let t = angle * angle;
        (1.0 - t / 6.0, 0.5 - t / 24.0)
    } else {
        (angle.sin() / angle, (1.0 - angle.cos()) / (angle * angle))
    };
    Matrix3::identity() + k * a + k * k * b
}

/// The rotation nearest to a matrix (polar decomposition, determinant +1), in the sense of Frobenius; none of a matrix that holds no numbers.
/// Source: Kabsch, *A solution for the best rotation to relate two sets of vectors* (1976).
pub fn nearest_rotation(m: &Matrix3<f64>) -> Option<Matrix3<f64>> {
    let svd = m.svd(true, true);
    let (u, vt) = (svd.u?, svd.v_t?);
    // Singular values descend: the last direction is the weakest.
    let sign = if (u * vt).determinant() < 0.0 { -1.0 } else { 1.0 };
    let mut d = Matrix3::identity();
    d[(2, 2)] = sign;
    let rotation = u * d * vt;
    rotation.iter().all(|v| v.is_finite()).then_some(rotation)
}

/// Rotation vector (rad) of a rotation matrix; accurate near 0 and near π.
pub fn rotation_log(r: &Matrix3<f64>) -> Vector3<f64> {
    let [w, x, y, z] = Pose::new(*r, Vector3::zeros()).quaternion();
    let v = Vector3::new(x, y, z);
    let s = v.norm();
    if s < 1e-9 { v * 2.0 } else { v * (2.0 * s.atan2(w) / s) }
}

/// Sine and cosine that are exact at multiples of a quarter turn, so that `alpha = 90°` makes an exact zero.
pub(crate) fn sin_cos_exact(angle: f64) -> (f64, f64) {
    let quarter = angle / std::f64::consts::FRAC_PI_2;
    let nearest = quarter.round();
    if (quarter - nearest).abs() < 4.0 * f64::EPSILON * quarter.abs().max(1.0) && nearest.abs() < 1e6 {
        match nearest.rem_euclid(4.0) as u8 {
            0 => (0.0, 1.0),
            1 => (1.0, 0.0),
            2 => (0.0, -1.0),
            _ => (-1.0, 0.0),
        }
    } else {
        angle.sin_cos()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn close(a: &Matrix3<f64>, b: &Matrix3<f64>, tolerance: f64) -> bool {
        (a - b).amax() < tolerance
    }

    proptest! {
        #[test]
        fn quaternion_and_log_come_back(v in prop::array::uniform3(-3.0..3.0f64), scale in 1e-9..1.0f64) {
            let v = Vector3::from(v) * scale;
            prop_assume!(v.norm() < 3.1);
            let r = rotation_vector(&v);
            prop_assert!(close(&(r * r.transpose()), &Matrix3::identity(), 1e-14));
            let q = Pose::new(r, Vector3::zeros()).quaternion();
            prop_assert!(close(&Pose::rotation_from_quaternion(q), &r, 1e-14));
            prop_assert!((rotation_log(&r) - v).norm() < 1e-13 * (1.0 + 1.0 / (3.15 - v.norm())));
        }

        #[test]
        fn rpy_comes_back(rpy in prop::array::uniform3(-1.5..1.5f64)) {
            let pose = Pose::from_xyz_rpy([1.0, 2.0, 3.0], rpy);
            let again = Pose::from_xyz_rpy([1.0, 2.0, 3.0], pose.rpy());
            prop_assert!(close(&pose.rotation, &again.rotation, 1e-14));
            prop_assert!(((pose * pose.inverse()).translation).norm() < 1e-14);
        }
    }

    #[test]
    fn quarter_turns_are_exact() {
        let r = Pose::rot(0, std::f64::consts::FRAC_PI_2).rotation;
        assert_eq!(r, Matrix3::new(1.0, 0.0, 0.0, 0.0, 0.0, -1.0, 0.0, 1.0, 0.0));
        let r_z = Matrix3::new(0.0, 1.0, 0.0, -1.0, 0.0, 0.0, 0.0, 0.0, 1.0);
        assert!(close(&Pose::rot(2, -std::f64::consts::FRAC_PI_2).rotation, &r_z, f64::MIN_POSITIVE));
    }

    #[test]
    fn log_near_half_a_turn() {
        let v = Vector3::new(1.0, 2.0, -0.5).normalize() * (std::f64::consts::PI - 1e-8);
        assert!((rotation_log(&rotation_vector(&v)) - v).norm() < 1e-12);
    }
}
