//! One thing of the cell: what it is, and what it reads of a point.
//!
//! ```text
//! wire    g ‖p − a‖ + o          gauge   g d·(p − z) + o         series  Rᵀ (p − t)
//! plate   n·(p − x) = b cos(π u/U) cos(π v/V)                    ball    ‖p − c‖ = R
//! ```
//!
//! | symbol | here | unit | frame |
//! | --- | --- | --- | --- |
//! | p | the target | m | measurement |
//! | g, o | `gain`, `offset` | 1, m | |
//! | b, U, V | `bow`, `size`: a plate that stands higher in its middle than at its edges | m | |
//! | u, v | along two directions across n | m | plate |

use super::camera::Camera;
use super::direction::across;
use nalgebra::{Isometry3, Translation3, Unit, UnitQuaternion, Vector3};
use truepose_kinematics::TargetId;

/// A thing that the robot touches or that observes it.
#[derive(Debug, Clone, PartialEq)]
pub struct Thing {
    /// The number of its landmark.
    pub number: usize,
    /// What it is.
    pub what: What,
    /// Standard deviation of an observation with it: where things touch, of a number, m; of a pixel, px.
    pub sd: f64,
    /// Targets that are observed with it, one after the other (by a camera in the cell: all at once).
    pub targets: Vec<Option<TargetId>>,
    /// How it moves during the campaign.
    pub moves: Option<Move>,
}

/// A jump.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Move {
    /// When, s.
    pub when: f64,
    /// Translation, m, and rotation vector about the thing's own point, rad: measurement frame, of a camera on the robot tool axes.
    pub by: [f64; 6],
}

/// What a thing is.
#[derive(Debug, Clone, PartialEq)]
pub enum What {
    /// A socket or a cone that holds a target, m, measurement frame.
    Socket(Vector3<f64>),
    /// A draw wire, a ball bar, a laser radar.
    Wire(Wire),
    /// A plate that is probed.
    Plate(Plate),
    /// A ball that is probed.
    Ball(Ball),
    /// A dial gauge, a laser along one axis.
    Gauge(Gauge),
    /// An instrument whose frame nobody knows, in the measurement frame.
    Series(Isometry3<f64>),
    /// A camera.
    Camera(Camera),
}

/// An instrument that measures the distance to an anchor.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Wire {
    /// a, m, measurement frame.
    pub anchor: Vector3<f64>,
    /// g.
    pub gain: f64,
    /// o, m.
    pub offset: f64,
}

/// A rectangular plate.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Plate {
    /// x, its middle, m, measurement frame.
    pub middle: Vector3<f64>,
    /// n.
    pub normal: Unit<Vector3<f64>>,
    /// U and V: the part that is probed, m.
    pub size: [f64; 2],
    /// b, m; zero: it is flat.
    pub bow: f64,
}

/// A ball.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ball {
    /// c, m, measurement frame.
    pub centre: Vector3<f64>,
    /// R, from its centre to the target, m.
    pub radius: f64,
    /// The middle of the part that is probed, as a direction, and the largest angle to it, rad; none: the upper half.
    pub facing: Option<(Vector3<f64>, f64)>,
}

/// An instrument that measures along a direction.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Gauge {
    /// z, m, measurement frame.
    pub zero: Vector3<f64>,
    /// d.
    pub direction: Unit<Vector3<f64>>,
    /// g.
    pub gain: f64,
    /// o, m.
    pub offset: f64,
    /// What it can measure, m: the target is brought in front of it; none: it measures anywhere.
    pub travel: Option<f64>,
}

impl Plate {
    /// A point of its surface, by its place across the normal, m.
    pub(super) fn surface(&self, [u, v]: [f64; 2]) -> Vector3<f64> {
        let [first, second] = across(&self.normal);
        let wave = |along: f64, size: f64| (std::f64::consts::PI * along / size).cos();
        let height = self.bow * wave(u, self.size[0]) * wave(v, self.size[1]);
        self.middle + first * u + second * v + self.normal.into_inner() * height
    }
}

