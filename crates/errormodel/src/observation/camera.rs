//! What a camera that stands in the cell sees of a target on the tool: a pinhole with distortion.
//!
//! ```text
//! p_c = Rᵀ (p − t),   x = p_c,x/p_c,z,  y = p_c,y/p_c,z,   r² = x² + y²
//! x_d = x (1 + k₁ r² + k₂ r⁴ + k₃ r⁶) + 2 p₁ x y + p₂ (r² + 2 x²)
//! y_d = y (1 + k₁ r² + k₂ r⁴ + k₃ r⁶) + p₁ (r² + 2 y²) + 2 p₂ x y
//! u = f_x x_d + c_x,   v = f_y y_d + c_y
//! ```
//!
//! | symbol | here | unit |
//! | --- | --- | --- |
//! | R, t | [`Camera::place`]: the camera's axes (x right, y down, z forward) and its centre | 1, m, measurement frame |
//! | f_x, f_y, c_x, c_y | [`Camera::intrinsics`] | px |
//! | k₁, k₂, p₁, p₂, k₃ | [`Camera::distortion`], in the order of OpenCV | 1 |
//!
//! Source: D. C. Brown, Close-range camera calibration, *Photogrammetric Engineering* 37 (1971). Unknowns are the centre, turns about the axes of the
//! measurement frame, and the intrinsics where they are free: from few views these are hardly distinguishable from the place.

use super::seam::{OFF, Observation, Reading, Seen, TURNED, shown, taken};
use super::start::{centre, descended};
use crate::Column;
use nalgebra::{Matrix2, Matrix2x3, Matrix3, Vector3};
use std::any::Any;
use truepose_kinematics::{Pose, rotation_vector, skew};

/// A camera in the cell.
#[derive(Debug, Clone, PartialEq)]
pub struct Camera {
    /// Its axes and centre, measurement frame; none: found from the data.
    pub place: Option<Pose>,
    /// Whether that is exact.
    pub known: bool,
    /// f_x, f_y, c_x, c_y, px.
    pub intrinsics: [f64; 4],
    /// k₁, k₂, p₁, p₂, k₃.
    pub distortion: [f64; 5],
    /// Whether the intrinsics are unknowns.
    pub free_intrinsics: bool,
    /// Width and height of the image, px, where they are known.
    pub size: Option<[f64; 2]>,
}

/// Expected size of an error of a focal length or a principal point, px.
const OF_INTRINSICS: f64 = 10.0;

impl Camera {
    /// Its word.
    pub const KIND: &'static str = "pixel";

    fn place(&self) -> Pose {
        self.place.unwrap_or_default()
    }

    /// Distorted coordinates and their derivatives by (x, y).
    fn distorted(&self, x: f64, y: f64) -> ([f64; 2], [[f64; 2]; 2]) {
        let [k1, k2, p1, p2, k3] = self.distortion;
        let z = x * x + y * y;
        let radial = 1.0 + z * (k1 + z * (k2 + z * k3));
        let slope = 2.0 * (k1 + z * (2.0 * k2 + z * 3.0 * k3));
        let at = [
            x * radial + 2.0 * p1 * x * y + p2 * (z + 2.0 * x * x),
            y * radial + p1 * (z + 2.0 * y * y) + 2.0 * p2 * x * y,
        ];
        let across = x * y * slope + 2.0 * p1 * x + 2.0 * p2 * y;
        let by = [
            [radial + x * x * slope + 2.0 * p1 * y + 6.0 * p2 * x, across],
            [across, radial + y * y * slope + 6.0 * p1 * y + 2.0 * p2 * x],
        ];
        (at, by)
    }

    /// Turns of which one is within 63° of any other.
    fn turns() -> Vec<Matrix3<f64>> {
        let quarter = |axis: usize, times: usize| {
            rotation_vector(&(Vector3::ith(axis, std::f64::consts::FRAC_PI_2) * times as f64))
        };
        let faces = [(0, 0), (0, 1), (0, 2), (0, 3), (1, 1), (1, 3)];
        let turned = |(axis, times)| (0..4).map(move |k| quarter(axis, times) * quarter(2, k));
        faces.into_iter().flat_map(turned).collect()
    }
}

