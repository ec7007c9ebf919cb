//! Columns without a fixed meaning: thermometers, and what has nothing to do with the robot.

use crate::SimulateError;
use crate::physics::curve::{Centred, SmoothCurve};
use crate::physics::temperature::Shop;
use rand::Rng;
use rand_distr::{Distribution, StandardNormal};
use truepose_errormodel::Channel;

/// A numeric column of a campaign.
#[derive(Debug, Clone, PartialEq)]
pub enum ChannelPlan {
    /// A thermometer in the air of the shop.
    Air {
        /// Name of the column.
        name: String,
        /// Noise of the thermometer, K.
        sd: f64,
    },
    /// A thermometer on a body that follows the air late.
    Body {
        /// Name of the column.
        name: String,
        /// s.
        lag_s: f64,
        /// Noise of the thermometer, K.
        sd: f64,
    },
    /// Something that wanders and touches nothing.
    Distractor {
        /// Name of the column.
        name: String,
        /// Its unit.
        unit: String,
        /// About this value.
        mean: f64,
        /// Root mean square of its wandering.
        sd: f64,
    },
}

impl ChannelPlan {
    /// How the column appears in a schema.
    pub(crate) fn channel(&self) -> Channel {
        let (name, unit) = match self {
            ChannelPlan::Air { name, .. } | ChannelPlan::Body { name, .. } => (name, "degC"),
            ChannelPlan::Distractor { name, unit, .. } => (name, unit.as_str()),
        };
        let temperature = matches!(unit, "degC" | "K");
        Channel { name: name.clone(), unit: unit.into(), temperature }
    }

    /// Its values at these times (s).
    ///
    /// # Errors
    /// Those of [`SmoothCurve::draw`] and [`Shop::body`].
    pub(crate) fn values(
        &self,
        shop: &Shop,
        times: &[f64],
        rng: &mut impl Rng,
    ) -> Result<Vec<f64>, SimulateError> {
        let (curve, offset, noise) = match self {
            ChannelPlan::Air { sd, .. } => (shop.air.clone(), 0.0, *sd),
            ChannelPlan::Body { lag_s, sd, .. } => (shop.body(*lag_s)?, shop.reference, *sd),
            ChannelPlan::Distractor { mean, sd, .. } => {
                let begin = times.iter().copied().fold(f64::INFINITY, f64::min);
                let end = times.iter().copied().fold(f64::NEG_INFINITY, f64::max);
                let span = (end - begin).max(1.0);
                let walk = SmoothCurve::draw((begin, begin + span), span / 5.0, *sd, Centred::Mean, rng)?;
                (walk, *mean, 0.05 * sd)
            }
        };
        let mut reading = |&t: &f64| {
            let z: f64 = StandardNormal.sample(&mut *rng);
            curve.value(t) + offset + noise * z
        };
        Ok(times.iter().map(&mut reading).collect())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;

    #[test]
    fn a_thermometer_reads_the_air_and_a_distractor_does_not() {
        let mut rng = ChaCha8Rng::seed_from_u64(1);
        let shop = Shop::day((19.0, 4.0, 0.5), 7200.0, &mut rng).expect("a day");
        let times: Vec<f64> = (0..200).map(|k| 36.0 * f64::from(k)).collect();
        let air = ChannelPlan::Air { name: "temperature".into(), sd: 0.02 };
        assert!(air.channel().temperature);
        let read = air.values(&shop, &times, &mut rng).expect("values");
        let off: f64 = read.iter().zip(&times).map(|(v, &t)| (v - shop.air.value(t)).powi(2)).sum();
        assert!(((off / 200.0).sqrt() - 0.02).abs() < 0.005);
        let other =
            ChannelPlan::Distractor { name: "humidity".into(), unit: "%".into(), mean: 45.0, sd: 3.0 };
        assert!(!other.channel().temperature);
        let values = other.values(&shop, &times, &mut rng).expect("values");
        assert!(values.iter().all(|v| (20.0..70.0).contains(v)));
    }
}
