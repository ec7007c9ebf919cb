//! A camera as it is: a pinhole behind a lens that bends.
//!
//! ```text
//! m = (x, y)/z,   t = (p₂, p₁),   m_d = m (1 + k₁ r² + k₂ r⁴ + k₃ r⁶ + 2 t·m) + t r²,   r² = m·m
//! u = f_x m_d,x + c_x,   v = f_y m_d,y + c_y
//! ```
//!
//! | symbol | here | unit | frame |
//! | --- | --- | --- | --- |
//! | x, y, z | a point: to the right, down and forward | m | camera |
//! | k, p | `distortion`, in the order of OpenCV: k₁, k₂, p₁, p₂, k₃ | 1 | |
//! | f, c | `intrinsics`: f_x, f_y, c_x, c_y | px | |
//!
//! Source: D. C. Brown, Close-range camera calibration, *Photogrammetric Engineering* 37 (1971).

use super::direction::within;
use nalgebra::{Isometry3, Point3, Vector2, Vector3};

/// A camera in the cell, or on the robot.
#[derive(Debug, Clone, PartialEq)]
pub struct Camera {
    /// Its axes and centre: in the measurement frame, or on the robot in the tool's.
    pub place: Isometry3<f64>,
    /// Whether the robot carries it.
    pub carried: bool,
    /// f_x, f_y, c_x, c_y, px.
    pub intrinsics: [f64; 4],
    /// k₁, k₂, p₁, p₂, k₃.
    pub distortion: [f64; 5],
    /// Width and height of the image, px.
    pub size: [f64; 2],
    /// Of a camera on the robot: the points that it looks at, their landmarks' numbers, m, measurement frame.
    pub points: Vec<(usize, Vector3<f64>)>,
    /// From how far it looks at the middle of these: nearest and farthest, m.
    pub range: [f64; 2],
    /// The side from which they are seen, a unit vector in the measurement frame, and the largest angle to it, rad; none: from any side.
    pub facing: Option<(Vector3<f64>, f64)>,
}

/// An image shows so many points at least, or all where there are fewer.
const LEAST_POINTS: usize = 4;
/// Steps in which a ray is followed from the axis to see whether the lens still spreads there.
const STEPS: usize = 16;

impl Camera {
    /// The pixel of a point in the camera's axes, m; none where it is behind the camera, outside of the image, or where the lens folds the image over.
    pub fn pixel(&self, point: &Vector3<f64>) -> Option<[f64; 2]> {
        if point.z <= 1e-6 {
            return None;
        }
        let m = Vector2::new(point.x, point.y) / point.z;
        let [k1, k2, p1, p2, k3] = self.distortion;
        let spreads = |k: usize| {
            let s = m.norm_squared() * (k as f64 / STEPS as f64).powi(2);
            1.0 + s * (3.0 * k1 + s * (5.0 * k2 + s * 7.0 * k3)) > 0.0
        };
        if !(0..=STEPS).all(spreads) {
            return None;
        }
        let (square, t) = (m.norm_squared(), Vector2::new(p2, p1));
        let radial = 1.0 + square * (k1 + square * (k2 + square * k3)) + 2.0 * t.dot(&m);
        let bent = m * radial + t * square;
        let [fx, fy, cx, cy] = self.intrinsics;
        let pixel = [fx * bent.x + cx, fy * bent.y + cy];
        self.shows(&pixel).then_some(pixel)
    }

    /// Whether a pixel is on the image.
    pub fn shows(&self, pixel: &[f64; 2]) -> bool {
        pixel.iter().zip(&self.size).all(|(value, size)| (0.0..=*size).contains(value))
    }

    /// Of a camera on the robot with the tool here: the points that it sees, and their pixels.
    pub fn image(&self, tool: &Isometry3<f64>) -> Vec<(usize, [f64; 2])> {
        let to_camera = (tool * self.place).inverse();
        let see = |(number, point): &(usize, Vector3<f64>)| {
            let pixel = self.pixel(&(to_camera * Point3::from(*point)).coords)?;
            Some((*number, pixel))
        };
        self.points.iter().filter_map(see).collect()
    }

    /// Whether an image from here is one to keep: it shows enough points, from the side from which they are seen.
    pub(super) fn keeps(&self, tool: &Isometry3<f64>) -> bool {
        let away = (tool * self.place).translation.vector - self.middle();
        let faces = self.facing.is_none_or(|(normal, most)| within(&away, &normal, most));
        faces && self.image(tool).len() >= LEAST_POINTS.min(self.points.len()).max(1)
    }

    /// The middle of the points that it looks at, m, measurement frame.
    pub(super) fn middle(&self) -> Vector3<f64> {
        let sum: Vector3<f64> = self.points.iter().map(|(_, point)| point).sum();
        sum / self.points.len().max(1) as f64
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn camera() -> Camera {
        Camera {
            place: Isometry3::identity(),
            carried: false,
            intrinsics: [900.0, 910.0, 640.0, 480.0],
            distortion: [-0.1, 0.02, 1e-3, -2e-3, 1e-3],
            size: [1280.0, 960.0],
            points: Vec::new(),
            range: [0.3, 0.6],
            facing: None,
        }
    }

    #[test]
    fn a_pixel_is_that_of_the_published_formula() {
        // OpenCV's projectPoints of (0.2, −0.1, 1.0), worked out by hand: r² = 0.05, radial 0.995050125.
        let [u, v] = camera().pixel(&Vector3::new(0.2, -0.1, 1.0)).expect("a pixel");
        let radial = 1.0 - 0.1 * 0.05 + 0.02 * 0.0025 + 1e-3 * 1.25e-4;
        let x = 0.2 * radial + 2.0 * 1e-3 * 0.2 * -0.1 - 2e-3 * (0.05 + 2.0 * 0.04);
        let y = -0.1 * radial + 1e-3 * (0.05 + 2.0 * 0.01) + 2.0 * -2e-3 * 0.2 * -0.1;
        assert!((u - (900.0 * x + 640.0)).abs() < 1e-10 && (v - (910.0 * y + 480.0)).abs() < 1e-10);
    }

    #[test]
    fn nothing_is_seen_behind_the_camera_beside_the_image_or_where_the_lens_folds() {
        assert_eq!(camera().pixel(&Vector3::new(0.0, 0.0, -1.0)), None);
        assert_eq!(camera().pixel(&Vector3::new(0.9, 0.0, 1.0)), None);
        // 1 − 0.9 r² is negative from r = 1.05 on: there the image would run back towards its middle.
        let folding = Camera { distortion: [-0.3, 0.0, 0.0, 0.0, 0.0], ..camera() };
        assert_eq!(folding.pixel(&Vector3::new(1.7, 0.0, 1.0)), None);
        assert!(folding.pixel(&Vector3::new(0.7, 0.0, 1.0)).is_some());
    }
}
