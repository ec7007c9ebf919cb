//! The instrument, the robot's repeatability, and what people get wrong.
//!
//! ```text
//! y = p + u_visit + u_φ × (p − p_tool) + L z         z: three unit numbers, normal or Student's t
//! cov(L z) = σ_t² (1 − ê êᵀ) + σ_r² ê êᵀ              σ = a + b R,   ê = (p − station)/R
//! ```
//!
//! | symbol | here | unit | frame |
//! | --- | --- | --- | --- |
//! | σ_r, σ_t | along and across the line of sight | m | measurement |
//! | a, b | `sd`, `radial_per_metre`, `transverse_per_metre` | m, m/m | |
//! | R | range from the station | m | measurement |
//! | u_visit, u_φ | repeatability of one pose measurement | m, rad | measurement |
//!
//! Source: ASME B89.4.19 and the makers' data sheets of laser trackers (15 µm + 6 µm/m across, less along).

use crate::SimulateError;
use nalgebra::{Matrix3, Vector3};
use rand::Rng;
use rand_distr::{Distribution, StandardNormal, StudentT};

/// How the instrument's errors are distributed.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum Tail {
    /// Normally.
    #[default]
    Normal,
    /// As Student's t with this many degrees of freedom (more than two), scaled to the same variance.
    Student {
        /// Degrees of freedom.
        freedom: f64,
    },
}

/// An instrument that measures points, and perhaps the tool's orientation.
#[derive(Debug, Clone, PartialEq)]
pub struct Instrument {
    /// Its position in the measurement frame, m.
    pub station: Vector3<f64>,
    /// Standard deviation an axis at range zero, m.
    pub sd: f64,
    /// Growth of the standard deviation along the line of sight, m/m.
    pub radial_per_metre: f64,
    /// Growth of the standard deviation across it, m/m.
    pub transverse_per_metre: f64,
    /// Distribution.
    pub tail: Tail,
    /// Which of x, y, z it sees.
    pub axes: [bool; 3],
    /// Standard deviation of the orientation about each axis, rad; none does not measure it.
    pub orientation_sd: Option<f64>,
    /// Whether the data states the standard deviations.
    pub states_sd: bool,
}

impl Default for Instrument {
    /// One that measures points without error.
    fn default() -> Self {
        Instrument {
            station: Vector3::zeros(),
            sd: 0.0,
            radial_per_metre: 0.0,
            transverse_per_metre: 0.0,
            tail: Tail::Normal,
            axes: [true; 3],
            orientation_sd: None,
            states_sd: false,
        }
    }
}

/// Repeatability of the robot: the deviation that all rows of one pose measurement share.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Repeatability {
    /// Standard deviation an axis, m.
    pub sd: f64,
    /// Standard deviation of a rotation about the tool's origin, rad an axis.
    pub rotation_sd: f64,
}

/// What people get wrong.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Blunders {
    /// Share of the rows that are outliers.
    pub outlier_share: f64,
    /// Their size, m: each is between half and one and a half times that, in any direction.
    pub outlier_size: f64,
    /// Declared payloads (kg) and what really hung there (kg).
    pub mislabelled: Vec<(f64, f64)>,
    /// Fraction of the loaded pose measurements whose declared payload is wrong.
    pub wrong_payload_share: f64,
    /// True mass over declared mass on those.
    pub wrong_payload_factor: f64,
    /// A stretch of time (s), the declared mass (kg) that was another load then, and true mass over declared mass.
    pub wrong_stretch: Option<([f64; 2], f64, f64)>,
}

impl Instrument {
    /// The same instrument, if its numbers make sense.
    ///
    /// # Errors
    /// For a negative deviation or two degrees of freedom or fewer.
    pub fn checked(self) -> Result<Self, SimulateError> {
        let orientation = self.orientation_sd.unwrap_or(0.0);
        for value in [self.sd, self.radial_per_metre, self.transverse_per_metre, orientation] {
            if !value.is_finite() || value < 0.0 {
                let what = "an instrument's standard deviation";
                return Err(SimulateError::Size { what, value, need: "zero or more" });
            }
        }
        if let Tail::Student { freedom } = self.tail
            && (freedom.is_nan() || freedom <= 2.0)
        {
            let what = "the degrees of freedom of a heavy tail";
            return Err(SimulateError::Size { what, value: freedom, need: "above 2" });
        }
        Ok(self)
    }

