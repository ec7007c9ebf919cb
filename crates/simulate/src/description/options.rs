//! The plant's half of a description, and plants drawn from it.

use crate::flaws::Flaws;
use crate::physics::temperature::Shop;
use crate::{Instrument, Plant, Repeatability, SimulateError, Tail, Truth};
use nalgebra::Vector3;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use serde::{Deserialize, Serialize};
use truepose_kinematics::Chain;

/// What is wrong with a robot and how it is measured; the rest is drawn.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct PlantOptions {
    /// What is wrong with the robot.
    pub errors: Flaws,
    /// The weather in the shop.
    pub shop: ShopDay,
    /// The instrument.
    pub instrument: InstrumentSize,
    /// How well the robot comes back.
    pub repeatability: RepeatabilitySize,
}

/// A day in the shop.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct ShopDay {
    /// Temperature in the morning, °C; everything has its nominal size at 20 °C.
    pub start_c: f64,
    /// Rise to the evening, K.
    pub rise_k: f64,
    /// Root mean square of the wandering about that, K.
    pub wander_k: f64,
    /// Length of the day, h: all that is drawn over time is drawn over this.
    pub hours: f64,
}

/// An instrument.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct InstrumentSize {
    /// Its position in the measurement frame, mm.
    pub station_mm: [f64; 3],
    /// Standard deviation an axis at range zero, µm.
    pub sd_um: f64,
    /// Growth along the line of sight, µm/m.
    pub radial_um_per_m: f64,
    /// Growth across it, µm/m.
    pub transverse_um_per_m: f64,
    /// Degrees of freedom of Student's t; left out: normal errors.
    pub freedom: Option<f64>,
    /// Standard deviation of the orientation, µrad; left out: it is not measured.
    pub orientation_urad: Option<f64>,
    /// Which of x, y, z it sees.
    pub axes: [bool; 3],
    /// Whether the data states the standard deviations.
    pub states_sd: bool,
}

/// How well the robot comes back.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct RepeatabilitySize {
    /// Standard deviation an axis and visit, µm.
    pub sd_um: f64,
    /// Standard deviation of a rotation about the tool's origin, µrad an axis.
    pub rotation_urad: f64,
}

impl Default for ShopDay {
    fn default() -> Self {
        ShopDay { start_c: 20.0, rise_k: 0.0, wander_k: 0.0, hours: 8.0 }
    }
}

impl Default for InstrumentSize {
    fn default() -> Self {
        InstrumentSize {
            station_mm: [0.0; 3],
            sd_um: 0.0,
            radial_um_per_m: 0.0,
            transverse_um_per_m: 0.0,
            freedom: None,
            orientation_urad: None,
            axes: [true; 3],
            states_sd: false,
        }
    }
}

impl Plant {
    /// A plant with these flaws; phases, curves and directions are drawn from the seed.
    ///
    /// # Errors
    /// For places that the robot lacks and sizes that make no sense.
    pub fn random(chain: &Chain, options: &PlantOptions, seed: u64) -> Result<Self, SimulateError> {
        let day = &options.shop;
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let shop = Shop::day((day.start_c, day.rise_k, day.wander_k), 3600.0 * day.hours, &mut rng)?;
        let (truth, blunders) = options.errors.on(chain, &shop, seed)?;
        let mut plant = Plant::new(chain, Truth::of(chain))?.with_truth(truth)?;
        plant.shop = shop;
        plant.blunders = blunders;
        plant.instrument = options.instrument.instrument()?;
        let size = &options.repeatability;
        plant.repeatability = Repeatability { sd: 1e-6 * size.sd_um, rotation_sd: 1e-6 * size.rotation_urad };
        Ok(plant)
    }
}

impl InstrumentSize {
    fn instrument(&self) -> Result<Instrument, SimulateError> {
        Instrument {
            station: Vector3::from(self.station_mm) * 1e-3,
            sd: 1e-6 * self.sd_um,
            radial_per_metre: 1e-6 * self.radial_um_per_m,
            transverse_per_metre: 1e-6 * self.transverse_um_per_m,
            tail: self.freedom.map_or(Tail::Normal, |freedom| Tail::Student { freedom }),
            axes: self.axes,
            orientation_sd: self.orientation_urad.map(|v| 1e-6 * v),
            states_sd: self.states_sd,
        }
        .checked()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use truepose_kinematics::{Conditions, samples};

    #[test]
    fn nothing_wrong_is_the_perfect_plant() {
        for chain in samples::all() {
            let plant = Plant::random(&chain, &PlantOptions::default(), 3).expect("a plant");
            let perfect = Plant::perfect(&chain).expect("a plant");
            let at = Conditions::at(&chain, &vec![0.2; chain.movable().len()]);
            let (a, b) = (plant.true_pose(&at).expect("a pose"), perfect.true_pose(&at).expect("a pose"));
            assert_eq!(a, b, "{}", chain.name());
        }
    }

    #[test]
    fn the_seed_decides_what_is_drawn() {
        let chain = samples::heavy();
        let mut options = PlantOptions::default();
        options.errors.geometric = Some(crate::flaws::Geometric { position_mm: 0.5, ..Default::default() });
        options.shop.wander_k = 1.0;
        let of = |seed| Plant::random(&chain, &options, seed).expect("a plant");
        assert_eq!((of(1).truth(), &of(1).shop), (of(1).truth(), &of(1).shop));
        assert_ne!(of(1).truth(), of(2).truth());
        assert_ne!(of(1).shop, of(2).shop);
    }
}
