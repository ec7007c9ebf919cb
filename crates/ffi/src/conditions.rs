//! Conditions of the caller, copied into memory that an arm already has.

use crate::border::numbers;
use crate::status::{TRUEPOSE_ERROR_ARGUMENT, TRUEPOSE_ERROR_LENGTH, TRUEPOSE_ERROR_NOT_FINITE};
use crate::structs::{TRUEPOSE_LOAD_NONE, TRUEPOSE_LOAD_PAYLOAD, TRUEPOSE_LOAD_WRENCH, truepose_conditions};
use nalgebra::Vector3;
use truepose_kinematics::{Conditions, Load, Payload, Wrench};

/// Replaces load, time, approach and channels; the lists keep their lengths.
///
/// # Safety
/// As for the lists of [`truepose_conditions`]: null, or as long as stated.
pub(crate) unsafe fn enter(given: Option<&truepose_conditions>, into: &mut Conditions) -> Result<(), i32> {
    let Some(given) = given else {
        into.load = Load::None;
        into.time = 0.0;
        into.approach.fill(0.0);
        return if into.channels.is_empty() { Ok(()) } else { Err(TRUEPOSE_ERROR_LENGTH) };
    };
    let finite = |values: &[f64]| values.iter().all(|v| v.is_finite());
    into.load = match given.load {
        TRUEPOSE_LOAD_NONE => Load::None,
        TRUEPOSE_LOAD_PAYLOAD => {
            let (mass, com) = (given.payload_mass, given.payload_com);
            if !finite(&[mass]) || !finite(&com) {
                return Err(TRUEPOSE_ERROR_NOT_FINITE);
            }
            if mass < 0.0 {
                return Err(TRUEPOSE_ERROR_ARGUMENT);
            }
            Load::Payload(Payload { mass, com: Vector3::from(com) })
        }
        TRUEPOSE_LOAD_WRENCH => {
            let [fx, fy, fz, mx, my, mz] = given.wrench;
            if !finite(&given.wrench) {
                return Err(TRUEPOSE_ERROR_NOT_FINITE);
            }
            Load::Wrench(Wrench { force: Vector3::new(fx, fy, fz), moment: Vector3::new(mx, my, mz) })
        }
        _ => return Err(TRUEPOSE_ERROR_ARGUMENT),
    };
    if !given.time.is_finite() {
        return Err(TRUEPOSE_ERROR_NOT_FINITE);
    }
    into.time = given.time;
    if given.approach.is_null() && given.approach_count == 0 {
        into.approach.fill(0.0);
    } else {
        // SAFETY: as long as stated, by the promise of the caller.
        let approach = unsafe { numbers(given.approach, given.approach_count, into.approach.len()) }?;
        into.approach.copy_from_slice(approach);
    }
    // SAFETY: as above.
    let channels = unsafe { numbers(given.channels, given.channel_count, into.channels.len()) }?;
    into.channels.copy_from_slice(channels);
    if finite(&into.approach) && finite(&into.channels) { Ok(()) } else { Err(TRUEPOSE_ERROR_NOT_FINITE) }
}
