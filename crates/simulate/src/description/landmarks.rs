//! Landmarks as they are: sockets, plates, balls, wires, gauges and series of a relative instrument.

use crate::SimulateError;
use crate::cell::{Ball, Gauge, Move, Plate, What, Wire};
use nalgebra::{Isometry3, Translation3, Unit, UnitQuaternion, Vector3};
use serde::{Deserialize, Serialize};
use std::any::Any;
use truepose_errormodel::Landmark;
use truepose_errormodel::observation::{Distance, Linear, Observation, Plane, Sphere};

/// What a landmark is, in the words of a robot description.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum LandmarkKind {
    /// What holds a target at one point.
    #[serde(alias = "point", alias = "cone")]
    Socket,
    /// A wire, a bar, the range of a laser radar.
    #[serde(alias = "anchor")]
    Distance,
    /// A plate that is probed.
    Plane,
    /// A ball that is probed.
    Sphere,
    /// What measures along a direction.
    Linear,
    /// Positions in a frame of their own.
    Relative,
}

/// A landmark. What is left out is as the robot description has it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct LandmarkDescription {
    /// Its name in the robot description.
    pub name: String,
    /// What it is, where the robot description does not state it; else a socket.
    pub kind: Option<LandmarkKind>,
    /// How many pose measurements are made with it.
    pub rows: usize,
    /// Where it is: the socket, the anchor, the middle of a plate or ball, where a gauge reads its offset, the origin of a series; mm, measurement frame.
    pub xyz_mm: Option<[f64; 3]>,
    /// Turn of a series' frame about the fixed axes x, y, z, deg.
    pub rpy_deg: [f64; 3],
    /// Normal of a plate, direction of a gauge; the middle of the side of a ball that is probed (default: against gravity).
    pub normal: Option<[f64; 3]>,
    /// Largest angle between `normal` and a point of a ball, deg.
    pub within_deg: f64,
    /// From a ball's centre to the target, mm.
    pub radius_mm: Option<f64>,
    /// True gain of a wire or gauge.
    pub gain: Option<f64>,
    /// True offset of a wire or gauge, mm.
    pub offset_mm: Option<f64>,
    /// The part of a plate that is probed, mm.
    pub size_mm: [f64; 2],
    /// How much a plate stands higher in the middle of that part than at its edges, mm.
    pub bow_mm: f64,
    /// What a gauge can measure, mm: the target is brought in front of it. Left out: it measures anywhere.
    pub travel_mm: Option<f64>,
    /// Standard deviation of an observation: where a target comes to rest in the socket or on the surface, of a number; µm.
    pub sd_um: f64,
    /// Targets that are observed with it, in turn; empty: all that the robot has, or its tool's origin.
    pub targets: Vec<String>,
    /// A jump during the campaign.
    pub moved: Option<MoveDescription>,
}

/// A jump.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct MoveDescription {
    /// When, s.
    pub when_s: f64,
    /// Translation, mm: measurement frame; of a camera on the robot, tool axes.
    pub xyz_mm: [f64; 3],
    /// Rotation vector about the thing's own point, mrad.
    pub turn_mrad: [f64; 3],
}

impl Default for LandmarkDescription {
    fn default() -> Self {
        LandmarkDescription {
            name: String::new(),
            kind: None,
            rows: 0,
            xyz_mm: None,
            rpy_deg: [0.0; 3],
            normal: None,
            within_deg: 90.0,
            radius_mm: None,
            gain: None,
            offset_mm: None,
            size_mm: [500.0; 2],
            bow_mm: 0.0,
            travel_mm: None,
            sd_um: 0.0,
            targets: Vec::new(),
            moved: None,
        }
    }
}

impl MoveDescription {
    pub(super) fn on(&self) -> Move {
        let [x, y, z] = self.xyz_mm.map(|v| 1e-3 * v);
        let [a, b, c] = self.turn_mrad.map(|v| 1e-3 * v);
        Move { when: self.when_s, by: [x, y, z, a, b, c] }
    }
}

/// A transform of millimetres and degrees about fixed axes.
pub(super) fn placed(xyz_mm: [f64; 3], rpy_deg: [f64; 3]) -> Isometry3<f64> {
    let [roll, pitch, yaw] = rpy_deg.map(f64::to_radians);
    let shift = Translation3::from(Vector3::from(xyz_mm) * 1e-3);
    Isometry3::from_parts(shift, UnitQuaternion::from_euler_angles(roll, pitch, yaw))
}

