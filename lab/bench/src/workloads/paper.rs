//! W1: the paper's identification. 3 546 rows, 318 terms, rank 224.

use super::{Residual, shared};
use crate::prelude::*;
use truepose_errormodel::effects::{Polynomial, WrenchComponent};
use truepose_identify::{NoiseModel, Way as By, plain};
use truepose_solvers::RankRule;

/// The peers' 318 terms.
pub fn model(folder: &Path) -> Outcome<ErrorModel> {
    let mut polynomial = Polynomial::of(3, vec![WrenchComponent::Fy]);
    polynomial.small = vec![JointId(5), JointId(6)];
    Ok(ErrorModel::new(robot(&folder.join("pps.json"))?, vec![Box::new(polynomial)])?)
}

/// The rows that the peers fit.
pub fn rows(folder: &Path) -> Outcome<Dataset> {
    let table = Table::read(&folder.join("w1.csv"))?;
    let used = table.column("use")?.to_vec();
    dataset(&table, 6, |row| used[row] > 0.5)
}

/// Everything counts alike.
pub const PLAIN: NoiseModel = NoiseModel { position_sd: 1.0, visit_sd: 0.0, orientation_sd: 1.0 };

/// What the peers' rank rule is on columns of length one.
pub const STABLE: By = By::Stable(RankRule::Relative(1e-9));

fn way(folder: &Path, by: By) -> Outcome<Way> {
    let (model, data) = (model(folder)?, rows(folder)?);
    shared(move || {
        let found = plain(&model, &data, PLAIN, None, by, 1)?;
        if found.guarded != matches!(by, By::Guarded(_)) {
            return Err("the guard refused".into());
        }
        let residual = Residual::of(&found.residuals(&model, &data, false)?);
        Ok([("rank".into(), found.kept.len() as f64), ("rms_fit_um".into(), residual.position_um)].into())
    })
}

/// The paper's identification.
pub const W1: Workload = Workload::of(
    "W1",
    "the paper's identification, 3 546 rows, 318 terms",
    [374e6, 0.0],
    &[("rank", 9), ("rms_fit_um", 9)],
    &[
        Declared::of("gram", &[("numpy-gram", 0.7), ("numba-gram", 0.7)], |folder| {
            way(folder, By::Guarded(1e6))
        }),
        Declared::of("stable", &[("numpy-gram", 0.8), ("numba-gram", 0.8), ("numpy-qr", 0.4)], |folder| {
            way(folder, STABLE)
        }),
    ],
);
