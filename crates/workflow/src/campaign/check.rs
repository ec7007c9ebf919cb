//! What rows seem to be, before anything is fitted.

use super::{Campaign, Inputs, Mistakes, Nominal, points, vertical};
use crate::error::WorkflowError;
use truepose_errormodel::effects::{AllTargets, Geometric, Where};
use truepose_errormodel::{AnyEffect, ErrorModel};
use truepose_identify::FitOptions;
use truepose_kinematics::Chain;
use truepose_solvers::PivotedQr;

/// Rows that were looked at.
#[derive(Debug)]
pub struct CheckedRows {
    /// The robot, with what its description leaves open as unknown.
    pub chain: Chain,
    /// That in words.
    pub assumed: Vec<String>,
    /// What seems wrong.
    pub warnings: Vec<String>,
    /// Why a fit would refuse the rows: several points are read as one.
    pub several_points: Option<WorkflowError>,
    /// The robot as it is described, with the rows.
    pub nominal: Nominal,
}

/// Looks at rows without fitting the declared model.
///
/// # Errors
/// When sessions or landmarks cannot be placed, or the rows lack a signal of the model.
pub fn check_rows(inputs: Inputs, model: Option<&ErrorModel>) -> Result<CheckedRows, WorkflowError> {
    let Inputs { chain, details, beside, undeclared, data, info, .. } = inputs;
    let opened = undeclared.unknown(&chain, &data)?;
    let (chain, assumed) = opened.map_or_else(|| (chain, Vec::new()), |(chain, words)| (chain, vec![words]));
    let (solver, options) = (PivotedQr::default(), FitOptions::default());
    let fitting = (&solver as _, &options);
    let installation: Vec<Box<dyn AnyEffect>> = vec![Box::new(tool(&chain))];
    let campaign = Campaign::of(beside, chain.clone(), installation, data, &info, fitting)?;
    let (placed, data, mut warnings) = (&campaign.chain, &campaign.data, campaign.remarks.clone());
    let several_points = match points::one_point(placed, data, &info) {
        Ok(warning) => {
            warnings.extend(warning);
            None
        }
        Err(error) => Some(error),
    };
    let mistakes = Mistakes::of(placed, data, &info.file);
    warnings.extend(mistakes.words);
    if let Some(model) = model {
        model.bind(&data.derived_for(model)?.schema)?;
    }
    // Where no fit can be made, another message is about that.
    if info.landmarks.is_empty() && !details.gravity {
        let whole: [Box<dyn AnyEffect>; 1] = [Box::new(Geometric::default())];
        let found = vertical::settled(placed, &whole, data, fitting).ok().flatten();
        warnings.extend(found.map(|(_, words)| words));
    }
    Ok(CheckedRows { chain, assumed, warnings, several_points, nominal: mistakes.nominal })
}

/// Errors of the tool and of the targets: what landmarks can be found with.
fn tool(chain: &Chain) -> Geometric {
    let mut frames = vec![Where::Frame(chain.tool_frame())];
    if !chain.targets().is_empty() {
        frames.push(Where::Targets(AllTargets::All));
    }
    Geometric { frames: Some(frames), components: None }
}
