//! Landmarks whose place is unknown: points of the surroundings that a target touched again and again.
//!
//! ```text
//! l_k = l⁰_k + δ_k                     δ_k free                              a landmark of its own
//! l_k = l_j + d u(τ),  |u| = 1          u ≈ u⁰ + τ_1 e_1 + τ_2 e_2            one at distance d, known or held, from landmark j
//! 0 = l_k − p                          what a row says; p the touching target
//! ```
//!
//! | symbol | here | unit |
//! | --- | --- | --- |
//! | l⁰_k | the measured position of the rows, measurement frame | m |
//! | δ_k | unknown: three components in the axes of the measurement frame | m |
//! | u⁰, e_1, e_2 | `direction`, and two directions across it | 1 |
//! | τ | unknown: two angles | rad |
//! | k | the channel [`LANDMARK`](crate::LANDMARK), from one; zero: no landmark | |
//!
//! To a row it makes no difference whether the landmark moves or the whole robot moves the other way, so that this is emitted at the base.
//! Source of the kind of measurement: Hollerbach and Wampler (1996), closed-loop calibration with a point contact.

use super::checks::refused;
use crate::{Column, Effect, Emission, LANDMARK, ModelError, Signal};
use nalgebra::Vector3;
use serde::{Deserialize, Serialize};
use truepose_kinematics::{Axis, Chain, FrameId, Posture, Site};

/// A landmark of unknown place.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Point {
    /// Its name.
    pub name: String,
    /// Where it is relative to an earlier one, where the distance is known.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub tied: Option<Tied>,
}

/// At a known distance from an earlier landmark, or at that of the nominal robot.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Tied {
    /// The other landmark, by its number from zero.
    pub to: usize,
    /// From there to here, a unit vector in the measurement frame.
    pub direction: [f64; 3],
    /// m.
    pub distance: f64,
    /// Whether nobody knows the distance, and nothing else holds the scale: it is then that of the nominal robot.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub held: bool,
}

impl Tied {
    /// Two unit vectors across the direction.
    pub fn across(&self) -> [Vector3<f64>; 2] {
        let along = Vector3::from(self.direction);
        let first = along.cross(&Vector3::ith(along.iamin(), 1.0)).normalize();
        [first, along.cross(&first)]
    }
}

/// Landmarks of unknown place.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Landmarks {
    /// In the order of their numbers.
    pub points: Vec<Point>,
}

/// A landmark is taken to be where the nominal robot touches it: expected to be off by this share of the arm's length.
const OFF: f64 = 1e-2;
/// The direction between two landmarks is that between two such places.
const TURNED: f64 = 0.1;

impl Landmarks {
    /// Whether a distance that nobody knows holds the scale.
    pub fn hold_scale(&self) -> bool {
        self.points.iter().any(|point| point.tied.is_some_and(|tied| tied.held))
    }

    /// Holds the scale by the distance between those of these landmarks that are farthest apart; `at`: places, m, measurement frame. Which ones;
    /// none of fewer than two places.
    pub fn held_between(&mut self, of: &[usize], at: &[Vector3<f64>]) -> Option<[usize; 2]> {
        self.points.iter_mut().for_each(|point| point.tied = point.tied.filter(|tied| !tied.held));
        let pairs = of.iter().flat_map(|&j| of.iter().filter(move |&&k| k > j).map(move |&k| [j, k]));
        let apart = |[j, k]: &[usize; 2]| (at[*k] - at[*j]).norm();
        let [to, k] = pairs.max_by(|a, b| apart(a).total_cmp(&apart(b)))?;
        let way = at[k] - at[to];
        let direction = way.try_normalize(1e-9)?.into();
        self.points[k].tied = Some(Tied { to, direction, distance: way.norm(), held: true });
        Some([to, k])
    }

    /// Where the coefficients of each landmark begin.
    fn first(&self, point: usize) -> usize {
        self.points[..point].iter().map(|point| if point.tied.is_some() { 2 } else { 3 }).sum()
    }

    /// By how much a landmark is displaced, m, measurement frame.
    pub fn displaced(&self, point: usize, coefficients: &[f64]) -> Vector3<f64> {
        let mut moved = Vector3::zeros();
        self.parts(point, |column, direction| moved += direction * coefficients[column]);
        moved
    }

    /// Calls `each` with every coefficient that moves a landmark, and its displacement for a unit of it, m, measurement frame.
    fn parts(&self, point: usize, mut each: impl FnMut(usize, Vector3<f64>)) {
        let mut at = point;
        // Each is tied to an earlier one.
        loop {
            let first = self.first(at);
            match &self.points[at].tied {
                Some(tied) => {
                    for (k, across) in tied.across().into_iter().enumerate() {
                        each(first + k, across * tied.distance);
                    }
                    at = tied.to;
                }
                None => {
                    for k in 0..3 {
                        each(first + k, Vector3::ith(k, 1.0));
                    }
                    return;
                }
            }
        }
    }
}