/// What a robot description knows of an observation of some type.
pub(super) fn described_as<T: 'static>(described: Option<&Landmark>) -> Option<&T> {
    let observed: &dyn Observation = described?.observed.as_deref()?;
    (observed as &dyn Any).downcast_ref()
}

impl LandmarkDescription {
    /// What it really is.
    pub(super) fn what(&self, described: Option<&Landmark>) -> Result<What, SimulateError> {
        self.checked()?;
        let position = || {
            let own = self.xyz_mm.map(|xyz| Vector3::from(xyz) * 1e-3);
            let known = described.and_then(|described| described.position);
            own.or(known)
                .ok_or_else(|| self.wrong("its place is neither here (`xyz_mm`) nor in the robot's file"))
        };
        let normal = |known: Option<Vector3<f64>>| {
            let own = self.normal.map(Vector3::from).or(known);
            let own = own.ok_or_else(|| self.wrong("neither this file nor the robot's has its `normal`"))?;
            Unit::try_new(own, 1e-9).ok_or_else(|| self.wrong("its `normal` has no length"))
        };
        let (gain, offset) = (self.gain, self.offset_mm.map(|v| 1e-3 * v));
        Ok(match self.kind.unwrap_or_else(|| kind(described)) {
            LandmarkKind::Socket => What::Socket(position()?),
            LandmarkKind::Distance => {
                let known = described_as::<Distance>(described);
                What::Wire(Wire {
                    anchor: position()?,
                    gain: gain.or(known.map(|known| known.gain)).unwrap_or(1.0),
                    offset: offset.or(known.map(|known| known.offset)).unwrap_or(0.0),
                })
            }
            LandmarkKind::Plane => What::Plate(Plate {
                middle: position()?,
                normal: normal(described_as::<Plane>(described).and_then(|known| known.normal))?,
                size: self.size_mm.map(|v| 1e-3 * v),
                bow: 1e-3 * self.bow_mm,
            }),
            LandmarkKind::Sphere => {
                let known = described_as::<Sphere>(described).and_then(|known| known.radius);
                let radius = self.radius_mm.map(|v| 1e-3 * v).or(known);
                let facing = self.normal.map(|normal| (Vector3::from(normal), self.within_deg.to_radians()));
                What::Ball(Ball {
                    centre: position()?,
                    radius: radius.ok_or_else(|| self.wrong("it has no `radius_mm`"))?,
                    facing,
                })
            }
            LandmarkKind::Linear => {
                let known = described_as::<Linear>(described);
                What::Gauge(Gauge {
                    zero: position().unwrap_or_default(),
                    direction: normal(known.and_then(|known| known.direction))?,
                    gain: gain.or(known.map(|known| known.gain)).unwrap_or(1.0),
                    offset: offset.or(known.map(|known| known.offset)).unwrap_or(0.0),
                    travel: self.travel_mm.map(|v| 1e-3 * v),
                })
            }
            LandmarkKind::Relative => What::Series(placed(self.xyz_mm.unwrap_or_default(), self.rpy_deg)),
        })
    }

    fn checked(&self) -> Result<(), SimulateError> {
        let positive = [
            ("radius_mm", self.radius_mm),
            ("travel_mm", self.travel_mm),
            ("size_mm", Some(self.size_mm[0])),
            ("size_mm", Some(self.size_mm[1])),
        ];
        let wrong = |value: f64| !(value > 0.0 && value.is_finite());
        if let Some((key, _)) = positive.iter().find(|(_, value)| value.is_some_and(wrong)) {
            return Err(self.wrong(&format!("`{key}` has to be above zero")));
        }
        let numbers = [self.xyz_mm, self.normal].into_iter().flatten().flatten();
        let numbers = numbers.chain(self.rpy_deg).chain(self.gain).chain(self.offset_mm);
        if numbers.chain([self.bow_mm, self.within_deg]).any(|value| !value.is_finite()) {
            return Err(self.wrong("one of its numbers is not finite"));
        }
        Ok(())
    }

    fn wrong(&self, why: &str) -> SimulateError {
        SimulateError::Thing { name: self.name.clone(), why: why.into() }
    }
}

/// What a landmark is in a robot description.
fn kind(described: Option<&Landmark>) -> LandmarkKind {
    match described.and_then(|described| described.observed.as_ref()).map(|observed| observed.kind()) {
        Some("distance") => LandmarkKind::Distance,
        Some("plane") => LandmarkKind::Plane,
        Some("sphere") => LandmarkKind::Sphere,
        Some("linear") => LandmarkKind::Linear,
        Some("relative") => LandmarkKind::Relative,
        _ => LandmarkKind::Socket,
    }
}
