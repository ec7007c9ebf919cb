//! Rows of which one number was measured: along a direction of their own.
//!
//! ```text
//! z = h(p, s)  →  w · (P − p) − k · ds,    w = μ ∂h/∂p,    P = p₀ + (z − h₀) ∂h/∂pᵀ / ‖∂h/∂p‖²
//! ```
//!
//! | symbol | here | unit |
//! | --- | --- | --- |
//! | w | channels [`RAY`], measurement frame; zero in a row that is no such one | 1 |
//! | P | `position` of the row: where the target would be if nothing across the direction were wrong | m |
//! | μ | how much the row counts: standard deviation of the reference over that of the kind | m per unit of z |
//! | s, k | unknowns of the sensor or landmark ([`crate::effects::Observed`]); channels `own~…` | |
//!
//! Where such a row is linearised, and with what weight, is worked out before a fit; all that a fit has to know of it is a direction. So
//! effects, solvers and reduction are the same for every kind of measurement.

use super::meets::MEETS;
use super::table::Dataset;
use nalgebra::Vector3;

/// The channels of the direction w. No file can have columns of these names, and no cause is looked for in them.
pub const RAY: [&str; 3] = ["ray~x", "ray~y", "ray~z"];
/// The channel of the number of the sensor or landmark whose unknowns a row shares: 1…; 0: none.
pub const SENSOR: &str = "sensor~";
/// The channel of the kind of observation: its place in [`crate::observation::KINDS`], from one; 0: a pose, a position or a touched point.
pub const KIND: &str = "kind~";
/// The channels of measured scalars, in SI units; pixels in px.
pub const VALUE: [&str; 3] = ["value~1", "value~2", "value~3"];
/// The channel of the landmark that a camera on the robot saw, by its number from one.
pub const POINT: &str = "point~";
/// Of channels that hold what an unknown of the sensor does to the row.
const OWN: &str = "own~";

/// The channel of what the k-th unknown of its sensor does to a row.
pub fn own_channel(k: usize) -> String {
    format!("{OWN}{}", k + 1)
}

/// Whether a channel of this name belongs to kinds of observation.
pub(crate) fn of_observation(channel: &str) -> bool {
    RAY.contains(&channel)
        || VALUE.contains(&channel)
        || [SENSOR, KIND, POINT, MEETS].contains(&channel)
        || channel.starts_with(OWN)
}

/// One number that a row measured, linearised.
#[derive(Debug, Clone, PartialEq)]
pub struct Ray {
    /// w.
    pub direction: Vector3<f64>,
    /// P, m.
    pub position: Vector3<f64>,
    /// Number of the sensor from zero; none where nothing but the robot is unknown.
    pub sensor: Option<usize>,
    /// For each unknown of the sensor: by how much a unit of it moves P against the target, in units of w.
    pub own: Vec<f64>,
}

impl Dataset {
    /// The columns of the direction; none where no row measured one number.
    pub fn rays(&self) -> Option<[&[f64]; 3]> {
        let first = self.schema.channel(RAY[0])?;
        let [y, z] = [RAY[1], RAY[2]].map(|name| self.schema.channel(name));
        Some([first, y?, z?].map(|k| self.channels[k].as_slice()))
    }

    /// The direction along which a row measured one number; none where it measured something else.
    #[inline]
    pub fn ray(&self, row: usize) -> Option<Vector3<f64>> {
        let [x, y, z] = self.rays()?;
        let direction = Vector3::new(x[row], y[row], z[row]);
        (direction != Vector3::zeros()).then_some(direction)
    }

    /// What is left of a measured position at a predicted one, m, measurement frame: of a row that measured along a direction only the part
    /// along it. NaN for what was not measured.
    pub fn away(&self, row: usize, predicted: &Vector3<f64>) -> Vector3<f64> {
        let away = self.measured_position(row) - predicted;
        self.ray(row).map_or(away, |w| w * (w.dot(&away) / w.norm_squared()))
    }

    /// The measured numbers of such a vector, as a fit has them (0…2): along the direction in the first place, where there is one.
    #[inline]
    pub fn number(&self, row: usize, away: &Vector3<f64>, component: usize) -> Option<f64> {
        match self.ray(row) {
            Some(w) => (component == 0).then(|| w.dot(away)),
            None => (!self.position[row][component].is_nan()).then(|| away[component]),
        }
    }

    /// The sensor whose unknowns a row shares, by its number from zero.
    pub fn sensor(&self, row: usize) -> Option<usize> {
        // Numbers are small and whole.
        (self.schema.channel(SENSOR).map(|k| self.channels[k][row])? as usize).checked_sub(1)
    }

    /// The kind of observation of a row, by its number from zero; none of a pose, a position or a touched point.
    pub fn kind(&self, row: usize) -> Option<usize> {
        (self.schema.channel(KIND).map(|k| self.channels[k][row])? as usize).checked_sub(1)
    }

