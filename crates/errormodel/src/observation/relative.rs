//! Positions in a frame that nobody knows: a cheap instrument that was moved between series.
//!
//! ```text
//! z = h = Rᵀ (p − t)        ∂h/∂p = Rᵀ,  ∂h/∂t = −Rᵀ,  ∂h/∂φ = Rᵀ [p − t]×,      R ← exp(φ) R,  t ← t + dt
//! ```
//!
//! | symbol | here | unit | frame |
//! | --- | --- | --- | --- |
//! | R, t | [`Relative::place`]: the frame of the series | 1, m | measurement |
//! | z | measured position | m | the series' |
//!
//! All rows of a series share its six unknowns; lengths are the instrument's, so that it determines the scale.

use super::seam::{OFF, Observation, Reading, Seen, TURNED, shown};
use super::start::{centre, descended, thinnest};
use crate::Column;
use nalgebra::{Matrix3, Vector3};
use truepose_kinematics::{Pose, nearest_rotation, rotation_vector, skew};

/// A series of positions in a frame of its own.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Relative {
    /// Its frame, measurement frame; none: found from the data.
    pub place: Option<Pose>,
}

impl Relative {
    /// Its word.
    pub const KIND: &'static str = "relative";

    fn place(&self) -> Pose {
        self.place.unwrap_or_default()
    }
}

impl Observation for Relative {
    fn kind(&self) -> &'static str {
        Self::KIND
    }

    fn numbers(&self) -> usize {
        3
    }

    fn unknowns(&self, name: &str, length: f64) -> Vec<Column> {
        let shift = ["x", "y", "z"].map(|axis| Column::new(format!("{axis}@{name}"), "m", OFF * length));
        let turn = ["rx", "ry", "rz"].map(|axis| Column::new(format!("{axis}@{name}"), "rad", TURNED));
        shift.into_iter().chain(turn).collect()
    }

    fn read(&self, at: &Pose, out: &mut Reading) -> bool {
        let place = self.place();
        let away = at.translation - place.translation;
        let by_position = place.rotation.transpose();
        let by_turn = by_position * skew(&away);
        out.value.clear();
        out.value.extend((by_position * away).iter());
        out.by_pose.clear();
        out.by_own.resize_with(3, Vec::new);
        for k in 0..3 {
            let h = by_position.row(k);
            out.by_pose.push([h[0], h[1], h[2], 0.0, 0.0, 0.0]);
            out.by_own[k].clear();
            out.by_own[k].extend(h.iter().map(|v| -v).chain(by_turn.row(k).iter().copied()));
        }
        true
    }

    fn moved(&self, by: &[f64]) -> Box<dyn Observation> {
        let [x, y, z, rx, ry, rz] = *by else { return self.boxed() };
        let place = self.place();
        let rotation = rotation_vector(&Vector3::new(rx, ry, rz)) * place.rotation;
        let place = Pose::new(rotation, place.translation + Vector3::new(x, y, z)).renormalised();
        Box::new(Relative { place: Some(place) })
    }

    fn started(&self, seen: &[Seen]) -> Result<Box<dyn Observation>, String> {
        let (_, spread) = thinnest(seen);
        if seen.len() < 3 || spread[1] < 1e-3 * spread[0].max(1e-6) {
            return Err(
                "its points lie on a line, which does not determine its frame: measure more points across it"
                    .into(),
            );
        }
        let middle = centre(seen);
        let number = |z: &[f64]| Vector3::new(z[0], z[1], z[2]);
        let own = seen.iter().map(|(_, z)| number(z)).sum::<Vector3<f64>>() / seen.len() as f64;
        let pair = |(at, z): &Seen| (at.translation - middle) * (number(z) - own).transpose();
        let cross: Matrix3<f64> = seen.iter().map(pair).sum();
        let rotation = nearest_rotation(&cross).ok_or("its points are no numbers")?;
        Ok(descended(&Relative { place: Some(Pose::new(rotation, middle - rotation * own)) }, seen))
    }

    fn placed(&self) -> bool {
        self.place.is_some()
    }

    fn values(&self) -> Vec<(&'static str, f64, &'static str)> {
        let place = self.place();
        let turns = ["roll", "pitch", "yaw"].into_iter().zip(place.rpy());
        shown(place.translation)
            .into_iter()
            .chain(turns.map(|(name, v)| (name, v.to_degrees(), "deg")))
            .collect()
    }

    fn boxed(&self) -> Box<dyn Observation> {
        Box::new(self.clone())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testkit::{check_observation, scattered};

    fn somewhere() -> Relative {
        Relative { place: Some(Pose::from_xyz_rpy([0.4, -1.0, 2.0], [0.3, -0.2, 2.5])) }
    }

    #[test]
    fn conforms() {
        check_observation(&somewhere());
    }

    #[test]
    fn a_frame_is_found_from_nothing() {
        let truth = somewhere();
        let mut reading = Reading::default();
        let see = |at: Pose| {
            assert!(truth.read(&at, &mut reading));
            (at, reading.value.clone())
        };
        let seen: Vec<Seen> = scattered(8).into_iter().map(see).collect();
        let found = Relative::default().started(&seen).unwrap();
        for (at, z) in &seen {
            assert!(found.read(at, &mut reading));
            assert!(reading.value.iter().zip(z).all(|(a, b)| (a - b).abs() < 1e-9));
        }
        let line: Vec<Seen> = (0..9).map(|k| (Pose::trans(0, 0.1 * f64::from(k)), vec![0.0; 3])).collect();
        assert!(Relative::default().started(&line).unwrap_err().contains("on a line"));
    }
}
