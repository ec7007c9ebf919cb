//! A 6R arm with full poses: W2, a linear calibration with joint compliance; W5, error Jacobians; W7, a nonlinear calibration.

use super::paper::PLAIN;
use super::{Residual, shared};
use crate::robots::{dataset, robot};
use crate::table::Table;
use crate::workload::{Bound, Declared, Failure, Way, Workload};
use std::path::Path;
use truepose_errormodel::effects::{Geometric, JointCompliance, Where};
use truepose_errormodel::lanes::{LANES, error_jacobians};
use truepose_errormodel::{AnyEffect, Dataset, ErrorModel};
use truepose_identify::{Way as By, plain};

fn model(folder: &Path, yields: bool) -> Result<ErrorModel, Failure> {
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

fn rows(folder: &Path, file: &str) -> Result<Dataset, Failure> {
    let mut data = dataset(&Table::read(&folder.join(file))?, 6, |_| true)?;
    data.target.fill(None);
    Ok(data)
}

fn linear(folder: &Path) -> Result<Way, Failure> {
    let (model, data) = (model(folder, true)?, rows(folder, "w2.csv")?);
    shared(move || {
        let found = plain(&model, &data, PLAIN, None, By::Guarded(1e6), 1)?;
        if !found.guarded {
            return Err("the guard refused".into());
        }
        Ok(Residual::of(&found.residuals(&model, &data, false)?).answer(found.kept.len()))
    })
}

fn nonlinear(folder: &Path) -> Result<Way, Failure> {
    let (model, data) = (model(folder, false)?, rows(folder, "w7.csv")?);
    shared(move || {
        let found = plain(&model, &data, PLAIN, None, By::Guarded(1e6), 12)?;
        if !(found.guarded && found.converged) {
            return Err("the guard refused, or it did not converge".into());
        }
        Ok(Residual::of(&found.residuals(&model, &data, true)?).answer(found.kept.len()))
    })
}

fn jacobians(folder: &Path) -> Result<Way, Failure> {
    let chain = robot(&folder.join("arm6r.json"))?;
    let joints = Table::read(&folder.join("w5.csv"))?.series("q", 1..7)?;
    let blocks = joints[0].len().div_ceil(LANES);
    let into = std::rc::Rc::new(std::cell::RefCell::new(vec![0.0; blocks * 36 * 6 * LANES]));
    let made = into.clone();
    let rows = joints[0].len();
    let run = move || {
        let columns: Vec<&[f64]> = joints.iter().map(Vec::as_slice).collect();
        Ok(error_jacobians(&chain, &columns, &mut made.borrow_mut())?)
    };
    let check = move || {
        // Postures that are not there fill the last block.
        let sum = |(row, numbers): (usize, &[f64])| -> f64 {
            let block = row / (36 * 6);
            let count = LANES.min(rows - block * LANES);
            numbers[..count].iter().map(|v| v.abs()).sum()
        };
        Ok([("checksum".into(), into.borrow().chunks_exact(LANES).enumerate().map(sum).sum())].into())
    };
    Ok(Way { run: Box::new(run), check: Box::new(check) })
}

/// A linear calibration with joint compliance.
pub const W2: Workload = Workload {
    name: "W2",
    about: "6R, 1 000 full poses, 54 columns with joint compliance",
    bound: Bound { flops: 19.6e6, bytes: 0.0 },
    agree: &[("rank", 9), ("rms_pos_um", 9), ("rms_rot_urad", 9)],
    ways: &[Declared { name: "gram", asked: &[("numba-gram", 0.4), ("numpy-gram", 0.4)], prepare: linear }],
};

/// A million error Jacobians.
pub const W5: Workload = Workload {
    name: "W5",
    about: "a million error Jacobians (6 × 36) into a warm buffer",
    bound: Bound { flops: 900e6, bytes: 1.728e9 },
    agree: &[("checksum", 9)],
    ways: &[Declared { name: "lanes", asked: &[("numba", 0.3), ("numpy", 0.3)], prepare: jacobians }],
};

/// A nonlinear calibration.
pub const W7: Workload = Workload {
    name: "W7",
    about: "nonlinear geometric calibration, 1 000 poses, 48 unknowns",
    bound: Bound { flops: 36e6, bytes: 0.0 },
    agree: &[("rank", 9), ("rms_pos_um", 9), ("rms_rot_urad", 9)],
    ways: &[Declared { name: "gram", asked: &[("numba-gn", 0.3), ("numpy-gn", 0.3)], prepare: nonlinear }],
};
