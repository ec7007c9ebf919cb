//! A plant and its campaign as a TOML file.
//!
//! ```
//! use truepose_kinematics::samples;
//! use truepose_simulate::PlantDescription;
//!
//! let description = PlantDescription::from_toml(
//!     r#"
//! robot = "heavy.toml"
//! seed = 7
//!
//! [errors.geometric]
//! position_mm = 0.4
//! angle_mrad = 0.3
//!
//! [[errors.joint_compliance]]
//! joint = "a2"
//! stiffness = 2.5e6          # N·m/rad
//!
//! [[errors.transmission]]
//! joint = "a1"
//! wheel = "mesh"
//! amplitude_mrad = 0.05
//! cycles = 120
//!
//! [instrument]
//! sd_um = 15
//! transverse_um_per_m = 6
//!
//! [repeatability]
//! sd_um = 20
//!
//! [campaign]
//! postures = "random"
//! visits = 80
//! payloads_kg = [0, 50, 100]
//! "#,
//! )?;
//! let data = description.measure(&samples::heavy())?;
//! assert_eq!(data.len(), 240);
//! # Ok::<(), truepose_simulate::SimulateError>(())
//! ```
//!
//! The robot's file is named here and read by the caller. A key that is not known, a wrong type or a name that the
//! robot lacks is reported with its line and column.

mod cameras;
mod campaign;
mod landmarks;
mod options;
mod surroundings;

pub use cameras::CameraDescription;
pub use campaign::{CampaignDescription, ChannelDescription, ChannelKind, Postures};
pub use landmarks::{LandmarkDescription, LandmarkKind, MoveDescription};
pub use options::{InstrumentSize, PlantOptions, RepeatabilitySize, ShopDay};
pub use surroundings::MisnamedRow;

use crate::flaws::Flaws;
use crate::{Campaign, Plant, SimulateError};
use serde::{Deserialize, Serialize};
use truepose_errormodel::{Dataset, Surroundings};
use truepose_kinematics::Chain;

/// A robot file, what is wrong with the robot, and how it is measured.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct PlantDescription {
    /// The robot's file, relative to this one.
    pub robot: String,
    /// Seed of everything that is drawn.
    pub seed: u64,
    /// What is wrong with the robot.
    pub errors: Flaws,
    /// The weather in the shop.
    pub shop: ShopDay,
    /// The instrument.
    pub instrument: InstrumentSize,
    /// How well the robot comes back.
    pub repeatability: RepeatabilitySize,
    /// What is measured.
    pub campaign: CampaignDescription,
    /// What the robot touches and is observed with, as it is.
    pub landmarks: Vec<LandmarkDescription>,
    /// Cameras as they are.
    pub cameras: Vec<CameraDescription>,
    /// Rows that name something else than what was observed.
    pub misnamed: Vec<MisnamedRow>,
}

impl PlantDescription {
    /// Reads a description.
    ///
    /// # Errors
    /// [`SimulateError::Description`] with the line and the column.
    pub fn from_toml(text: &str) -> Result<Self, SimulateError> {
        toml::from_str(text).map_err(|error| {
            let (line, column) = place(text, error.span().map_or(0, |span| span.start));
            SimulateError::Description { line, column, message: error.message().to_owned() }
        })
    }

    /// The plant, on this robot, of whose surroundings nothing is described.
    ///
    /// # Errors
    /// For places that the robot lacks and sizes that make no sense; see [`SimulateError::located`].
    pub fn plant(&self, chain: &Chain) -> Result<Plant, SimulateError> {
        self.plant_in(chain, &Surroundings::default())
    }

    /// The plant, on this robot. Where this description leaves out where a landmark is or what a camera is like, it is as described in the
    /// surroundings.
    ///
    /// # Errors
    /// Those of [`PlantDescription::plant`].
    pub fn plant_in(&self, chain: &Chain, described: &Surroundings) -> Result<Plant, SimulateError> {
        let options = PlantOptions {
            errors: self.errors.clone(),
            shop: self.shop.clone(),
            instrument: self.instrument.clone(),
            repeatability: self.repeatability.clone(),
        };
        let mut plant = Plant::random(chain, &options, self.seed)?;
        plant.cell = self.cell(chain, described)?;
        Ok(plant)
    }