impl Thing {
    /// The word of the rows' kind; none of a socket.
    pub fn kind(&self) -> Option<&'static str> {
        Some(match self.what {
            What::Socket(_) => return None,
            What::Wire(_) => "distance",
            What::Plate(_) => "plane",
            What::Ball(_) => "sphere",
            What::Gauge(_) => "linear",
            What::Series(_) => "relative",
            What::Camera(_) => "pixel",
        })
    }

    /// How many numbers a row measures; zero of what is touched.
    pub fn numbers(&self) -> usize {
        match self.what {
            What::Socket(_) | What::Plate(_) | What::Ball(_) => 0,
            What::Wire(_) | What::Gauge(_) => 1,
            What::Camera(_) => 2,
            What::Series(_) => 3,
        }
    }

    /// It as it is at a time, s.
    pub fn what_at(&self, time: f64) -> What {
        let Some(Move { by, .. }) = self.moves.filter(|moves| time >= moves.when) else {
            return self.what.clone();
        };
        let shift = Vector3::new(by[0], by[1], by[2]);
        let turn = UnitQuaternion::from_scaled_axis(Vector3::new(by[3], by[4], by[5]));
        let turned = |direction: Unit<Vector3<f64>>| Unit::new_normalize(turn * direction.into_inner());
        let placed = |place: &Isometry3<f64>| {
            Isometry3::from_parts(Translation3::from(place.translation.vector + shift), turn * place.rotation)
        };
        match &self.what {
            What::Socket(at) => What::Socket(at + shift),
            What::Wire(wire) => What::Wire(Wire { anchor: wire.anchor + shift, ..*wire }),
            What::Plate(plate) => {
                What::Plate(Plate { middle: plate.middle + shift, normal: turned(plate.normal), ..*plate })
            }
            What::Ball(ball) => What::Ball(Ball { centre: ball.centre + shift, ..*ball }),
            What::Gauge(gauge) => {
                What::Gauge(Gauge { zero: gauge.zero + shift, direction: turned(gauge.direction), ..*gauge })
            }
            What::Series(place) => What::Series(placed(place)),
            What::Camera(camera) => What::Camera(Camera { place: placed(&camera.place), ..camera.clone() }),
        }
    }
}

impl What {
    /// What is read of a target here, m or px, without noise; zeros of what is touched, none where it is not seen.
    pub fn reading(&self, at: &Vector3<f64>) -> Option<[f64; 3]> {
        Some(match self {
            What::Socket(_) | What::Plate(_) | What::Ball(_) => [0.0; 3],
            What::Wire(wire) => [wire.gain * (at - wire.anchor).norm() + wire.offset, 0.0, 0.0],
            What::Gauge(gauge) => {
                [gauge.gain * gauge.direction.dot(&(at - gauge.zero)) + gauge.offset, 0.0, 0.0]
            }
            What::Series(place) => place.inverse_transform_vector(&(at - place.translation.vector)).into(),
            What::Camera(camera) => {
                let own = camera.place.inverse_transform_vector(&(at - camera.place.translation.vector));
                let [u, v] = camera.pixel(&own)?;
                [u, v, 0.0]
            }
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn thing(what: What, moves: Option<Move>) -> Thing {
        Thing { number: 0, what, sd: 0.0, targets: vec![None], moves }
    }

    #[test]
    fn each_thing_reads_what_it_is_for() {
        let at = Vector3::new(0.3, 0.4, 0.0);
        let read = |what: What| what.reading(&at).expect("a reading")[0];
        let wire = Wire { anchor: Vector3::zeros(), gain: 1.01, offset: 0.002 };
        assert!((read(What::Wire(wire)) - (1.01 * 0.5 + 0.002)).abs() < 1e-15);
        let gauge = Gauge {
            zero: Vector3::new(0.1, 0.0, 0.0),
            direction: Vector3::y_axis(),
            gain: 2.0,
            offset: -0.1,
            travel: None,
        };
        assert!((read(What::Gauge(gauge)) - 0.7).abs() < 1e-15);
        let quarter = Vector3::z() * std::f64::consts::FRAC_PI_2;
        let place = Isometry3::new(Vector3::new(0.1, 0.0, 0.0), quarter);
        let seen = What::Series(place).reading(&at).expect("a reading");
        assert!((Vector3::from(seen) - Vector3::new(0.4, -0.2, 0.0)).norm() < 1e-15);
    }

    #[test]
    fn a_bow_stands_in_the_middle_of_a_plate_and_not_at_its_edges() {
        let plate =
            Plate { middle: Vector3::zeros(), normal: Vector3::z_axis(), size: [0.6, 0.4], bow: 3e-4 };
        assert!((plate.surface([0.0, 0.0]).z - 3e-4).abs() < 1e-18);
        assert!(plate.surface([0.3, 0.1]).z.abs() < 1e-18);
    }

    #[test]
    fn a_thing_moves_once_and_turns_about_its_own_point() {
        let by = [1e-3, 0.0, 0.0, 0.0, 0.01, 0.0];
        let plate = Plate { middle: Vector3::x(), normal: Vector3::z_axis(), size: [1.0, 1.0], bow: 0.0 };
        let table = thing(What::Plate(plate), Some(Move { when: 60.0, by }));
        assert_eq!(table.what_at(59.9), table.what);
        let What::Plate(moved) = table.what_at(60.0) else { panic!("a plate") };
        assert!((moved.middle.x - 1.001).abs() < 1e-15 && (moved.normal.x - 0.01f64.sin()).abs() < 1e-15);
    }
}
