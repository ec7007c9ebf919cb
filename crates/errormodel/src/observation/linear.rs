//! How far a target is along a direction: a dial gauge, a one-axis laser, a linear scale.
//!
//! ```text
//! h = g d·(p − x₀) + o        ∂h/∂p = g d,  ∂h/∂τ_k = g e_k·(p − x₀),  ∂h/∂g = d·(p − x₀),  ∂h/∂o = 1
//! ```
//! x₀ is the middle of the points, so that a turn of the direction and the offset are distinguishable.

use super::seam::{OFF, Observation, Reading, Seen, TURNED, across, shown_direction, taken};
use super::start::{centre, descended, solved};
use crate::Column;
use nalgebra::Vector3;
use truepose_kinematics::Pose;

/// An instrument that measures along a direction.
#[derive(Debug, Clone, PartialEq)]
pub struct Linear {
    /// d, a unit vector in the measurement frame; none: found from the data.
    pub direction: Option<Vector3<f64>>,
    /// Whether that is exact.
    pub known: bool,
    /// x₀, m, measurement frame.
    pub about: Vector3<f64>,
    /// g.
    pub gain: f64,
    /// Whether the gain is an unknown.
    pub free_gain: bool,
    /// o, m.
    pub offset: f64,
    /// Whether the offset is an unknown, as it is of an instrument that is zeroed anywhere.
    pub free_offset: bool,
}

impl Linear {
    /// Its word.
    pub const KIND: &'static str = "linear";

    fn direction(&self) -> Vector3<f64> {
        self.direction.unwrap_or_else(Vector3::z)
    }
}

impl Default for Linear {
    /// True lengths along an unknown direction from an unknown zero.
    fn default() -> Self {
        Linear {
            direction: None,
            known: false,
            about: Vector3::zeros(),
            gain: 1.0,
            free_gain: false,
            offset: 0.0,
            free_offset: true,
        }
    }
}

impl Observation for Linear {
    fn kind(&self) -> &'static str {
        Self::KIND
    }

    fn unknowns(&self, name: &str, length: f64) -> Vec<Column> {
        let mut all = Vec::new();
        if !self.known {
            all.extend([1, 2].map(|k| Column::new(format!("tilt {k} of {name}"), "rad", TURNED)));
        }
        if self.free_gain {
            all.push(Column::new(format!("gain of {name}"), "1", TURNED));
        }
        if self.free_offset {
            all.push(Column::new(format!("offset of {name}"), "m", OFF * length));
        }
        all
    }

    fn read(&self, at: &Pose, out: &mut Reading) -> bool {
        let (d, away) = (self.direction(), at.translation - self.about);
        let tilts = (!self.known).then(|| across(&d).map(|e| self.gain * e.dot(&away)));
        let gain = self.free_gain.then(|| d.dot(&away));
        let own = tilts.into_iter().flatten().chain(gain).chain(self.free_offset.then_some(1.0));
        out.one(self.gain * d.dot(&away) + self.offset, d * self.gain, own);
        true
    }

    fn moved(&self, by: &[f64]) -> Box<dyn Observation> {
        let mut by = by.iter().copied();
        let mut moved = self.clone();
        if !self.known {
            let d = self.direction();
            let [first, second] = across(&d);
            let turned = d + first * by.next().unwrap_or(0.0) + second * by.next().unwrap_or(0.0);
            moved.direction = Some(turned.normalize());
        }
        if self.free_gain {
            moved.gain += by.next().unwrap_or(0.0);
        }
        if self.free_offset {
            moved.offset += by.next().unwrap_or(0.0);
        }
        Box::new(moved)
    }

    fn started(&self, seen: &[Seen]) -> Result<Box<dyn Observation>, String> {
        let about = if self.free_offset { centre(seen) } else { self.about };
        let mean = seen.iter().map(|(_, z)| z[0]).sum::<f64>() / seen.len() as f64;
        let mut start = self.clone();
        start.about = about;
        if self.free_offset {
            start.offset = mean;
        }
        if self.direction.is_none() {
            let rows: Vec<Vec<f64>> =
                seen.iter().map(|(at, _)| (at.translation - about).iter().copied().collect()).collect();
            let right: Vec<f64> = seen.iter().map(|(_, z)| z[0] - start.offset).collect();
            let found = solved(&rows, &right).ok_or(
                "its points do not determine its direction: measure points that spread in all directions, or declare its `normal`",
            )?;
            let slope = Vector3::new(found[0], found[1], found[2]);
            let Some(direction) = slope.try_normalize(1e-12) else {
                return Err("its values are all the same".into());
            };
            start.direction = Some(if self.gain < 0.0 { -direction } else { direction });
            if self.free_gain {
                start.gain = slope.norm() * self.gain.signum();
            }
        }
        Ok(descended(&start, seen))
    }

    fn placed(&self) -> bool {
        self.direction.is_some()
    }

    fn values(&self) -> Vec<(&'static str, f64, &'static str)> {
        let mut all = shown_direction(self.direction()).to_vec();
        let offset = self.offset - self.gain * self.direction().dot(&self.about);
        all.extend([("gain", self.gain, "1"), ("offset", offset, "m")]);
        all
    }

    fn freed(&self) -> Vec<(&'static str, Box<dyn Observation>)> {
        let law = Linear { free_gain: true, ..self.clone() };
        let turned = Linear { known: false, ..self.clone() };
        taken([(self.known, "direction", Box::new(turned)), (!self.free_gain, "gain", Box::new(law))])
    }

    fn metric(&self) -> bool {
        !self.free_gain
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
        let d = Some(Vector3::new(0.3, -0.5, 0.2).normalize());
        check_observation(&Linear { direction: d, gain: 0.8, free_gain: true, ..Linear::default() });
        check_observation(&Linear { direction: d, known: true, ..Linear::default() });
    }

    #[test]
    fn a_gauge_is_found_from_nothing() {
        let d = Vector3::new(0.6, -0.5, 0.2).normalize();
        for (gain, free_gain) in [(1.0, false), (1.3, true)] {
            let value = |at: &Pose| vec![gain * d.dot(&at.translation) + 0.7];
            let seen: Vec<Seen> = scattered(15).into_iter().map(|at| (at, value(&at))).collect();
            let found = Linear { free_gain, ..Linear::default() }.started(&seen).unwrap();
            let mut reading = Reading::default();
            for (at, z) in &seen {
                assert!(found.read(at, &mut reading) && (reading.value[0] - z[0]).abs() < 1e-9);
            }
        }
    }
}