    /// The campaign of this plant: visits in which positions are measured, and behind them those with each landmark and each camera.
    ///
    /// # Errors
    /// Those of [`CampaignDescription::on`].
    pub fn campaign_of(&self, plant: &Plant, seed: u64) -> Result<Campaign, SimulateError> {
        self.campaign.with(plant.chain(), self.visits(plant)?, seed)
    }

    /// The plant's data.
    ///
    /// # Errors
    /// Those of [`PlantDescription::plant`], of the campaign and of [`Plant::measure`].
    pub fn measure(&self, chain: &Chain) -> Result<Dataset, SimulateError> {
        let plant = self.plant(chain)?;
        plant.measure(&self.campaign_of(&plant, self.seed)?, self.seed)
    }
}

impl SimulateError {
    /// An error about a name, with the first place of that name in the description.
    pub fn located(self, description: &str) -> SimulateError {
        let name = match &self {
            SimulateError::Unknown { name, .. }
            | SimulateError::OutOfReach { name, .. }
            | SimulateError::Thing { name, .. } => name,
            SimulateError::JointKind { joint, .. } | SimulateError::NoLimits { joint } => joint,
            _ => return self,
        };
        let Some(at) = description.find(&format!("\"{name}\"")) else { return self };
        let (line, column) = place(description, at);
        SimulateError::Description { line, column, message: self.to_string() }
    }
}

/// Line and column, from 1, of a byte of a text.
fn place(text: &str, at: usize) -> (usize, usize) {
    let before = text.get(..at).unwrap_or(text);
    let line_start = before.rfind('\n').map_or(0, |newline| newline + 1);
    (before.matches('\n').count() + 1, before[line_start..].chars().count() + 1)
}

#[cfg(test)]
mod tests {
    use super::*;
    use truepose_kinematics::samples;

    #[track_caller]
    fn check_refused(text: &str, expected_line: usize, expected_column: usize, words: &str) {
        let refused = PlantDescription::from_toml(text)
            .and_then(|d| d.measure(&samples::heavy()))
            .map_err(|error| error.located(text));
        match refused {
            Err(SimulateError::Description { line, column, message }) => {
                assert_eq!((line, column), (expected_line, expected_column), "{message}");
                assert!(message.contains(words), "{message}");
            }
            other => panic!("{other:?}"),
        }
    }

    #[test]
    fn a_typo_is_shown_with_its_place_and_the_known_keys() {
        check_refused("seed = 1\n[instrument]\n  sd_mu = 15\n", 3, 3, "`sd_um`");
        check_refused("[[errors.backlash]]\njoint = \"a1\"\nside = \"left\"\n", 3, 8, "`load_then_approach`");
        check_refused("seed = \"one\"", 1, 8, "u64");
        check_refused("[[errors.shift]]\nat = \"tool\"\nwhen = 3.0\n", 3, 1, "`when_s`");
    }

    #[test]
    fn a_name_that_the_robot_lacks_is_shown_with_its_place() {
        check_refused("seed = 1\n[[errors.link_compliance]]\njoint = \"a7\"\n", 3, 9, "a1, a2");
        check_refused("[[errors.guideway]]\njoint = \"a2\"\n", 2, 9, "prismatic");
    }

    #[test]
    fn a_description_comes_back_from_its_own_text() {
        let mut description = PlantDescription { robot: "r.toml".into(), seed: 3, ..Default::default() };
        description.errors.geometric = Some(crate::flaws::Geometric::default());
        description.errors.shift.push(crate::flaws::Shift { at: "base".into(), ..Default::default() });
        let text = toml::to_string(&description).expect("TOML");
        assert_eq!(PlantDescription::from_toml(&text).expect("a description"), description);
    }
}
