//! Views of a camera that the robot carries: all of its points in the image, from in front of them and not from the side.
//!
//! ```text
//! a = X (u, v, 1)ᵀ s,     s = f w/(share · width),     T(q) a = b̄
//! ```
//!
//! | symbol | here | unit | frame |
//! | --- | --- | --- | --- |
//! | X | the camera on its tool | m | tool |
//! | u, v | where in the image the middle of the points is to be, over the focal length | 1 | camera |
//! | w, b̄ | extent and middle of the points | m | measurement |
//! | share | part of the image's width that they fill: drawn between a quarter and nine tenths | 1 | |

use nalgebra::Vector3;
use rand::{Rng, RngExt};
use std::any::Any;
use truepose_errormodel::observation::{Camera, Observation, Reading};
use truepose_errormodel::{FittedModel, Landmark, Surroundings};
use truepose_kinematics::{Conditions, Pose, ToolId};

/// Part of the image that counts, about its middle: at its edge points are cut off.
pub(super) const INSIDE: f64 = 0.9;
/// Of the image's width, what the points fill.
const SHARE: [f64; 2] = [0.25, 0.9];
/// Part of the image, about its middle, in which the middle of the points is put.
const MIDDLE: f64 = 0.4;
/// Cosine of the largest angle between the line of sight and the normal of the points.
const STEEP: f64 = 0.4;

/// A camera on the robot, and the points that it looks at.
pub(super) struct View {
    camera: Camera,
    pub tool: ToolId,
    /// Number among the landmarks, and place, m, measurement frame.
    points: Vec<(usize, Vector3<f64>)>,
    pub middle: Vector3<f64>,
    extent: f64,
    /// Away from the points, on the side from which they are seen where that is known; none of points that span no plane.
    normal: Option<Vector3<f64>>,
    one_side: bool,
}

impl View {
    /// Of a declared camera, or why nobody can say where it looks.
    pub fn of(
        camera: &Landmark,
        tool: Option<ToolId>,
        surroundings: &Surroundings,
        fitted: &FittedModel,
    ) -> Result<Self, String> {
        let observed = camera.observed.as_deref().map(|observed| observed as &dyn Any);
        let own = observed.and_then(|any| any.downcast_ref::<Camera>()).ok_or("it is no camera")?;
        let place =
            own.place.ok_or("it is not said where it sits on the robot (its place in [[cameras]])")?;
        let tool = tool.ok_or("the robot has no tool of that name")?;
        let known = |(k, thing): (usize, &Landmark)| {
            let point = thing.position.filter(|_| thing.known && thing.observed.is_none())?;
            Some((k, point))
        };
        let points: Vec<(usize, Vector3<f64>)> =
            surroundings.landmarks.iter().enumerate().filter_map(known).collect();
        if points.len() < 4 {
            return Err("it needs four landmarks of known place at least to look at".into());
        }
        let middle = points.iter().map(|(_, p)| p).sum::<Vector3<f64>>() / points.len() as f64;
        let far = points.iter().map(|(_, p)| (p - middle).norm()).fold(0.0, f64::max);
        let mut view = View {
            camera: own.clone(),
            tool,
            normal: normal(&points, &middle),
            points,
            middle,
            extent: 2.0 * far,
            one_side: false,
        };
        view.find_front(fitted, &place);
        Ok(view)
    }

    /// Turns the normal to the side from which a fit's own rows have looked.
    fn find_front(&mut self, fitted: &FittedModel, place: &Pose) {
        let Some(normal) = self.normal else { return };
        let rows = fitted.domain.sample.rows();
        let Ok(mut predictor) = fitted.bind(&rows.schema) else { return };
        let mut before = 0.0f64;
        for row in 0..rows.len() {
            let at = predictor.predict(&Conditions { tool: self.tool, ..rows.conditions(row) }, None);
            before += normal.dot(&(at.apply(&place.translation) - self.middle)).signum();
        }
        if !rows.is_empty() && before.abs() > 0.8 * rows.len() as f64 {
            self.normal = Some(normal * before.signum());
            self.one_side = true;
        }
    }

    fn size(&self) -> [f64; 2] {
        let [_, _, cx, cy] = self.camera.intrinsics;
        self.camera.size.unwrap_or([2.0 * cx, 2.0 * cy])
    }

    /// A point in front of the camera, in its tool's frame, that is to come to the middle of the points, m.
    pub fn ahead(&self, random: &mut impl Rng) -> Vector3<f64> {
        let [fx, fy, cx, cy] = self.camera.intrinsics;
        let [width, height] = self.size();
        let share = SHARE[0] + (SHARE[1] - SHARE[0]) * random.random::<f64>();
        let depth = fx * self.extent / (share * width);
        let mut beside = |size: f64, focal: f64, centre: f64| {
            (size * (0.5 + MIDDLE * (random.random::<f64>() - 0.5)) - centre) / focal
        };
        let ahead = Vector3::new(beside(width, fx, cx), beside(height, fy, cy), 1.0) * depth;
        self.camera.place.unwrap_or_default().apply(&ahead)
    }

    /// The points that are seen with the tool here: all of them, or none where one is not.
    pub fn seen(&self, tool: &Pose, reading: &mut Reading) -> Option<Vec<usize>> {
        let centre = tool.apply(&self.camera.place.unwrap_or_default().translation);
        let sight = (centre - self.middle).normalize();
        if let Some(normal) = self.normal {
            let cosine = normal.dot(&sight);
            if (if self.one_side { cosine } else { cosine.abs() }) < STEEP {
                return None;
            }
        }
        let mut all = Vec::with_capacity(self.points.len());
        for (k, point) in &self.points {
            let own = tool.rotation.tr_mul(&(point - tool.translation));
            let at = Pose::new(nalgebra::Matrix3::identity(), own);
            let inside = |(value, size): (&f64, f64)| (value / size - 0.5).abs() <= 0.5 * INSIDE;
            if !self.camera.read(&at, reading) || !reading.value.iter().zip(self.size()).all(inside) {
                return None;
            }
            all.push(*k);
        }
        Some(all)
    }
}

/// The normal of points that span a plane, and are thin across it.
fn normal(points: &[(usize, Vector3<f64>)], middle: &Vector3<f64>) -> Option<Vector3<f64>> {
    let scatter: nalgebra::Matrix3<f64> =
        points.iter().map(|(_, p)| (p - middle) * (p - middle).transpose()).sum();
    let eigen = scatter.symmetric_eigen();
    let thin = eigen.eigenvalues.imin();
    let mut sizes: Vec<f64> = eigen.eigenvalues.iter().copied().collect();
    sizes.sort_by(f64::total_cmp);
    (sizes[1] > 1e-4 * sizes[2] && sizes[0] < 1e-2 * sizes[1])
        .then(|| eigen.eigenvectors.column(thin).into_owned())
}
