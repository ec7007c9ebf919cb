//! The seam through which kinds of observation enter: what a sensor reads, and how that depends on the robot and on the sensor's unknowns.
//!
//! ```text
//! z = h(T, s) + noise        r = z − h        dr = −( H dξ + K ds )
//! ```
//!
//! | symbol | here | shape | unit | frame |
//! | --- | --- | --- | --- | --- |
//! | T | pose of the tool at the measured target | pose | m | measurement |
//! | dξ | the target moves by (dx, dy, dz), the tool turns about it by (φx, φy, φz) | 6 | m, rad | measurement |
//! | z, h | measured and predicted numbers | k = 1 to 3 | [`Observation::unit`] | |
//! | H | [`Reading::by_pose`] | k × 6 | per m, per rad | measurement |
//! | K | [`Reading::by_own`] | k × dim s | per unit of each unknown | |
//!
//! A pose and a position are observations with H = 1; they have their own, faster way through a fit. All others become rows along a direction
//! ([`crate::Ray`]): effects do not know how the robot was observed. GTSAM's factors and Ceres' residual blocks have the same form.

mod camera;
mod distance;
mod linear;
mod plane;
mod relative;
mod seam;
mod sphere;
mod start;
mod surroundings;

pub use camera::Camera;
pub use distance::Distance;
pub use linear::Linear;
pub use plane::Plane;
pub use relative::Relative;
pub use seam::{Observation, Reading, Seen};
pub use sphere::Sphere;
pub use surroundings::{KnownDistance, Landmark, Surroundings};

use nalgebra::Vector3;

/// Word of the rows in which two points of the robot met.
pub const FRAMES: &str = "frames";

/// Words of the kinds whose rows measure something else than a place or that a point was touched.
pub const KINDS: [&str; 7] =
    [Distance::KIND, Plane::KIND, Sphere::KIND, Linear::KIND, Camera::KIND, Relative::KIND, FRAMES];

/// A thing that is observed in this kind, by its place in [`KINDS`], of which nothing is known but, maybe, a point (exactly, where `known`).
pub fn unknown(kind: usize, position: Option<Vector3<f64>>, known: bool) -> Option<Box<dyn Observation>> {
    Some(match *KINDS.get(kind)? {
        Distance::KIND => Box::new(Distance { anchor: position, known, ..Distance::default() }),
        Plane::KIND => Box::new(Plane::default()),
        Sphere::KIND => Box::new(Sphere { centre: position, known, radius: None, free_radius: true }),
        Linear::KIND => Box::new(Linear::default()),
        Relative::KIND => Box::new(Relative::default()),
        // A camera is nothing without its focal length; where two points meet is no thing.
        _ => return None,
    })
}
