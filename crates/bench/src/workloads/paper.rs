//! W1: the paper's identification. 3 546 rows, 318 terms, rank 224.

use crate::robots::{dataset, robot};
use crate::table::Table;
use crate::workload::{Answer, Bound, Declared, Failure, Way, Workload};
use std::path::Path;
use truepose_errormodel::effects::{Polynomial, WrenchComponent};
use truepose_errormodel::{Dataset, ErrorModel, Visits};
use truepose_identify::{NoiseModel, factorise, gram};
use truepose_kinematics::JointId;
use truepose_solvers::{ColumnScale, RankRule};

/// The peers' 318 terms.
pub fn model(folder: &Path) -> Result<ErrorModel, Failure> {
    let mut polynomial = Polynomial::of(3, vec![WrenchComponent::Fy]);
    polynomial.small = vec![JointId(5), JointId(6)];
    Ok(ErrorModel::new(robot(&folder.join("pps.json"))?, vec![Box::new(polynomial)])?)
}

/// The rows that the peers fit.
pub fn rows(folder: &Path, used: bool) -> Result<Dataset, Failure> {
    let table = Table::read(&folder.join("w1.csv"))?;
    let column = table.column("use")?.to_vec();
    dataset(&table, 6, |row| (column[row] > 0.5) == used)
}

/// Everything counts alike.
pub const PLAIN: NoiseModel = NoiseModel { position_sd: 1.0, visit_sd: 0.0, orientation_sd: 1.0 };

/// 3-D RMS of the residual at these coefficients, µm.
pub fn rms_um(_model: &ErrorModel, data: &Dataset, squares: f64) -> f64 {
    1e6 * (squares / data.len() as f64).sqrt()
}

fn stable(folder: &Path) -> Result<Way, Failure> {
    let (model, data) = (model(folder)?, rows(folder, true)?);
    let state = std::rc::Rc::new(std::cell::RefCell::new((0.0, 0.0)));
    let kept = state.clone();
    let run = move || {
        let visits = Visits::of(&data);
        let zero = vec![0.0; model.columns().len()];
        let factor = factorise(&model, &data, &visits, PLAIN, &zero, None)?;
        let solution = factor.solve_pivoted(0, ColumnScale::Norms, RankRule::Relative(1e-9))?;
        *kept.borrow_mut() =
            (solution.rank as f64, rms_um(&model, &data, solution.info.residual_norm.powi(2)));
        Ok(())
    };
    let check = move || {
        let (rank, rms) = *state.borrow();
        Ok(Answer::from([("rank".into(), rank), ("rms_fit_um".into(), rms)]))
    };
    Ok(Way { run: Box::new(run), check: Box::new(check) })
}

fn guarded(folder: &Path) -> Result<Way, Failure> {
    let (model, data) = (model(folder)?, rows(folder, true)?);
    let state = std::rc::Rc::new(std::cell::RefCell::new((0.0, 0.0)));
    let kept = state.clone();
    let run = move || {
        let visits = Visits::of(&data);
        let zero = vec![0.0; model.columns().len()];
        let gram = gram(&model, &data, &visits, PLAIN, &zero, None)?;
        let solution = gram.solve_guarded(0, 1e6)?.ok_or("the guard refused")?;
        if std::env::var_os("SHOW").is_some() { eprintln!("{:?}", solution.info.rank_decision); }
        *kept.borrow_mut() =
            (solution.rank as f64, rms_um(&model, &data, solution.info.residual_norm.powi(2)));
        Ok(())
    };
    let check = move || {
        let (rank, rms) = *state.borrow();
        Ok(Answer::from([("rank".into(), rank), ("rms_fit_um".into(), rms)]))
    };
    Ok(Way { run: Box::new(run), check: Box::new(check) })
}

/// The paper's identification.
pub const W1: Workload = Workload {
    name: "W1",
    about: "the paper's identification, 3 546 rows, 318 terms",
    bound: Bound { flops: 374e6, bytes: 0.0 },
    agree: &[("rank", 9), ("rms_fit_um", 9)],
    ways: &[Declared { name: "gram", asked: &[("numpy-gram", 0.7)], prepare: guarded }, Declared { name: "stable", asked: &[("numpy-gram", 1.2), ("numpy-qr", 0.4)], prepare: stable }],
};
