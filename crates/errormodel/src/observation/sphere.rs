//! A target on a sphere: a probe on a datum ball, a bar of fixed length about a ball joint.
//!
//! ```text
//! 0 = h = ‖p − c‖ − R        ∂h/∂p = u,  ∂h/∂c = −u,  ∂h/∂R = −1,      u = (p − c)/‖p − c‖
//! ```
//! R is the distance from the ball's centre to the target: of a probe with a tip of its own, the sum of both radii.

use super::seam::{OFF, Observation, Reading, Seen, place, shown, split_place, taken};
use super::start::{centre, descended, solved};
use crate::Column;
use nalgebra::Vector3;
use truepose_kinematics::Pose;

/// A sphere.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Sphere {
    /// c, m, measurement frame; none: found from the data.
    pub centre: Option<Vector3<f64>>,
    /// Whether that is exact.
    pub known: bool,
    /// R, m; none: found from the data.
    pub radius: Option<f64>,
    /// Whether the radius is an unknown.
    pub free_radius: bool,
}

impl Sphere {
    /// Its word.
    pub const KIND: &'static str = "sphere";

    /// Of a known radius, m, somewhere.
    pub fn of_radius(radius: f64) -> Self {
        Sphere { radius: Some(radius), ..Sphere::default() }
    }
}

impl Observation for Sphere {
    fn kind(&self) -> &'static str {
        Self::KIND
    }

    fn unknowns(&self, name: &str, length: f64) -> Vec<Column> {
        let mut all = if self.known { Vec::new() } else { place(name, length) };
        if self.free_radius {
            all.push(Column::new(format!("radius of {name}"), "m", OFF * length));
        }
        all
    }

    fn read(&self, at: &Pose, out: &mut Reading) -> bool {
        let away = at.translation - self.centre.unwrap_or_default();
        let Some(u) = away.try_normalize(1e-9) else { return false };
        let centre = (!self.known).then(|| [-u.x, -u.y, -u.z]).into_iter().flatten();
        let radius = self.free_radius.then_some(-1.0);
        out.one(away.norm() - self.radius.unwrap_or(0.0), u, centre.chain(radius));
        true
    }

    fn moved(&self, by: &[f64]) -> Box<dyn Observation> {
        let (step, rest) = split_place(by, self.known);
        let mut moved = self.clone();
        moved.centre = Some(self.centre.unwrap_or_default() + step);
        if self.free_radius {
            moved.radius = Some(self.radius.unwrap_or(0.0) + rest.first().copied().unwrap_or(0.0));
        }
        Box::new(moved)
    }

    fn started(&self, seen: &[Seen]) -> Result<Box<dyn Observation>, String> {
        if self.centre.is_some() && self.radius.is_some() {
            return Ok(if self.known && !self.free_radius { self.boxed() } else { descended(self, seen) });
        }
        if let Some(c) = self.centre {
            let mean =
                seen.iter().map(|(at, _)| (at.translation - c).norm()).sum::<f64>() / seen.len() as f64;
            return Ok(descended(&Sphere { radius: Some(mean), ..self.clone() }, seen));
        }
        // ‖p‖² = 2 p·c + κ about the middle of the points.
        let middle = centre(seen);
        let off = |at: &Pose| at.translation - middle;
        let rows: Vec<Vec<f64>> = seen
            .iter()
            .map(|(at, _)| {
                let p = off(at);
                vec![2.0 * p.x, 2.0 * p.y, 2.0 * p.z, 1.0]
            })
            .collect();
        let right: Vec<f64> = seen.iter().map(|(at, _)| off(at).norm_squared()).collect();
        let found = solved(&rows, &right)
            .ok_or("its points do not determine a centre: touch it from more sides, or declare its `xyz`")?;
        let c = Vector3::new(found[0], found[1], found[2]);
        let radius = self.radius.unwrap_or_else(|| (found[3] + c.norm_squared()).max(0.0).sqrt());
        Ok(descended(&Sphere { centre: Some(middle + c), radius: Some(radius), ..self.clone() }, seen))
    }

    fn placed(&self) -> bool {
        self.centre.is_some()
    }

    fn values(&self) -> Vec<(&'static str, f64, &'static str)> {
        let mut all = shown(self.centre.unwrap_or_default()).to_vec();
        all.push(("radius", self.radius.unwrap_or(0.0), "m"));
        all
    }

    fn freed(&self) -> Vec<(&'static str, Box<dyn Observation>)> {
        let size = Sphere { free_radius: true, ..self.clone() };
        let place = Sphere { known: false, ..self.clone() };
        taken([(self.known, "place", Box::new(place)), (!self.free_radius, "radius", Box::new(size))])
    }

    fn metric(&self) -> bool {
        !self.free_radius
    }

    fn outside(&self) -> bool {
        self.known
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
        let sphere = Sphere { centre: Some(Vector3::new(2.0, 1.0, -1.0)), ..Sphere::of_radius(1.7) };
        check_observation(&sphere);
        check_observation(&Sphere { free_radius: true, ..sphere.clone() });
        check_observation(&Sphere { known: true, free_radius: true, ..sphere });
    }

    #[test]
    fn a_sphere_is_found_from_nothing() {
        let c = Vector3::new(0.2, -0.4, 0.9);
        let on = |mut at: Pose| -> Seen {
            at.translation = c + at.translation.normalize() * 0.15;
            (at, vec![0.0])
        };
        let seen: Vec<Seen> = scattered(20).into_iter().map(on).collect();
        for start in [Sphere { free_radius: true, ..Sphere::default() }, Sphere::of_radius(0.15)] {
            let found = start.started(&seen).unwrap();
            let mut reading = Reading::default();
            for (at, _) in &seen {
                assert!(found.read(at, &mut reading) && reading.value[0].abs() < 1e-9);
            }
        }
        assert!(Sphere::default().started(&seen[..3]).unwrap_err().contains("do not determine"));
    }
}
