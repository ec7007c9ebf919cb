//! A target on a plane: a touch probe on a table, a wall, a surface plate.
//!
//! ```text
//! 0 = h = n·(p − x₀)        ∂h/∂p = n,  ∂h/∂τ_k = e_k·(p − x₀),  ∂h/∂s = −1,      n ← n + τ₁ e₁ + τ₂ e₂,  x₀ ← x₀ + s n
//! ```

use super::seam::{OFF, Observation, Reading, Seen, TURNED, across, shown, shown_direction, taken};
use super::start::{centre, descended, thinnest};
use crate::Column;
use nalgebra::Vector3;
use truepose_kinematics::Pose;

/// A plane.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Plane {
    /// n, a unit vector in the measurement frame; none: found from the data.
    pub normal: Option<Vector3<f64>>,
    /// x₀, a point of it, m, measurement frame; none: found from the data.
    pub point: Option<Vector3<f64>>,
    /// Whether both are exact.
    pub known: bool,
}

impl Plane {
    /// Its word.
    pub const KIND: &'static str = "plane";

    fn normal(&self) -> Vector3<f64> {
        self.normal.unwrap_or_else(Vector3::z)
    }

    fn point(&self) -> Vector3<f64> {
        self.point.unwrap_or_default()
    }
}

impl Observation for Plane {
    fn kind(&self) -> &'static str {
        Self::KIND
    }

    fn unknowns(&self, name: &str, length: f64) -> Vec<Column> {
        if self.known {
            return Vec::new();
        }
        let tilt = |k: usize| Column::new(format!("tilt {k} of {name}"), "rad", TURNED);
        vec![tilt(1), tilt(2), Column::new(format!("height of {name}"), "m", OFF * length)]
    }

    fn read(&self, at: &Pose, out: &mut Reading) -> bool {
        let (n, away) = (self.normal(), at.translation - self.point());
        let own = (!self.known).then(|| {
            let [first, second] = across(&n);
            [first.dot(&away), second.dot(&away), -1.0]
        });
        out.one(n.dot(&away), n, own.into_iter().flatten());
        true
    }

    fn moved(&self, by: &[f64]) -> Box<dyn Observation> {
        let n = self.normal();
        let [first, second] = across(&n);
        match *by {
            [a, b, shift] if !self.known => Box::new(Plane {
                normal: Some((n + first * a + second * b).normalize()),
                point: Some(self.point() + n * shift),
                known: false,
            }),
            _ => self.boxed(),
        }
    }

    fn started(&self, seen: &[Seen]) -> Result<Box<dyn Observation>, String> {
        if self.known {
            return Ok(self.boxed());
        }
        let (thin, spread) = thinnest(seen);
        if self.normal.is_none() && (seen.len() < 3 || spread[1] < 1e-2 * spread[0].max(1e-6)) {
            return Err(
                "its points lie on a line, which does not determine a plane: probe more points across it"
                    .into(),
            );
        }
        let hint = self.normal.unwrap_or_else(|| Vector3::new(0.1, 0.2, 1.0));
        let normal = self.normal.unwrap_or(if thin.dot(&hint) < 0.0 { -thin } else { thin });
        Ok(descended(&Plane { normal: Some(normal), point: Some(centre(seen)), known: false }, seen))
    }

    fn placed(&self) -> bool {
        self.normal.is_some() && self.point.is_some()
    }

    fn values(&self) -> Vec<(&'static str, f64, &'static str)> {
        let mut all = shown_direction(self.normal()).to_vec();
        all.extend(shown(self.point()));
        all
    }

    fn freed(&self) -> Vec<(&'static str, Box<dyn Observation>)> {
        // A bend lifts and tilts a table that is said to be known: nobody states of which of its points that is true.
        let place = Plane { known: false, ..self.clone() };
        let bent = Warped(place.clone());
        taken([(self.known, "place", Box::new(place)), (true, "flatness", Box::new(bent))])
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

/// A flat plane that may have a bend: `h = n·(p − x₀) − (a u² + b u v + c v²)`, u and v along e₁ and e₂; a, b, c (1/m) are unknowns behind its own.
#[derive(Debug, Clone)]
struct Warped(Plane);

/// Expected size of a bend, 1/m: 0.25 mm at half a metre.
const BEND: f64 = 1e-3;

impl Observation for Warped {
    fn kind(&self) -> &'static str {
        Plane::KIND
    }

    fn unknowns(&self, name: &str, length: f64) -> Vec<Column> {
        let bend = |k: usize| Column::new(format!("bend {k} of {name}"), "1/m", BEND);
        let mut all = self.0.unknowns(name, length);
        all.extend((1..=3).map(bend));
        all
    }

    fn read(&self, at: &Pose, out: &mut Reading) -> bool {
        let seen = self.0.read(at, out);
        let [u, v] = across(&self.0.normal()).map(|e| e.dot(&(at.translation - self.0.point())));
        out.by_own[0].extend([-u * u, -u * v, -v * v]);
        seen
    }

    /// The plane moves; it stays flat.
    fn moved(&self, by: &[f64]) -> Box<dyn Observation> {
        self.0.moved(&by[..by.len().saturating_sub(3)])
    }

    fn boxed(&self) -> Box<dyn Observation> {
        Box::new(self.clone())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testkit::{check_observation, scattered};

    #[test]
    fn conforms() {
        let tilted = Vector3::new(0.3, -0.2, 0.9).normalize();
        let plane = Plane { normal: Some(tilted), point: Some(Vector3::new(0.2, 0.1, 0.4)), known: false };
        check_observation(&plane);
        check_observation(&Plane { known: true, ..plane });
    }

    #[test]
    fn a_plane_is_found_from_nothing() {
        let n = Vector3::new(0.2, 0.1, -0.9).normalize();
        let flat = |mut at: Pose| -> Seen {
            at.translation -= n * (n.dot(&at.translation) - 0.3);
            (at, vec![0.0])
        };
        let seen: Vec<Seen> = scattered(12).into_iter().map(flat).collect();
        let found = Plane::default().started(&seen).unwrap();
        let mut reading = Reading::default();
        for (at, _) in &seen {
            assert!(found.read(at, &mut reading) && reading.value[0].abs() < 1e-12);
        }
        let line: Vec<Seen> = (0..9).map(|k| (Pose::trans(0, 0.1 * f64::from(k)), vec![0.0])).collect();
        assert!(Plane::default().started(&line).unwrap_err().contains("on a line"));
    }

    #[test]
    fn a_bend_is_seen_where_a_point_is_above_the_plane() {
        let plane = Plane { normal: Some(Vector3::z()), point: Some(Vector3::zeros()), known: false };
        let (mut flat, mut bent) = (Reading::default(), Reading::default());
        let at = Pose::from_xyz_rpy([0.3, -0.2, 0.1], [0.0; 3]);
        assert!(plane.read(&at, &mut flat) && plane.freed()[0].1.read(&at, &mut bent));
        assert_eq!(bent.by_own[0][..3], flat.by_own[0][..]);
        // Whatever the axes across: u² + v² is the distance from the middle.
        assert!((bent.by_own[0][3] + bent.by_own[0][5] + 0.13).abs() < 1e-12, "{bent:?}");
        assert_eq!(bent.value, flat.value);
    }
}