impl Observation for Camera {
    fn kind(&self) -> &'static str {
        Self::KIND
    }

    fn unit(&self) -> &'static str {
        "px"
    }

    fn numbers(&self) -> usize {
        2
    }

    fn unknowns(&self, name: &str, length: f64) -> Vec<Column> {
        let mut all = Vec::new();
        if !self.known {
            let axis = |axis: &str| Column::new(format!("{axis}@{name}"), "m", OFF * length);
            let turn = |axis: &str| Column::new(format!("{axis}@{name}"), "rad", TURNED);
            all.extend(["x", "y", "z"].map(axis));
            all.extend(["rx", "ry", "rz"].map(turn));
        }
        if self.free_intrinsics {
            let of = |word: &str| Column::new(format!("{word} of {name}"), "px", OF_INTRINSICS);
            all.extend(["fx", "fy", "cx", "cy"].map(of));
        }
        all
    }

    fn read(&self, at: &Pose, out: &mut Reading) -> bool {
        let place = self.place();
        let away = at.translation - place.translation;
        let own = place.rotation.tr_mul(&away);
        if own.z <= 1e-6 {
            return false;
        }
        let (x, y) = (own.x / own.z, own.y / own.z);
        let ([xd, yd], by) = self.distorted(x, y);
        let [fx, fy, cx, cy] = self.intrinsics;
        let project = Matrix2x3::new(1.0, 0.0, -x, 0.0, 1.0, -y) / own.z;
        let lens = Matrix2::new(fx * by[0][0], fx * by[0][1], fy * by[1][0], fy * by[1][1]);
        let by_position = lens * project * place.rotation.transpose();
        let by_turn = by_position * skew(&away);
        out.value.clear();
        out.value.extend([fx * xd + cx, fy * yd + cy]);
        out.by_pose.clear();
        out.by_own.resize_with(2, Vec::new);
        for k in 0..2 {
            let row = by_position.row(k);
            out.by_pose.push([row[0], row[1], row[2], 0.0, 0.0, 0.0]);
            let own = &mut out.by_own[k];
            own.clear();
            if !self.known {
                own.extend(row.iter().map(|v| -v));
                own.extend(by_turn.row(k).iter());
            }
            if self.free_intrinsics {
                let of = [[xd, 0.0, 1.0, 0.0], [0.0, yd, 0.0, 1.0]];
                own.extend(of[k]);
            }
        }
        true
    }

    fn moved(&self, by: &[f64]) -> Box<dyn Observation> {
        let mut moved = self.clone();
        let mut rest = by;
        if let ([x, y, z, a, b, c, more @ ..], false) = (by, self.known) {
            let place = self.place();
            let turn = rotation_vector(&Vector3::new(*a, *b, *c));
            moved.place =
                Some(Pose::new(turn * place.rotation, place.translation + Vector3::new(*x, *y, *z)));
            rest = more;
        }
        if self.free_intrinsics {
            moved.intrinsics.iter_mut().zip(rest).for_each(|(value, by)| *value += by);
        }
        Box::new(moved)
    }

    fn started(&self, seen: &[Seen]) -> Result<Box<dyn Observation>, String> {
        if self.known {
            return Ok(self.boxed());
        }
        if seen.len() < 4 {
            return Err("four of its rows at least determine where it stands: take more".into());
        }
        let squares = |of: &dyn Observation| -> Option<f64> {
            let mut reading = Reading::default();
            let one = |(at, z): &Seen| {
                of.read(at, &mut reading)
                    .then(|| (reading.value[0] - z[0]).powi(2) + (reading.value[1] - z[1]).powi(2))
            };
            seen.iter().map(one).sum()
        };
        // Intrinsics are left out of a start: beside a wrong place they go anywhere.
        let held = Camera { free_intrinsics: false, ..self.clone() };
        if held.place.is_some() && squares(&held).is_some() {
            return Ok(descended(self, seen));
        }
        let middle = centre(seen);
        let [fx, fy, cx, cy] = self.intrinsics;
        let spread = (seen.iter().map(|(at, _)| (at.translation - middle).norm_squared()).sum::<f64>()
            / seen.len() as f64)
            .sqrt();
        let n = seen.len() as f64;
        let mean = [0, 1].map(|k| seen.iter().map(|(_, z)| z[k]).sum::<f64>() / n);
        let image = (seen
            .iter()
            .map(|(_, z)| ((z[0] - mean[0]) / fx).powi(2) + ((z[1] - mean[1]) / fy).powi(2))
            .sum::<f64>()
            / n)
            .sqrt();
        let ahead = Vector3::new((mean[0] - cx) / fx, (mean[1] - cy) / fy, 1.0);
        // Across the line of sight there are two of the three directions of the spread.
        let depth = (spread * 0.8 / image.max(1e-9)).max(1.5 * spread);
        let mut best: Option<(f64, Box<dyn Observation>)> = None;
        for turn in Camera::turns() {
            let from = Camera { place: Some(Pose::new(turn, middle - turn * ahead * depth)), ..held.clone() };
            let found = descended(&from, seen);
            let Some(left) = squares(&*found) else { continue };
            if best.as_ref().is_none_or(|(least, _)| left < *least) {
                best = Some((left, found));
            }
        }
        let none = "no place of the camera explains its pixels: check the intrinsics, that x is to the right, y down, and that rows name the right target";
        let (left, found) = best.ok_or(none)?;
        // A tenth of the image is no error of a robot.
        if (left / n).sqrt() > 0.1 * image * fx {
            return Err(none.into());
        }
        let place = (&*found as &dyn Any).downcast_ref::<Camera>().and_then(|camera| camera.place);
        Ok(if self.free_intrinsics { descended(&Camera { place, ..self.clone() }, seen) } else { found })
    }

    fn placed(&self) -> bool {
        self.place.is_some()
    }

    fn values(&self) -> Vec<(&'static str, f64, &'static str)> {
        let place = self.place();
        let rpy = place.rpy().map(f64::to_degrees);
        let mut all = shown(place.translation).to_vec();
        all.extend(["roll", "pitch", "yaw"].into_iter().zip(rpy).map(|(name, v)| (name, v, "deg")));
        all.extend(
            ["fx", "fy", "cx", "cy"].into_iter().zip(self.intrinsics).map(|(name, v)| (name, v, "px")),
        );
        all
    }

    fn freed(&self) -> Vec<(&'static str, Box<dyn Observation>)> {
        let lens = Camera { free_intrinsics: true, ..self.clone() };
        let place = Camera { known: false, ..self.clone() };
        taken([(self.known, "place", Box::new(place)), (!self.free_intrinsics, "lens", Box::new(lens))])
    }

    fn metric(&self) -> bool {
        false
    }

    fn outside(&self) -> bool {
        self.known
    }

    fn boxed(&self) -> Box<dyn Observation> {
        Box::new(self.clone())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testkit::{check_observation, scattered};

    fn ahead() -> Camera {
        let turn = rotation_vector(&Vector3::new(0.1, -0.2, 0.3));
        Camera {
            place: Some(Pose::new(turn, -(turn * Vector3::new(0.1, 0.2, 3.0)))),
            known: false,
            intrinsics: [900.0, 905.0, 640.0, 360.0],
            distortion: [-0.1, 0.02, 1e-3, -2e-3, 1e-3],
            free_intrinsics: false,
            size: None,
        }
    }

    #[test]
    fn conforms() {
        check_observation(&ahead());
        check_observation(&Camera { free_intrinsics: true, ..ahead() });
        check_observation(&Camera { known: true, free_intrinsics: true, ..ahead() });
    }

    #[test]
    fn a_camera_is_found_from_nothing_and_sees_nothing_behind_it() {
        for (turn, far) in [(Vector3::new(2.0, 0.4, -1.0), 2.5), (Vector3::new(-0.3, 1.2, 2.2), 4.0)] {
            let turn = rotation_vector(&turn);
            let truth =
                Camera { place: Some(Pose::new(turn, -(turn * Vector3::new(0.2, -0.1, far)))), ..ahead() };
            let mut reading = Reading::default();
            let see = |at: Pose| {
                assert!(truth.read(&at, &mut reading));
                (at, reading.value.clone())
            };
            let seen: Vec<Seen> = scattered(30).into_iter().map(see).collect();
            for free_intrinsics in [false, true] {
                let found = Camera { place: None, free_intrinsics, ..ahead() }.started(&seen).unwrap();
                for (at, z) in &seen {
                    assert!(found.read(at, &mut reading));
                    assert!((reading.value[0] - z[0]).abs() + (reading.value[1] - z[1]).abs() < 1e-4);
                }
            }
            let behind = Pose::new(Matrix3::identity(), turn * Vector3::new(0.2, -0.1, -far - 1.0));
            assert!(!truth.read(&behind, &mut reading));
            let mirrored: Vec<Seen> = seen.iter().map(|(at, z)| (*at, vec![1280.0 - z[0], z[1]])).collect();
            let error = Camera { place: None, ..ahead() }.started(&mirrored).unwrap_err();
            assert!(error.contains("no place of the camera"), "{error}");
        }
    }
}
