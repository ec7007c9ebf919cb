//! The six generalized errors of a frame, and the error matrix `E_i` that they make.
//!
//! | symbol | here | unit | the paper's |
//! | --- | --- | --- | --- |
//! | x, y, z | components 0…2 | m | e_x, e_y, e_z |
//! | rx | component 3 | rad | pitch e_p, about X |
//! | ry | component 4 | rad | spin e_s, about Y |
//! | rz | component 5 | rad | roll e_r, about Z |
//!
//! Exactly, `E = [R_Y(ry) R_Z(rz) R_X(rx), t]`; to first order (Eq. 2) `E = I + [[φ]×, t]`.

use crate::{Emission, Entry};
use nalgebra::{Matrix3, Vector3};
use truepose_kinematics::{Chain, FrameId, Pose, Site, TargetId, sin_cos};

/// All generalized errors of a robot: six a frame, three a target, in SI units.
#[derive(Debug, Clone, PartialEq)]
pub struct GeneralizedErrors {
    values: Vec<f64>,
    frames: usize,
}

impl GeneralizedErrors {
    /// A perfect robot.
    pub fn zero(chain: &Chain) -> Self {
        GeneralizedErrors { values: vec![0.0; chain.site_count()], frames: chain.frames().len() }
    }

    /// Sets all to zero.
    pub fn clear(&mut self) {
        self.values.fill(0.0);
    }

    /// Those of an emission with these coefficients: ε = Φ c.
    pub fn weigh(&mut self, emission: &Emission, coefficients: &[f64]) {
        self.clear();
        self.add_those(emission.entries(), coefficients);
    }

    /// Adds those of some entries with these coefficients.
    pub(crate) fn add_those(&mut self, entries: &[Entry], coefficients: &[f64]) {
        for entry in entries {
            self.add(entry.site, entry.value * coefficients[entry.column]);
        }
    }

    /// Takes the values of another robot of the same kind.
    pub(crate) fn copy_from(&mut self, other: &GeneralizedErrors) {
        self.values.copy_from_slice(&other.values);
    }

    /// The largest difference to another robot of the same kind, m or rad; infinite where it is no number.
    pub(crate) fn furthest(&self, other: &GeneralizedErrors) -> f64 {
        let apart = self.values.iter().zip(&other.values).map(|(a, b)| (a - b).abs());
        apart.fold(0.0, |most, v| if v.is_nan() { f64::INFINITY } else { most.max(v) })
    }

    /// Adds to the error at a site.
    #[inline]
    pub fn add(&mut self, site: Site, value: f64) {
        let index = self.index(site);
        self.values[index] += value;
    }

    /// The error at a site, m or rad.
    pub fn get(&self, site: Site) -> f64 {
        self.values[self.index(site)]
    }

    /// `[x y z rx ry rz]` of a frame.
    #[inline]
    pub fn frame(&self, frame: FrameId) -> [f64; 6] {
        std::array::from_fn(|k| self.values[6 * frame.0 + k])
    }

    /// Error of a target's position, in the tool's axes, m; zero of a target that a single row has of its own.
    pub fn target(&self, target: TargetId) -> Vector3<f64> {
        let start = 6 * self.frames + 3 * target.0;
        self.values.get(start..start + 3).map_or_else(Vector3::zeros, Vector3::from_column_slice)
    }

    #[inline]
    fn index(&self, site: Site) -> usize {
        match site {
            Site::Frame(frame, axis) => 6 * frame.0 + axis.index(),
            Site::Target(target, axis) => 6 * self.frames + 3 * target.0 + axis.direction(),
        }
    }
}

/// The error matrix, exactly: rotations about Y, Z, X in that order, with the translation.
#[inline]
pub fn error_matrix(e: &[f64; 6]) -> Pose {
    matrix(e, [sin_cos(e[3]), sin_cos(e[4]), sin_cos(e[5])])
}

/// The same to the fourth power of the angles: 1e-10 at 0.01 rad. For levers, not for positions.
#[inline]
pub(crate) fn error_matrix_of_small(e: &[f64; 6]) -> Pose {
    let turn = |x: f64| {
        let z = x * x;
        (x - x * z * (1.0 / 6.0), 1.0 - 0.5 * z * (1.0 - z * (1.0 / 12.0)))
    };
    matrix(e, [turn(e[3]), turn(e[4]), turn(e[5])])
}

#[inline]
fn matrix(e: &[f64; 6], [(sx, cx), (sy, cy), (sz, cz)]: [(f64, f64); 3]) -> Pose {
    let translation = Vector3::new(e[0], e[1], e[2]);
    // R_Y(ry) R_Z(rz) R_X(rx), multiplied out.
    let rotation = Matrix3::new(
        cy * cz,
        sy * sx - cy * sz * cx,
        sy * cx + cy * sz * sx,
        sz,
        cz * cx,
        -cz * sx,
        -sy * cz,
        cy * sx + sy * sz * cx,
        cy * cx - sy * sz * sx,
    );
    Pose::new(rotation, translation)
}

/// The axes about which the rotation of [`error_matrix`] turns when rx, ry or rz grows, as columns, in the
/// axes of the frame in front of `E`: `[R_Y R_Z x̂, ŷ, R_Y ẑ]`. The identity at zero error.
pub fn rotation_axes(e: &[f64; 6]) -> Matrix3<f64> {
    let ((sy, cy), (sz, cz)) = (sin_cos(e[4]), sin_cos(e[5]));
    Matrix3::new(cy * cz, 0.0, sy, sz, 1.0, 0.0, -sy * cz, 0.0, cy)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use truepose_kinematics::rotation_log;

    proptest! {
        #[test]
        fn exact_matrix_is_the_product_of_three_rotations(e in prop::array::uniform6(-1.0..1.0f64)) {
            let product = Pose::rot(1, e[4]) * Pose::rot(2, e[5]) * Pose::rot(0, e[3]);
            prop_assert!((product.rotation - error_matrix(&e).rotation).amax() < 1e-15);
        }

        #[test]
        fn for_small_angles_powers_do(e in prop::array::uniform6(-0.02..0.02f64)) {
            let (a, b) = (error_matrix(&e), error_matrix_of_small(&e));
            prop_assert!((a.rotation - b.rotation).amax() < 1e-10);
        }

        #[test]
        fn axes_are_the_derivative(e in prop::array::uniform6(-1.0..1.0f64)) {
            let axes = rotation_axes(&e);
            for k in 0..3 {
                let at = |d: f64| { let mut f = e; f[3 + k] += d; error_matrix(&f).rotation };
                let turn = rotation_log(&(at(1e-6) * at(-1e-6).transpose())) / 2e-6;
                prop_assert!((turn - axes.column(k)).norm() < 1e-9);
            }
        }
    }
}
