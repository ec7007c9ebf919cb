//! The distance from a target to an anchor: a draw wire, a ball bar, a telescoping bar, the range of a laser radar.
//!
//! ```text
//! h = g ‖p − a‖ + o        ∂h/∂p = g u,  ∂h/∂a = −g u,  ∂h/∂g = ‖p − a‖,  ∂h/∂o = 1,      u = (p − a)/‖p − a‖
//! ```

use super::seam::{OFF, Observation, Reading, Seen, TURNED, place, shown, split_place, taken};
use super::start::{centre, descended, solved};
use crate::Column;
use nalgebra::Vector3;
use truepose_kinematics::Pose;

/// An anchor, and the instrument that measures the distance from it.
#[derive(Debug, Clone, PartialEq)]
pub struct Distance {
    /// a, m, measurement frame; none: found from the data.
    pub anchor: Option<Vector3<f64>>,
    /// Whether that is exact.
    pub known: bool,
    /// g.
    pub gain: f64,
    /// Whether the gain is an unknown.
    pub free_gain: bool,
    /// o, m.
    pub offset: f64,
    /// Whether the offset is an unknown.
    pub free_offset: bool,
}

impl Distance {
    /// Its word.
    pub const KIND: &'static str = "distance";

    fn at(&self) -> Vector3<f64> {
        self.anchor.unwrap_or_default()
    }
}

impl Default for Distance {
    /// A true distance from somewhere.
    fn default() -> Self {
        Distance { anchor: None, known: false, gain: 1.0, free_gain: false, offset: 0.0, free_offset: false }
    }
}

impl Observation for Distance {
    fn kind(&self) -> &'static str {
        Self::KIND
    }

    fn unknowns(&self, name: &str, length: f64) -> Vec<Column> {
        let mut all = if self.known { Vec::new() } else { place(name, length) };
        if self.free_gain {
            all.push(Column::new(format!("gain of {name}"), "1", TURNED));
        }
        if self.free_offset {
            all.push(Column::new(format!("offset of {name}"), "m", OFF * length));
        }
        all
    }

    fn read(&self, at: &Pose, out: &mut Reading) -> bool {
        let away = at.translation - self.at();
        let length = away.norm();
        let Some(u) = away.try_normalize(1e-9) else { return false };
        let by = u * self.gain;
        let anchor = (!self.known).then(|| [-by.x, -by.y, -by.z]).into_iter().flatten();
        let gain = self.free_gain.then_some(length);
        let offset = self.free_offset.then_some(1.0);
        out.one(self.gain * length + self.offset, by, anchor.chain(gain).chain(offset));
        true
    }

    fn moved(&self, by: &[f64]) -> Box<dyn Observation> {
        let (step, rest) = split_place(by, self.known);
        let mut rest = rest.iter();
        let mut moved = self.clone();
        moved.anchor = Some(self.at() + step);
        if self.free_gain {
            moved.gain += rest.next().copied().unwrap_or(0.0);
        }
        if self.free_offset {
            moved.offset += rest.next().copied().unwrap_or(0.0);
        }
        Box::new(moved)
    }

    fn started(&self, seen: &[Seen]) -> Result<Box<dyn Observation>, String> {
        if self.anchor.is_some() {
            return Ok(if self.known { self.boxed() } else { descended(self, seen) });
        }
        // ‖p‖² − ρ² = 2 p·a − 2 o ρ' − κ, which is linear; about the middle of the points.
        let middle = centre(seen);
        let (mut rows, mut right) = (Vec::new(), Vec::new());
        for (at, measured) in seen {
            let (p, z) = (at.translation - middle, (measured[0] - self.offset) / self.gain);
            let mut row = vec![2.0 * p.x, 2.0 * p.y, 2.0 * p.z, -1.0];
            if self.free_offset {
                row.push(-2.0 * z);
            }
            rows.push(row);
            right.push(p.norm_squared() - z * z);
        }
        let found = solved(&rows, &right).ok_or(
            "the distances do not determine where the anchor is: measure from more points, not all on a plane, or declare its `xyz`",
        )?;
        let mut start = self.clone();
        start.anchor = Some(middle + Vector3::new(found[0], found[1], found[2]));
        if self.free_offset {
            start.offset -= self.gain * found[4];
        }
        Ok(descended(&start, seen))
    }

    fn placed(&self) -> bool {
        self.anchor.is_some()
    }

    fn values(&self) -> Vec<(&'static str, f64, &'static str)> {
        let mut all = shown(self.at()).to_vec();
        all.extend([("gain", self.gain, "1"), ("offset", self.offset, "m")]);
        all
    }

    fn freed(&self) -> Vec<(&'static str, Box<dyn Observation>)> {
        let law = Distance { free_gain: true, free_offset: true, ..self.clone() };
        let place = Distance { known: false, ..self.clone() };
        let stated = !(self.free_gain && self.free_offset);
        taken([(self.known, "place", Box::new(place)), (stated, "gain and offset", Box::new(law))])
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

    fn far() -> Distance {
        Distance { anchor: Some(Vector3::new(3.0, -2.0, 1.0)), ..Distance::default() }
    }

    #[test]
    fn conforms() {
        check_observation(&far());
        check_observation(&Distance { free_gain: true, free_offset: true, gain: 1.1, ..far() });
        check_observation(&Distance { known: true, free_offset: true, ..far() });
    }

    #[test]
    fn the_anchor_is_found_from_nothing() {
        for (offset, free_offset) in [(0.0, false), (0.3, true)] {
            let truth = Vector3::new(2.5, -1.0, 0.4);
            let seen: Vec<Seen> = scattered(40)
                .into_iter()
                .map(|at| (at, vec![(at.translation - truth).norm() + offset]))
                .collect();
            let found = Distance { free_offset, ..Distance::default() }.started(&seen).unwrap();
            let mut reading = Reading::default();
            for (at, z) in &seen {
                assert!(found.read(at, &mut reading) && (reading.value[0] - z[0]).abs() < 1e-9);
            }
        }
        let flat: Vec<Seen> = scattered(3).into_iter().map(|at| (at, vec![1.0])).collect();
        assert!(Distance::default().started(&flat).unwrap_err().contains("do not determine"));
    }
}