    /// The landmark that a camera on the robot saw in a row, by its number from zero.
    pub fn point(&self, row: usize) -> Option<usize> {
        (self.schema.channel(POINT).map(|k| self.channels[k][row])? as usize).checked_sub(1)
    }

    /// With these points, one a row; none where no camera on the robot saw any.
    pub fn set_points(&mut self, of_row: Option<&[Option<usize>]>) {
        let numbers = |of: &[Option<usize>]| of.iter().map(|k| k.map_or(0.0, |k| (k + 1) as f64)).collect();
        self.set_numbers(POINT, of_row.map(numbers));
    }

    /// A measured scalar of a row, 0 to 2.
    pub fn scalar(&self, row: usize, which: usize) -> Option<f64> {
        self.schema.channel(VALUE[which]).map(|k| self.channels[k][row])
    }

    /// With these kinds, numbers from one, and scalars, one a row; without them where they are none.
    pub fn set_kinds(&mut self, kinds: Option<Vec<f64>>, scalars: [Option<Vec<f64>>; 3]) {
        self.set_numbers(KIND, kinds);
        VALUE.into_iter().zip(scalars).for_each(|(name, column)| self.set_numbers(name, column));
    }

    /// Rows of which this is true touched a point: they measured no number.
    pub fn touch(&mut self, rows: impl Fn(usize) -> bool) {
        for name in [KIND].into_iter().chain(VALUE) {
            if let Some(k) = self.schema.channel(name) {
                self.channels[k]
                    .iter_mut()
                    .enumerate()
                    .filter(|(row, _)| rows(*row))
                    .for_each(|(_, v)| *v = 0.0);
            }
        }
    }

    /// With these directions, one a row; without any where they are none.
    pub fn set_rays(&mut self, rays: Option<&[Option<Ray>]>) {
        let unknowns = self.schema.channels.iter().filter(|channel| channel.name.starts_with(OWN)).count();
        let widest = rays.map_or(0, |rays| rays.iter().flatten().map(|ray| ray.own.len()).max().unwrap_or(0));
        let column = |of: &dyn Fn(&Ray) -> f64| -> Option<Vec<f64>> {
            rays.map(|rays| rays.iter().map(|ray| ray.as_ref().map_or(0.0, of)).collect())
        };
        for (k, name) in RAY.into_iter().enumerate() {
            self.set_numbers(name, column(&|ray| ray.direction[k]));
        }
        self.set_numbers(SENSOR, column(&|ray| ray.sensor.map_or(0.0, |k| (k + 1) as f64)));
        for k in 0..widest.max(unknowns) {
            let values = column(&|ray| ray.own.get(k).copied().unwrap_or(0.0));
            self.set_numbers(&own_channel(k), values.filter(|_| k < widest));
        }
        for (row, ray) in rays.unwrap_or_default().iter().enumerate() {
            if let Some(ray) = ray {
                self.position[row] = ray.position.into();
            }
        }
    }

    /// Without anything that belongs to kinds of observation.
    pub(crate) fn forget_observations(&mut self) {
        let names: Vec<String> = self.schema.channels.iter().map(|channel| channel.name.clone()).collect();
        names.iter().filter(|name| of_observation(name)).for_each(|name| self.set_numbers(name, None));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{DatasetBuilder, Measurement};
    use truepose_kinematics::samples;

    #[test]
    fn one_number_of_a_row_is_seen_along_its_direction() {
        let chain = samples::ur10();
        let mut builder = DatasetBuilder::new(&chain);
        for k in 0..3 {
            builder.push(Measurement::at([0.1 * f64::from(k); 6]).position([0.5, 0.2, 0.3])).unwrap();
        }
        let mut data = builder.finish();
        let before = data.clone();
        let ray = Ray {
            direction: Vector3::new(0.0, 0.0, 2.0),
            position: Vector3::new(0.1, 0.2, 0.4),
            sensor: Some(1),
            own: vec![0.5, -1.0],
        };
        data.set_rays(Some(&[None, Some(ray), None]));
        assert_eq!([0, 1, 2].map(|row| data.seen(row).count()), [3, 1, 3]);
        assert_eq!(data.away(1, &Vector3::new(7.0, 8.0, 0.1)), Vector3::new(0.0, 0.0, 0.4 - 0.1));
        let away = Vector3::new(1.0, 2.0, 3.0);
        assert_eq!([0, 1, 2].map(|k| data.number(1, &away, k)), [Some(6.0), None, None]);
        assert_eq!([0, 1, 2].map(|k| data.number(0, &away, k)), [Some(1.0), Some(2.0), Some(3.0)]);
        assert_eq!((data.sensor(0), data.sensor(1)), (None, Some(1)));
        let part = data.select(&[1]);
        assert_eq!(part.ray(0), Some(Vector3::new(0.0, 0.0, 2.0)));
        data.set_rays(None);
        assert_eq!(data.schema, before.schema);
    }
}
