//! What the robot as described leaves with the best base and tool, and which mistake of convention, undone, leaves far less.
//!
//! ```text
//! place base and tool on the positions ──► RMS of positions, m
//!                                     └──► R_k ≈ R_B R_Fk R_T with the best R_T ──► RMS of orientations, rad
//! ```
//!
//! A calibration corrects millimetres. Where the description leaves a good part of the arm's length, it is another robot's, or its numbers
//! were written in another convention; each usual mistake is undone in turn, and the one that leaves a fifth or less is the likely cause.

mod lengths;
mod misread;
mod orientation;
mod placed;
mod positions;
mod tool;
mod variants;

pub use misread::{Misread, Misreading};

use crate::{IdentifyError, Placement};
use misread::{NEGLIGIBLE, TURNED};
use truepose_errormodel::{Dataset, configurations};
use truepose_kinematics::Chain;

/// Configurations below which base and tool fit anything.
const CONFIGURATIONS: usize = 8;

/// Rows that are looked at: as many as a placement refines on.
const ROWS: usize = 3000;

/// What the nominal robot leaves.
#[derive(Debug, Clone, PartialEq)]
pub struct NominalResidual {
    /// The robot with base and tool where they fit the positions best.
    pub placement: Placement,
    /// RMS of the 3-D position error, m.
    pub position_rms: f64,
    /// RMS of the angle of the orientation error, rad; none where no orientations were measured.
    pub orientation_rms: Option<f64>,
    /// Characteristic length of the arm, m.
    pub length: f64,
}

impl NominalResidual {
    /// The position error as a share of the arm's length.
    pub fn share(&self) -> f64 {
        self.position_rms / self.length
    }
}

/// What the robot as described leaves with the best base and tool; none where too few positions were measured to say.
///
/// # Errors
/// When the data does not fit the robot.
pub fn nominal_residual(chain: &Chain, data: &Dataset) -> Result<Option<NominalResidual>, IdentifyError> {
    data.validate(chain)?;
    let rows = placed::some(data, ROWS);
    if rows.is_empty() || configurations(&rows).iter().max().is_none_or(|last| last + 1 < CONFIGURATIONS) {
        return Ok(None);
    }
    let Some(placement) = placed::placed(chain, &rows) else { return Ok(None) };
    let position_rms = placement.rms;
    let one = placement.chain.tools().len() == 1;
    let orientation_rms = if one { orientation::rms(&placement.chain, data) } else { None };
    let length = chain.characteristic_length();
    Ok(Some(NominalResidual { placement, position_rms, orientation_rms, length }))
}

/// The likely mistakes behind what the nominal robot leaves: about positions, or else about orientations and the tool; or none.
pub fn misreadings(chain: &Chain, data: &Dataset, found: &NominalResidual) -> Vec<Misread> {
    // Usual mistakes are those of tables of one chain.
    if !chain.is_serial() {
        return Vec::new();
    }
    if found.share() > NEGLIGIBLE {
        return positions::misread(chain, data).into_iter().collect();
    }
    let turned = found.orientation_rms.is_some_and(|rms| rms > TURNED);
    let orientation = if turned { orientation::misread(&found.placement.chain, data) } else { None };
    orientation.into_iter().chain(tool::misread(chain, data, found.position_rms)).collect()
}

#[cfg(test)]
mod tests;
