//! Gravity that a robot's description does not state.

use super::Fitting;
use truepose_errormodel::{AnyEffect, Dataset};
use truepose_identify::{IdentifyError, Vertical, vertical};
use truepose_kinematics::{Chain, GravityFrame};
use truepose_report::significant;

/// The robot with the direction that its measurements support, and which it is; `None` where both possible ones agree, or nothing is heavy.
///
/// # Errors
/// When base and tool cannot be found, or a fit fails.
pub(super) fn settled(
    chain: &Chain,
    effects: &[Box<dyn AnyEffect>],
    data: &Dataset,
    fit: Fitting<'_>,
) -> Result<Option<(Chain, String)>, IdentifyError> {
    let Some(found) = vertical(chain, effects, data, fit)? else { return Ok(None) };
    Ok(Some((found.applied(chain)?, words(chain.name(), &found))))
}

fn words(robot: &str, found: &Vertical) -> String {
    let Vertical { angle, frame, rms, clear } = found;
    let mm = |rms: f64| significant(1e3 * rms, 3);
    let (taken, key) = match frame {
        GravityFrame::Measurement => ("measurement frame", "measurement"),
        GravityFrame::Base => ("base", "base"),
    };
    let decided = match clear {
        true => format!("that of the {taken} is used, which explains the measurements"),
        false => {
            "that of the measurement frame is used, and the measurements do not tell which is right".into()
        }
    };
    format!(
        "{robot}: gravity is not declared, and −z of the base is {:.0}° from −z of the measurement frame: {decided} (with yielding joints, held-out RMS {} mm with that of the measurement frame, {} mm with that of the base); declare `gravity_frame = \"{}\"`{}",
        angle.to_degrees(),
        mm(rms[0]),
        mm(rms[1]),
        key,
        if *clear { "" } else { " or `\"base\"`" }
    )
}
