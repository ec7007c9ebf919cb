//! A 6R arm with full poses: W2, a linear calibration with joint compliance; W7, a nonlinear calibration.

use super::paper::PLAIN;
use super::{Residual, shared};
use crate::prelude::*;
use truepose_errormodel::effects::Where;
use truepose_identify::{Way as By, plain};

fn model(folder: &Path, yields: bool) -> Outcome<ErrorModel> {
    let chain = robot(&folder.join("arm6r.json"))?;
    let chain = chain.with_targets(Vec::new())?;
    let frames = chain.frames().map(Where::Frame).collect();
    let mut effects: Vec<Box<dyn AnyEffect>> =
        vec![Box::new(Geometric { frames: Some(frames), components: None })];
    if yields {
        effects.push(Box::new(JointCompliance::default()));
    }
    Ok(ErrorModel::new(chain, effects)?)
}

fn rows(folder: &Path, file: &str) -> Outcome<Dataset> {
    let mut data = rows_of(folder, file)?;
    data.target.fill(None);
    Ok(data)
}

fn linear(folder: &Path) -> Outcome<Way> {
    let (model, data) = (model(folder, true)?, rows(folder, "w2.csv")?);
    shared(move || {
        let found = plain(&model, &data, PLAIN, None, By::Guarded(1e6), 1)?;
        if !found.guarded {
            return Err("the guard refused".into());
        }
        Ok(Residual::of(&found.residuals(&model, &data, false)?).answer(found.kept.len()))
    })
}

fn nonlinear(folder: &Path) -> Outcome<Way> {
    let (model, data) = (model(folder, false)?, rows(folder, "w7.csv")?);
    shared(move || {
        let found = plain(&model, &data, PLAIN, None, By::Guarded(1e6), 12)?;
        if !(found.guarded && found.converged) {
            return Err("the guard refused, or it did not converge".into());
        }
        Ok(Residual::of(&found.residuals(&model, &data, true)?).answer(found.kept.len()))
    })
}

/// A linear calibration with joint compliance.
pub const W2: Workload = Workload::of(
    "W2",
    "6R, 1 000 full poses, 54 columns with joint compliance",
    [19.6e6, 0.0],
    &[("rank", 9), ("rms_pos_um", 9), ("rms_rot_urad", 9)],
    &[Declared::of("gram", &[("numba-gram", 0.4), ("numpy-gram", 0.4)], linear)],
);

/// A nonlinear calibration.
pub const W7: Workload = Workload::of(
    "W7",
    "nonlinear geometric calibration, 1 000 poses, 48 unknowns",
    [36e6, 0.0],
    &[("rank", 9), ("rms_pos_um", 9), ("rms_rot_urad", 9)],
    &[Declared::of("gram", &[("numba-gn", 0.3), ("numpy-gn", 0.3)], nonlinear)],
);
