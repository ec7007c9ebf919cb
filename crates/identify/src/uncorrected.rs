//! Errors at unseen rows of the robot as it is, and with corrected constants alone: what is left where no command is corrected.

use crate::identification::{installation, nominal_residuals};
use crate::{Fit, FitOptions, Folds, IdentifyError, Placement, Residuals, Split, fit};
use nalgebra::Vector3;
use truepose_errormodel::effects::{Geometric, Landmarks, Observed, Session};
use truepose_errormodel::{AnyEffect, Dataset, Effect, ErrorModel, configurations};
use truepose_solvers::PivotedQr;

/// Folds where no test set was drawn.
const FOLDS: usize = 5;

/// Errors at unseen rows, in their order.
#[derive(Debug, Clone)]
pub struct Uncorrected {
    /// Of the arm as it is described.
    pub as_is: Residuals,
    /// Whether base and tool are as described as well; otherwise they are fitted.
    pub described: bool,
    /// With the constants of the model (geometric errors) alone; none where the model has nothing else.
    pub constants: Option<Residuals>,
}

/// Errors at the rows `held` of a robot whose commands are not corrected. The model has these effects; fits are of `data` without the rows
/// that they predict.
///
/// # Errors
/// When the robot does not fit the data.
pub fn uncorrected(
    placement: &Placement,
    effects: &[Box<dyn AnyEffect>],
    (data, held): (&Dataset, &[usize]),
    options: &FitOptions,
) -> Result<Uncorrected, IdentifyError> {
    let placed = &placement.chain;
    let described = placement.found.is_empty();
    let parts = parts(data, held)?;
    let unseen = |effects: &dyn Fn() -> Vec<Box<dyn AnyEffect>>| -> Result<Residuals, IdentifyError> {
        let mut all = Residuals {
            position: vec![Vector3::repeat(f64::NAN); data.len()],
            orientation: vec![None; data.len()],
        };
        for [train, judged] in &parts {
            let model = ErrorModel::new(placed.clone(), effects())?;
            let Fit { fitted, .. } = fit(&model, &data.select(train), &PivotedQr::default(), options)?;
            let errors = Residuals::of(&fitted, &data.select(judged))?;
            for ((&row, position), orientation) in judged.iter().zip(errors.position).zip(errors.orientation)
            {
                (all.position[row], all.orientation[row]) = (position, orientation);
            }
        }
        Ok(Residuals {
            position: held.iter().map(|&row| all.position[row]).collect(),
            orientation: held.iter().map(|&row| all.orientation[row]).collect(),
        })
    };
    let as_is = match described {
        true => nominal_residuals(placed, &data.select(held))?,
        false => unseen(&|| installation(placed, effects, data))?,
    };
    let constant: Vec<_> = effects.iter().filter(|effect| is_constant(&***effect)).collect();
    let constants = match constant.len() == effects.len() {
        true => None,
        false if constant.iter().any(|effect| effect.kind() == Geometric::FAMILY) => {
            Some(unseen(&|| constant.iter().map(|effect| (**effect).clone()).collect())?)
        }
        false => Some(unseen(&|| installation(placed, effects, data))?),
    };
    Ok(Uncorrected { as_is, described, constants })
}

/// Whether an effect is a constant of the robot or of its installation, which a controller can have.
fn is_constant(effect: &dyn AnyEffect) -> bool {
    [Geometric::FAMILY, Session::FAMILY, Landmarks::FAMILY, Observed::FAMILY].contains(&effect.kind())
}

/// Rows of a fit, and those that it predicts: the test set, or folds where all rows are predicted.
fn parts(data: &Dataset, held: &[usize]) -> Result<Vec<[Vec<usize>; 2]>, IdentifyError> {
    let mut judged = vec![false; data.len()];
    held.iter().for_each(|&row| judged[row] = true);
    let rest =
        |judged: &dyn Fn(usize) -> bool| (0..data.len()).filter(|&row| !judged(row)).collect::<Vec<_>>();
    if judged.contains(&false) {
        return Ok(vec![[rest(&|row| judged[row]), held.to_vec()]]);
    }
    let poses = configurations(data).iter().max().map_or(0, |last| last + 1);
    let folds = Folds::new(data, &Split::Random { folds: FOLDS.min(poses), seed: 0 })?;
    let of = |fold: usize| {
        let own = |row: usize| folds.of_visit[data.visit[row]] == fold;
        [rest(&own), (0..data.len()).filter(|&row| own(row)).collect()]
    };
    Ok((0..folds.count).map(of).collect())
}