    /// Covariance of a measured point, m².
    pub fn covariance(&self, point: &Vector3<f64>) -> Matrix3<f64> {
        let sight = point - self.station;
        let range = sight.norm();
        let along = if range > 0.0 { sight / range } else { Vector3::x() };
        let radial = (self.sd + self.radial_per_metre * range).powi(2);
        let transverse = (self.sd + self.transverse_per_metre * range).powi(2);
        Matrix3::identity() * transverse + along * along.transpose() * (radial - transverse)
    }

    /// An error of measurement at this point, m.
    pub fn error(&self, point: &Vector3<f64>, rng: &mut impl Rng) -> Vector3<f64> {
        let z = Vector3::from_fn(|_, _| self.unit(rng));
        let sight = point - self.station;
        let range = sight.norm();
        let along = if range > 0.0 { sight / range } else { Vector3::x() };
        let along = along * along.dot(&z);
        along * (self.sd + self.radial_per_metre * range)
            + (z - along) * (self.sd + self.transverse_per_metre * range)
    }

    /// A random number of mean zero and variance one.
    pub fn unit(&self, rng: &mut impl Rng) -> f64 {
        match self.tail {
            Tail::Normal => StandardNormal.sample(rng),
            Tail::Student { freedom } => {
                StudentT::new(freedom).map_or(0.0, |t| t.sample(rng) * ((freedom - 2.0) / freedom).sqrt())
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;

    fn sample(instrument: &Instrument, point: &Vector3<f64>) -> (Matrix3<f64>, f64) {
        let mut rng = ChaCha8Rng::seed_from_u64(11);
        let (mut second, mut fourth) = (Matrix3::zeros(), 0.0);
        for _ in 0..40_000 {
            let e = instrument.error(point, &mut rng);
            second += e * e.transpose() / 40_000.0;
            fourth += e.z.powi(4) / 40_000.0;
        }
        (second, fourth / second[(2, 2)].powi(2))
    }

    #[test]
    fn errors_have_the_covariance_that_is_stated() {
        let instrument = Instrument {
            station: Vector3::new(1.0, 0.0, 0.0),
            sd: 15e-6,
            radial_per_metre: 1e-6,
            transverse_per_metre: 6e-6,
            ..Instrument::default()
        };
        let point = Vector3::new(4.0, 3.0, -2.0);
        let stated = instrument.covariance(&point);
        let (seen, kurtosis) = sample(&instrument, &point);
        // 40 000 draws: each entry is known to about 1 % of the largest.
        assert!((seen - stated).amax() < 0.03 * stated.amax(), "{seen} {stated}");
        assert!((kurtosis - 3.0).abs() < 0.15, "{kurtosis}");
        let along = (point - instrument.station).normalize();
        assert!((along.dot(&(stated * along)).sqrt() - (15e-6 + 22f64.sqrt() * 1e-6)).abs() < 1e-12);
    }

    #[test]
    fn a_heavy_tail_has_the_same_variance_and_more_kurtosis() {
        let heavy = Instrument { sd: 2e-5, tail: Tail::Student { freedom: 6.0 }, ..Instrument::default() };
        let (seen, kurtosis) = sample(&heavy, &Vector3::z());
        assert!((seen[(0, 0)] / 4e-10 - 1.0).abs() < 0.05);
        // 3 + 6/(ν − 4) = 6.
        assert!(kurtosis > 4.2, "{kurtosis}");
    }

    #[test]
    fn invalid_values_are_rejected() {
        assert!(Instrument { sd: -1.0, ..Instrument::default() }.checked().is_err());
        let student = Tail::Student { freedom: 2.0 };
        assert!(Instrument { tail: student, ..Instrument::default() }.checked().is_err());
    }
}
