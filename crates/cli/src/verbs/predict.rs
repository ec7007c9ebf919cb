//! `truepose predict`: where the real robot is, from a fit.

use super::print_json;
use crate::args::Predict;
use crate::failure::Failure;
use crate::terminal;
use truepose_errormodel::EffectRegistry;
use truepose_identify::Residuals;
use truepose_io::{MeasurementsOptions, check_writable, read_fit, read_measurements, write_predictions};
use truepose_kinematics::Conditions;
use truepose_report::{PositionSpread, RotationSpread, count, significant};

/// Runs the verb.
pub fn run(args: &Predict) -> Result<(), Failure> {
    check_writable(&args.out)?;
    let fitted = read_fit(&args.fit, &EffectRegistry::builtin())?;
    let options = MeasurementsOptions { measured_required: false };
    let (data, info, warnings) = read_measurements(&args.data, fitted.chain(), &options)?;
    terminal::warn(&warnings);
    let inputs = data.derived_for(fitted.model())?;
    let mut predictor = fitted.bind(&inputs.schema)?;
    let mut conditions = Conditions::default();
    let mut predicted = Vec::with_capacity(data.len());
    for row in 0..data.len() {
        inputs.conditions_into(row, &mut conditions);
        predicted.push(predictor.predict(&conditions, data.target[row]));
    }
    write_predictions(&args.out, fitted.chain(), &data, &info, &predicted)?;

    let residuals = Residuals::of(&fitted, &data)?;
    let position: PositionSpread = residuals.positions().into();
    let orientation: RotationSpread = residuals.orientations().into();
    if args.json {
        return print_json(&serde_json::json!({
            "rows": data.len(), "position": position, "orientation": orientation,
        }));
    }
    terminal::print(&format!("{} predicted, written to {}\n", count(data.len(), "row"), args.out.display()));
    if position.count > 0 {
        terminal::print(&format!(
            "against the measured positions: RMS {} mm, 95 % {} mm, max {} mm ({})\n",
            significant(position.rms_mm, 4),
            significant(position.p95_mm, 4),
            significant(position.max_mm, 4),
            count(position.count, "row")
        ));
    }
    if orientation.count > 0 {
        terminal::print(&format!(
            "against the measured orientations: RMS {} mrad\n",
            significant(orientation.rms_mrad, 4)
        ));
    }
    Ok(())
}
