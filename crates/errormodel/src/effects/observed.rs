//! Unknowns of sensors and of things of the surroundings of which rows measured one number: anchors, planes, gains, offsets.
//!
//! ```text
//! w·p − k_j s_j  is what row i reads;    emitted at the base: (w/‖…‖) k_j per unit of s_j, a displacement that only the row itself sees
//! ```
//!
//! | symbol | here | unit |
//! | --- | --- | --- |
//! | w | the channels [`RAY`](crate::RAY), measurement frame | 1 |
//! | k_j | the channels [`own_channel`](crate::own_channel) of the unknowns of the row's sensor | per unit |
//! | sensor | the channel [`SENSOR`](crate::SENSOR), from one; zero: none | |
//!
//! To a row it makes no difference whether its sensor reads more or the whole robot is further along the direction that it measures, so that this
//! is emitted at the base; rows of other sensors see nothing of it.

use super::checks::refused;
use crate::{Column, Effect, Emission, ModelError, RAY, SENSOR, Signal, own_channel};
use nalgebra::Vector3;
use serde::{Deserialize, Serialize};
use truepose_kinematics::{Axis, Chain, FrameId, Posture, Site};

/// An unknown of a sensor.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Unknown {
    /// What it is, with the sensor's name.
    pub name: String,
    /// SI unit.
    pub unit: String,
    /// Expected size.
    pub scale: f64,
}

/// A sensor and its unknowns.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Sensor {
    /// Its name.
    pub name: String,
    /// Its unknowns, in the order of the channels.
    pub unknowns: Vec<Unknown>,
}

/// Unknowns of sensors.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Observed {
    /// In the order of their numbers.
    pub sensors: Vec<Sensor>,
}

impl Observed {
    /// The columns of a sensor.
    pub fn columns_of(&self, sensor: usize) -> std::ops::Range<usize> {
        let first: usize = self.sensors[..sensor].iter().map(|sensor| sensor.unknowns.len()).sum();
        first..first + self.sensors[sensor].unknowns.len()
    }

    fn widest(&self) -> usize {
        self.sensors.iter().map(|sensor| sensor.unknowns.len()).max().unwrap_or(0)
    }
}

impl Effect for Observed {
    const FAMILY: &'static str = "observed";
    const ABOUT: &'static str =
        "unknowns of sensors, anchors, planes and spheres; made from the columns `kind` and `landmark`";

    fn load_dependent(&self) -> bool {
        false
    }

    fn columns(&self, _chain: &Chain) -> Vec<Column> {
        let of = |unknown: &Unknown| Column::new(&unknown.name, &unknown.unit, unknown.scale);
        self.sensors.iter().flat_map(|sensor| &sensor.unknowns).map(of).collect()
    }

    fn eval(&self, at: &Posture<'_>, out: &mut Emission) {
        // Numbers of sensors are small and whole.
        let number = at.signal(0) as usize;
        let Some(sensor) = number.checked_sub(1).filter(|&k| k < self.sensors.len()) else { return };
        let ray = Vector3::new(at.signal(1), at.signal(2), at.signal(3));
        let own = at.chain().base().pose.rotation.tr_mul(&ray);
        for (k, column) in self.columns_of(sensor).enumerate() {
            let by = at.signal(4 + k);
            for axis in Axis::TRANSLATIONS {
                let value = by * own[axis.direction()];
                if value != 0.0 {
                    out.push(column, Site::Frame(FrameId::BASE, axis), value);
                }
            }
        }
    }

    fn needs(&self) -> Vec<Signal> {
        let names = std::iter::once(SENSOR.into()).chain(RAY.map(String::from));
        names.chain((0..self.widest()).map(own_channel)).map(Signal::Channel).collect()
    }

    fn validate(&self, _chain: &Chain) -> Result<(), ModelError> {
        for (k, sensor) in self.sensors.iter().enumerate() {
            if self.sensors[..k].iter().any(|other| other.name == sensor.name) {
                return Err(refused(Self::FAMILY, format!("`{}` stands twice", sensor.name)));
            }
            if sensor.unknowns.iter().any(|unknown| !(unknown.scale.is_finite() && unknown.scale > 0.0)) {
                let reason = format!("an expected size of `{}` is not above zero", sensor.name);
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

    fn two() -> Observed {
        let unknown = |name: &str| Unknown { name: name.into(), unit: "m".into(), scale: 0.01 };
        let sensor = |name: &str, of: &[&str]| Sensor {
            name: name.into(),
            unknowns: of.iter().map(|of| unknown(&format!("{of} of {name}"))).collect(),
        };
        Observed { sensors: vec![sensor("wire", &["gain", "offset"]), sensor("table", &["height"])] }
    }

    #[test]
    fn conforms() {
        for chain in samples::all() {
            check_effect(&two(), &chain);
        }
    }

    #[test]
    fn rows_of_a_sensor_see_its_unknowns_and_no_others() {
        let chain = samples::ur10();
        let values = |number: f64| -> Vec<(usize, f64)> {
            let mut at = Conditions::at(&chain, &[0.3; 6]);
            at.channels = vec![number, 0.0, 0.0, 2.0, 0.5, -1.0];
            emitted(&two(), &chain, &at).iter().map(|entry| (entry.column, entry.value)).collect()
        };
        assert_eq!(values(0.0), []);
        assert_eq!(values(1.0), [(0, 1.0), (1, -2.0)]);
        assert_eq!(values(2.0), [(2, 1.0)]);
    }
}
