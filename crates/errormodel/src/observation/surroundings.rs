//! What a robot description says beside the robot: what it touches and is observed by, and what is known of that.

use super::seam::Observation;
use nalgebra::Vector3;

/// A point of the surroundings that the robot touched, or a sensor or thing of which its rows measured numbers.
#[derive(Debug, Clone, Default)]
pub struct Landmark {
    /// Its name.
    pub name: String,
    /// Where it is, m, measurement frame; none where nobody knows.
    pub position: Option<Vector3<f64>>,
    /// Whether that is exact: then its rows are measured positions.
    pub known: bool,
    /// How it was observed, with what is known of it; none of a point that was touched.
    pub observed: Option<Box<dyn Observation>>,
    /// What of the robot carries it: `tool`, the name of a tool or of a joint; none of what stands in the surroundings.
    pub mount: Option<String>,
    /// Standard deviation of such an observation where it is stated, in its unit; none: found from the data.
    pub sd: Option<f64>,
}

/// A distance between two landmarks that was measured otherwise.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct KnownDistance {
    /// Which landmarks, by number.
    pub between: [usize; 2],
    /// m.
    pub value: f64,
    /// Its standard deviation, m; zero where it is exact.
    pub sd: f64,
}

/// What a robot file says about its surroundings.
#[derive(Debug, Clone, Default)]
pub struct Surroundings {
    /// The landmarks.
    pub landmarks: Vec<Landmark>,
    /// Distances between them.
    pub distances: Vec<KnownDistance>,
    /// Whether the landmarks are not listed, so that the data may name further ones.
    pub open: bool,
}
