//! The rows that a fit holds of its data, as they would have been measured in another installation.
//!
//! ```text
//! p' = p_there + R (p − p_here),     R = R_B,there R_B,hereᵀ
//! ```
//!
//! with p_here and p_there the predictions of the fit in both installations: what the model left stays left, in the axes of the new base.
//! Exports hold their files against these rows.

use crate::UpkeepError;
use truepose_errormodel::{FittedModel, Sample};
use truepose_kinematics::{Conditions, Pose, rotation_log, rotation_vector};

/// The sample of `here`, measured `there`.
pub(crate) fn carried(here: &FittedModel, there: &FittedModel) -> Result<Sample, UpkeepError> {
    let sample = &here.domain.sample;
    let mut rows = sample.rows().clone();
    if rows.is_empty() {
        return Ok(sample.clone());
    }
    let turn = there.chain().base().pose.rotation * here.chain().base().pose.rotation.transpose();
    let (mut before, mut after) = (here.bind(&rows.schema)?, there.bind(&rows.schema)?);
    let mut conditions = Conditions::default();
    for row in 0..rows.len() {
        rows.conditions_into(row, &mut conditions);
        let [old, new] = [&mut before, &mut after].map(|of| of.predict(&conditions, rows.target[row]));
        // A component that was not measured has no axes to be turned with: its row keeps none of the three.
        rows.position[row] =
            (new.translation + turn * (rows.measured_position(row) - old.translation)).into();
        rows.orientation[row] = rows.measured_rotation(row).map(|measured| {
            let left = turn * rotation_log(&(measured * old.rotation.transpose()));
            Pose::new(rotation_vector(&left) * new.rotation, new.translation).quaternion()
        });
    }
    Ok(Sample::stored(rows, sample.drawn_from()))
}
