//! Calibrates the SCARA and prints what was found.

use std::error::Error;
use std::io::Write;
use truepose_errormodel::FittedModel;
use truepose_errormodel::effects::Geometric;
use truepose_example_downstream::{Arm, EncoderGain, Measurement, calibrate, nominal, rms};

/// What was built in place of the drawing: links 0.3 mm longer and 0.2 mm shorter, offsets, and an encoder that loses 0.5 mrad a radian.
const BUILT: Arm = Arm { lengths: [0.3503, 0.2498], offsets: [1.0e-3, -0.8e-3], gain: 5e-4 };

fn main() -> Result<(), Box<dyn Error>> {
    let chain = nominal()?;
    let (fit_rows, fresh) = (measured(0..60), measured(60..90));
    let gain = || Box::new(EncoderGain { joint: chain.movable()[0] });
    let mut out = std::io::stdout().lock();

    let (nothing, _) = calibrate(&chain, Vec::new(), &fit_rows)?;
    let (constants, _) = calibrate(&chain, vec![Box::new(Geometric::default())], &fit_rows)?;
    let (both, rank) = calibrate(&chain, vec![Box::new(Geometric::default()), gain()], &fit_rows)?;
    writeln!(out, "RMS position error at 30 fresh poses, mm")?;
    let line = |name: &str, fitted: &FittedModel| -> Result<String, Box<dyn Error>> {
        Ok(format!("  {name:<30} {:.4}", 1e3 * rms(fitted, &fresh)?))
    };
    writeln!(out, "{}", line("as drawn", &nothing)?)?;
    writeln!(out, "{}", line("constant errors", &constants)?)?;
    writeln!(out, "{}", line("constant errors, encoder gain", &both)?)?;
    writeln!(out, "{rank} of {} coefficients are identifiable", both.coefficients().len())?;
    let gain = both.coefficients().last().copied().unwrap_or_default();
    writeln!(out, "gain of q1: {:.3} mrad/rad (built: {:.3})", 1e3 * gain, 1e3 * BUILT.gain)?;
    Ok(())
}

/// Poses of an additive recurrence (multiples of square roots modulo one), and where the built arm is there.
fn measured(range: std::ops::Range<u32>) -> Vec<Measurement> {
    let share = |k: u32, root: f64| (f64::from(k) * root.sqrt()).fract();
    range
        .map(|k| {
            let joints = [-2.2 + 4.4 * share(k, 2.0), -2.4 + 4.8 * share(k, 3.0), 0.15 * share(k, 5.0)];
            Measurement { joints, position: BUILT.position(joints) }
        })
        .collect()
}
