//! Frames through three points.

use super::options::Touched;
use truepose_kinematics::Pose;
use truepose_kinematics::nalgebra::{Matrix3, Vector3};

/// Points that are nearer to each other than this make no axis, m.
const APART: f64 = 5e-3;

/// The place of a point in the three-point method.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Role {
    Origin,
    /// On the x axis, at positive x, or (ABB) anywhere.
    X(bool),
    /// In the half plane of positive y, or (ABB) on the y axis.
    Y(bool),
}

impl Role {
    /// How far a point in the frame is from where it has to be.
    pub(super) fn off(self, at: &Vector3<f64>) -> f64 {
        match self {
            Role::Origin => at.norm(),
            Role::X(positive) => at.y.hypot(at.z).max(if positive { -at.x } else { 0.0 }),
            Role::Y(axis) => at.z.abs().max(-at.y).max(if axis { at.x.abs() } else { 0.0 }),
        }
    }

    pub(super) fn words(self) -> &'static str {
        match self {
            Role::Origin => "(its origin)",
            Role::X(_) => "(on its x axis)",
            Role::Y(false) => "(in its x-y plane)",
            Role::Y(true) => "(on its y axis)",
        }
    }
}

/// How three points make a frame: their places in the list.
#[derive(Debug, Clone)]
pub(super) enum Method {
    Corner([usize; 3]),
    /// ABB: two on the x axis, one on the y axis.
    Axes([usize; 3]),
}

impl Method {
    pub(super) fn of(touched: &[Touched]) -> Result<Method, String> {
        if touched.len() != 3 {
            return Err(format!(
                "three points make a frame (origin, x, xy), and {} are there",
                touched.len()
            ));
        }
        let find = |word: &str| touched.iter().position(|point| point.word.eq_ignore_ascii_case(word));
        let all = |words: [&str; 3]| Some([find(words[0])?, find(words[1])?, find(words[2])?]);
        if touched.iter().all(|point| point.word.is_empty()) {
            return Ok(Method::Corner([0, 1, 2]));
        }
        if let Some(order) = all(["origin", "x", "xy"]) {
            return Ok(Method::Corner(order));
        }
        all(["x1", "x2", "y1"]).map(Method::Axes).ok_or_else(|| {
            let words: Vec<&str> = touched.iter().map(|point| point.word.as_str()).collect();
            format!("its points are called {}; known are origin, x, xy and x1, x2, y1", words.join(", "))
        })
    }

    pub(super) fn roles(&self) -> [(Role, usize); 3] {
        match *self {
            Method::Corner([o, x, xy]) => [(Role::Origin, o), (Role::X(true), x), (Role::Y(false), xy)],
            Method::Axes([a, b, y]) => [(Role::X(false), a), (Role::X(false), b), (Role::Y(true), y)],
        }
    }

    pub(super) fn frame(&self, points: &[Vector3<f64>]) -> Result<Pose, String> {
        let (Method::Corner(order) | Method::Axes(order)) = *self;
        let [first, second, third] = order.map(|k| points[k]);
        let x = second - first;
        let along = x.normalize();
        let origin = match self {
            Method::Corner(_) => first,
            Method::Axes(_) => first + along * along.dot(&(third - first)),
        };
        let y = third - origin - along * along.dot(&(third - origin));
        if !(x.norm() > APART && y.norm() > APART) {
            return Err("its points are at one place or on one line".into());
        }
        let y = y.normalize();
        Ok(Pose::new(Matrix3::from_columns(&[along, y, along.cross(&y)]), origin))
    }
}