impl Effect for Landmarks {
    const FAMILY: &'static str = "landmarks";
    const ABOUT: &'static str =
        "places of landmarks that a target touched; made from the columns `kind` and `landmark`";

    fn load_dependent(&self) -> bool {
        false
    }

    fn columns(&self, chain: &Chain) -> Vec<Column> {
        let place = OFF * chain.characteristic_length();
        let of = |point: &Point| -> Vec<Column> {
            match &point.tied {
                None => ["x", "y", "z"]
                    .map(|axis| Column::new(format!("{axis}@landmark {}", point.name), "m", place))
                    .to_vec(),
                Some(tied) => {
                    let to = self.points.get(tied.to).map_or("?", |other| other.name.as_str());
                    let word = |k: usize| format!("direction {k} of {to} to {}", point.name);
                    [1, 2].map(|k| Column::new(word(k), "rad", TURNED)).to_vec()
                }
            }
        };
        self.points.iter().flat_map(of).collect()
    }

    fn eval(&self, at: &Posture<'_>, out: &mut Emission) {
        // Numbers of landmarks are small and whole.
        let Some(point) = (at.signal(0) as usize).checked_sub(1).filter(|&k| k < self.points.len()) else {
            return;
        };
        let base = at.chain().base().pose.rotation;
        self.parts(point, |column, direction| {
            let own = base.tr_mul(&direction);
            for axis in Axis::TRANSLATIONS {
                let value = -own[axis.direction()];
                if value != 0.0 {
                    out.push(column, Site::Frame(FrameId::BASE, axis), value);
                }
            }
        });
    }

    fn needs(&self) -> Vec<Signal> {
        vec![Signal::Channel(LANDMARK.into())]
    }

    fn validate(&self, _chain: &Chain) -> Result<(), ModelError> {
        for (k, point) in self.points.iter().enumerate() {
            if self.points[..k].iter().any(|other| other.name == point.name) {
                return Err(refused(Self::FAMILY, format!("landmark `{}` stands twice", point.name)));
            }
            let Some(tied) = &point.tied else { continue };
            let unit = (Vector3::from(tied.direction).norm() - 1.0).abs() < 1e-6;
            if tied.to >= k || !unit || !(tied.distance.is_finite() && tied.distance > 0.0) {
                let reason = format!(
                    "landmark `{}` is tied to one before it, by a unit vector and a distance above zero",
                    point.name
                );
                return Err(refused(Self::FAMILY, reason));
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testkit::{check_effect, emitted};
    use truepose_kinematics::{Conditions, samples};

    fn three() -> Landmarks {
        let point = |name: &str, tied: Option<Tied>| Point { name: name.into(), tied };
        let along = Vector3::new(0.6, 0.0, 0.8);
        let tied = Tied { to: 0, direction: along.into(), distance: 0.05, held: false };
        Landmarks { points: vec![point("A", None), point("B", Some(tied)), point("C", None)] }
    }

    #[test]
    fn conforms() {
        for chain in samples::all() {
            check_effect(&three(), &chain);
        }
    }

    #[test]
    fn a_landmark_at_a_known_distance_keeps_it() {
        let effect = three();
        let coefficients = [0.001, -0.002, 0.003, 0.01, -0.02, 0.5, 0.5, 0.5];
        let a = effect.displaced(0, &coefficients);
        assert_eq!(a, Vector3::new(0.001, -0.002, 0.003));
        let b = effect.displaced(1, &coefficients);
        let along = Vector3::new(0.6, 0.0, 0.8);
        assert!((b - a).dot(&along).abs() < 1e-15 && (b - a).norm() > 1e-3);
        let length = (along * 0.05 + b - a).norm();
        // To second order of two angles of a hundredth.
        assert!((length - 0.05).abs() < 0.05 * 3e-4, "{length}");
    }

    #[test]
    fn only_rows_that_touched_it_say_something_about_a_landmark() {
        let chain = samples::ur10();
        let columns = |number: f64| -> Vec<usize> {
            let mut at = Conditions::at(&chain, &[0.3; 6]);
            at.channels = vec![number];
            let mut columns: Vec<usize> =
                emitted(&three(), &chain, &at).iter().map(|entry| entry.column).collect();
            columns.sort_unstable();
            columns.dedup();
            columns
        };
        assert_eq!(columns(0.0), Vec::<usize>::new());
        assert_eq!(columns(1.0), [0, 1, 2]);
        assert_eq!(columns(2.0), [0, 1, 2, 3, 4]);
        assert_eq!(columns(3.0), [5, 6, 7]);
        let mut wrong = three();
        wrong.points[1].tied = Some(Tied { to: 1, direction: [1.0, 0.0, 0.0], distance: 0.1, held: false });
        assert!(Effect::validate(&wrong, &chain).is_err());
    }
}
