//! W3: the paper's model over many points, in memory.

use super::paper::{PLAIN, STABLE, model, rows};
use super::{Residual, shared_with};
use crate::robots::dataset;
use crate::table::Table;
use crate::workload::{Answer, Bound, Declared, Failure, Way, Workload};
use std::path::Path;
use truepose_errormodel::Dataset;
use truepose_identify::{Way as By, left_over, plain};

/// The columns that W1's rows tell apart: chosen once, as the peers choose theirs.
pub fn columns(folder: &Path) -> Result<Vec<usize>, Failure> {
    Ok(plain(&model(folder)?, &rows(folder)?, PLAIN, None, STABLE, 1)?.kept)
}

fn way(folder: &Path, file: &str, by: By) -> Result<Way, Failure> {
    let (model, kept) = (model(folder)?, columns(folder)?);
    let data: Dataset = dataset(&Table::read(&folder.join(file))?, 6, |_| true)?;
    let (also, again) = (model.clone(), data.clone());
    let run = move || {
        let found = plain(&model, &data, PLAIN, Some(&kept), by, 1)?;
        match found.guarded == matches!(by, By::Guarded(_)) {
            true => Ok(found),
            false => Err("the guard refused".into()),
        }
    };
    shared_with(run, move |found| {
        let zero = vec![0.0; found.coefficients.len()];
        let residual = Residual::of(&left_over(&also, &again, &zero, &found.coefficients)?);
        Ok(Answer::from([
            ("rank".into(), found.kept.len() as f64),
            ("rms_fit_um".into(), residual.position_um),
        ]))
    })
}

const fn bound(points: f64) -> Bound {
    let r = 224.0;
    Bound { flops: points * (3.0 * r * (r + 1.0) + 9.0 * r + 900.0) + r * r * r / 3.0, bytes: points * 88.0 }
}

/// 200 000 points.
pub const W3_200K: Workload = Workload {
    name: "W3-200k",
    about: "200 000 points, 224 columns, in memory",
    bound: bound(2e5),
    agree: &[("rank", 9), ("rms_fit_um", 9)],
    ways: &[Declared {
        name: "gram",
        asked: &[("numba-chunk", 0.7), ("numpy-chunk", 0.7)],
        prepare: |folder| way(folder, "w3_200k.csv", By::Guarded(1e6)),
    }],
};

/// A million.
pub const W3_1M: Workload = Workload {
    name: "W3-1m",
    about: "1 000 000 points, 224 columns, in memory",
    bound: bound(1e6),
    agree: &[("rank", 9), ("rms_fit_um", 9)],
    ways: &[Declared {
        name: "gram",
        asked: &[("numba-chunk", 0.7), ("numpy-chunk", 0.7)],
        prepare: |folder| way(folder, "w3_1m.csv", By::Guarded(1e6)),
    }],
};
