//! What the robot as described leaves with the best base and tool, and which mistake of convention, undone, leaves far less.
//!
//! ```text
//! place base and tool on the positions ──► RMS of positions, m
//!                                     └──► R_k ≈ R_B R_Fk R_T with the best R_T ──► RMS of orientations, rad
//! ```
//!
//! A calibration corrects millimetres. Where the description leaves a good part of the arm's length, it is another robot's, or its numbers
//! were written in another convention; each usual mistake is undone in turn, and the one that leaves a fifth or less is the likely cause.

mod orientation;
mod variants;

pub use variants::Misreading;

use crate::{IdentifyError, Placement, place};
use truepose_errormodel::{Dataset, configurations};
use truepose_kinematics::{Chain, Placed};

/// Configurations below which base and tool fit anything.
const CONFIGURATIONS: usize = 8;
/// Rows on which variants are compared.
const ROWS: usize = 120;
/// Below this share of the arm's length nothing is wrong with conventions; as for suspected mistakes of tables.
const NEGLIGIBLE: f64 = 2e-3;
/// Undone, a mistake leaves no more than this share of what it left.
const GAIN: f64 = 0.2;
/// Orientations that the nominal robot leaves with this RMS are those of a robot that is worth a calibration, rad.
const TURNED: f64 = 0.02;

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

/// A mistake that, undone, explains what the nominal robot leaves.
#[derive(Debug, Clone, PartialEq)]
pub struct Misread {
    /// What was probably done.
    pub what: Misreading,
    /// RMS with it, m (of orientations rad).
    pub before: f64,
    /// With the mistake undone.
    pub after: f64,
}

/// What the robot as described leaves with the best base and tool; none where too few positions were measured to say.
///
/// # Errors
/// When the data does not fit the robot.
pub fn nominal_residual(chain: &Chain, data: &Dataset) -> Result<Option<NominalResidual>, IdentifyError> {
    data.validate(chain)?;
    let measured: Vec<usize> =
        (0..data.len()).filter(|&row| data.position[row].iter().all(|v| v.is_finite())).collect();
    let rows = data.select(&measured);
    if measured.is_empty() || configurations(&rows).iter().max().is_none_or(|last| last + 1 < CONFIGURATIONS)
    {
        return Ok(None);
    }
    let Some(placement) = placed(chain, &rows) else { return Ok(None) };
    let position_rms = placement.rms;
    let orientation_rms = orientation::rms(&placement.chain, data);
    Ok(Some(NominalResidual {
        placement,
        position_rms,
        orientation_rms,
        length: chain.characteristic_length(),
    }))
}

/// Base and tool where they fit the positions best.
fn placed(chain: &Chain, rows: &Dataset) -> Option<Placement> {
    let free = |placed: &Placed| Placed { known: false, ..*placed };
    let (base, tool) = (free(chain.base()), free(chain.tool()));
    let chain = chain.clone().with_base(base).and_then(|chain| chain.with_tool(tool)).ok()?;
    let mut positions = rows.clone();
    positions.orientation.fill(None);
    place(&chain, &positions).ok()
}

/// The likely mistakes behind what the nominal robot leaves: one about positions, one about orientations, or none.
pub fn misreadings(chain: &Chain, data: &Dataset, found: &NominalResidual) -> Vec<Misread> {
    let mut list = Vec::new();
    if found.share() > NEGLIGIBLE {
        list.extend(of_positions(chain, data));
    } else if found.orientation_rms.is_some_and(|rms| rms > TURNED) {
        list.extend(orientation::misread(&found.placement.chain, data));
    }
    list
}

fn of_positions(chain: &Chain, data: &Dataset) -> Option<Misread> {
    let measured: Vec<usize> =
        (0..data.len()).filter(|&row| data.position[row].iter().all(|v| v.is_finite())).collect();
    let few: Vec<usize> = measured.iter().step_by(measured.len().div_ceil(ROWS).max(1)).copied().collect();
    let rows = data.select(&few);
    let left = |chain: &Chain, rows: &Dataset| placed(chain, rows).map(|placement| placement.rms);
    let before = left(chain, &rows)?;
    let mut best: Option<Misread> = None;
    let mut judge = |what: Misreading, after: Option<f64>| {
        // Undone, the mistake leaves a robot that is worth a calibration.
        let good = after.filter(|&after| {
            after < GAIN * before && after < 5.0 * NEGLIGIBLE * chain.characteristic_length()
        });
        if let Some(after) = good
            && best.as_ref().is_none_or(|best| after < 0.8 * best.after)
        {
            best = Some(Misread { what, before, after });
        }
    };
    for what in variants::readings(chain) {
        let after = match variants::undone(&what, chain) {
            Some(other) => left(&other, &rows),
            None => {
                let mut other = rows.clone();
                variants::undo_joints(&what, &mut other);
                left(chain, &other)
            }
        };
        judge(what, after);
    }
    // A length of its own value fits more than a convention, so it comes last.
    for (joint, parameter) in variants::lengths(chain) {
        let place = |change: f64| Misreading::Length { joint, parameter, change };
        let step = 0.01 * chain.characteristic_length();
        let squared = |change: f64| {
            let what = place(change);
            left(&variants::undone(&what, chain)?, &rows).map(|rms| rms * rms)
        };
        let (Some(below), Some(above)) = (squared(-step), squared(step)) else { continue };
        let (slope, curvature) =
            ((above - below) / (2.0 * step), (above + below - 2.0 * before * before) / (step * step));
        if curvature <= 0.0 || slope * slope / (2.0 * curvature) < 0.5 * before * before {
            continue;
        }
        let mut change = -slope / curvature;
        // The square of the error is a parabola near its bottom: once more from there.
        if let (Some(at), Some(below), Some(above)) =
            (squared(change), squared(change - 0.1 * step), squared(change + 0.1 * step))
        {
            let near = 0.1 * step;
            let (slope, curvature) =
                ((above - below) / (2.0 * near), (above + below - 2.0 * at) / (near * near));
            if curvature > 0.0 {
                change -= slope / curvature;
            }
        }
        let after = squared(change).map(f64::sqrt);
        judge(place(change), after);
    }
    best
}

#[cfg(test)]
mod tests;
