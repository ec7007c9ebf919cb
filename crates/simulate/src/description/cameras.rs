//! Cameras as they are.

use super::landmarks::{MoveDescription, described_as, placed};
use crate::SimulateError;
use crate::cell::{Camera, What};
use nalgebra::{Isometry3, Translation3, UnitQuaternion, Vector3};
use serde::{Deserialize, Serialize};
use truepose_errormodel::Landmark;
use truepose_errormodel::observation;

/// A camera. What is left out is as the robot description has it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct CameraDescription {
    /// Its name in the robot description.
    pub name: String,
    /// How many images it takes; those in which it sees nothing are not taken.
    pub images: usize,
    /// What carries it where the robot description does not state it: `base` (it stands in the cell) or `tool`.
    pub mount: Option<String>,
    /// Where it is, mm: in the measurement frame, on the robot in the tool's.
    pub xyz_mm: Option<[f64; 3]>,
    /// How it is turned, about the fixed axes x, y, z, deg: x to the right, y down, z forward.
    pub rpy_deg: Option<[f64; 3]>,
    /// Focal lengths and principal point, px.
    pub fx: Option<f64>,
    /// px.
    pub fy: Option<f64>,
    /// px.
    pub cx: Option<f64>,
    /// px.
    pub cy: Option<f64>,
    /// k1, k2, p1, p2, k3, as OpenCV has them; the last ones may be left out.
    pub distortion: Option<Vec<f64>>,
    /// Width and height of the image, px; where neither description has it, twice the principal point.
    pub size: Option<[f64; 2]>,
    /// Of a camera on the robot: landmarks of known place that it looks at; empty: all that are described.
    pub points: Vec<String>,
    /// From how far it looks at their middle: nearest and farthest, mm.
    pub distance_mm: [f64; 2],
    /// The side from which the points are seen, measurement frame; left out: from any side.
    pub normal: Option<[f64; 3]>,
    /// Largest angle between `normal` and the line of sight, deg.
    pub within_deg: f64,
    /// Standard deviation of a pixel, px.
    pub sd_px: f64,
    /// Of a camera in the cell: targets that it sees; empty: all that the robot has, or its tool's origin.
    pub targets: Vec<String>,
    /// A jump during the campaign.
    pub moved: Option<MoveDescription>,
}

impl Default for CameraDescription {
    fn default() -> Self {
        CameraDescription {
            name: String::new(),
            images: 0,
            mount: None,
            xyz_mm: None,
            rpy_deg: None,
            fx: None,
            fy: None,
            cx: None,
            cy: None,
            distortion: None,
            size: None,
            points: Vec::new(),
            distance_mm: [300.0, 600.0],
            normal: None,
            within_deg: 60.0,
            sd_px: 0.0,
            targets: Vec::new(),
            moved: None,
        }
    }
}

impl CameraDescription {
    /// Whether the robot carries it.
    pub(super) fn carried(&self, described: Option<&Landmark>) -> bool {
        let mount = self.mount.as_deref().or_else(|| described.and_then(|known| known.mount.as_deref()));
        mount.is_some_and(|mount| mount != "base")
    }

    /// What it really is; on the robot it looks at these points.
    pub(super) fn what(
        &self,
        described: Option<&Landmark>,
        points: Vec<(usize, Vector3<f64>)>,
    ) -> Result<What, SimulateError> {
        let known = described_as::<observation::Camera>(described);
        let own = [self.fx, self.fy, self.cx, self.cy];
        let mut intrinsics = [0.0; 4];
        for (k, key) in ["fx", "fy", "cx", "cy"].into_iter().enumerate() {
            let value = own[k].or(known.map(|known| known.intrinsics[k]));
            intrinsics[k] =
                value.ok_or_else(|| self.wrong(&format!("neither this file nor the robot's has `{key}`")))?;
        }
        let carried = self.carried(described);
        let place = match (self.xyz_mm, self.rpy_deg, known.and_then(|known| known.place)) {
            (Some(xyz), Some(rpy), _) => placed(xyz, rpy),
            (None, None, Some(pose)) => {
                let turn = UnitQuaternion::from_matrix(&pose.rotation);
                Isometry3::from_parts(Translation3::from(pose.translation), turn)
            }
            _ => return Err(self.wrong("it needs `xyz_mm` and `rpy_deg`: where it is and how it is turned")),
        };
        let mut distortion = known.map_or([0.0; 5], |known| known.distortion);
        if let Some(own) = &self.distortion {
            if own.len() > 5 {
                return Err(self.wrong("`distortion` has 5 numbers at the most: k1, k2, p1, p2, k3"));
            }
            distortion = std::array::from_fn(|k| own.get(k).copied().unwrap_or(0.0));
        }
        let size = self.size.or(known.and_then(|known| known.size));
        let size = size.unwrap_or([2.0 * intrinsics[2], 2.0 * intrinsics[3]]);
        let range = self.distance_mm.map(|v| 1e-3 * v);
        let numbers = intrinsics.iter().chain(&distortion).chain(&place.translation.vector);
        if numbers.chain(place.rotation.coords.iter()).any(|value| !value.is_finite()) {
            return Err(self.wrong("one of its numbers is not finite"));
        }
        if intrinsics[0] <= 0.0 || intrinsics[1] <= 0.0 || size[0] <= 0.0 || size[1] <= 0.0 {
            return Err(self.wrong("focal lengths and the size of the image have to be above zero, px"));
        }
        if !(range[0] > 0.0 && range[1] >= range[0] && range[1].is_finite()) {
            return Err(self.wrong("`distance_mm` is the nearest distance, above zero, and the farthest"));
        }
        if carried && points.is_empty() {
            return Err(self.wrong("it is on the robot and has no point of known place to look at"));
        }
        let facing = self.normal.map(|normal| (Vector3::from(normal), self.within_deg.to_radians()));
        Ok(What::Camera(Camera { place, carried, intrinsics, distortion, size, points, range, facing }))
    }

    pub(super) fn wrong(&self, why: &str) -> SimulateError {
        SimulateError::Thing { name: self.name.clone(), why: why.into() }
    }
}
