//! The next robot of a fleet: identified from few poses with its sisters as prior.
//!
//! It is the update of [`crate::transfer`] with the fleet's mean and scatter in place of one arm's coefficients and their covariance. Whether
//! its sisters help is seen on rows that no estimate has seen.

use crate::{Fleet, Installation, Transfer, TransferOptions, UpkeepError, transfer};
use truepose_errormodel::{Dataset, FittedModel};
use truepose_identify::{Folds, Residuals};
use truepose_kinematics::Chain;

/// A robot with its sisters as prior.
#[derive(Debug, Clone)]
pub struct Sister {
    /// The estimate from all rows.
    pub made: Transfer,
    /// Held-out residuals with the prior.
    pub held_out: Residuals,
    /// Held-out residuals without it, in the same folds; none where that could not be fitted.
    pub alone: Option<Residuals>,
}

impl Sister {
    /// Whether the prior predicts unseen rows better; so it is where nothing can be fitted without it.
    pub fn helps(&self) -> bool {
        self.alone.as_ref().is_none_or(|alone| self.held_out.positions().rms <= alone.positions().rms)
    }
}

/// Identifies `chain`, whose base, tool and targets are found where they are marked as unknown, from its sisters and its own rows. `alone`
/// identifies it from rows without them.
///
/// # Errors
/// When `chain` is not of the fleet's type, or the rows do not determine its installation.
pub fn sister(
    prior: &FittedModel,
    chain: &Chain,
    data: &Dataset,
    folds: &Folds,
    alone: &dyn Fn(&Dataset) -> Option<FittedModel>,
) -> Result<Sister, UpkeepError> {
    if prior.chain().joints() != chain.joints() {
        let why = "the robot is not of the type of the fleet: its joints are described otherwise".into();
        return Err(UpkeepError::Fleet { why });
    }
    let installation = Installation {
        base: !chain.base().known,
        tool: !chain.tool().known,
        targets: chain.targets().iter().any(|target| !target.known),
    };
    let options = TransferOptions { installation, update: true };
    let here = prior.on(chain.clone())?;
    let made = transfer(&here, data, options)?;
    let mut parts: Vec<(Vec<usize>, [Option<Residuals>; 2])> = Vec::new();
    for fold in 0..folds.count {
        let (out, rest): (Vec<usize>, Vec<usize>) =
            (0..data.len()).partition(|&row| folds.of_visit[data.visit[row]] == fold);
        let (out_rows, rest) = (data.select(&out), data.select(&rest));
        let with = Residuals::of(&transfer(&here, &rest, options)?.fitted, &out_rows)?;
        let without = alone(&rest).map(|fit| Residuals::of(&fit, &out_rows)).transpose()?;
        parts.push((out, [Some(with), without]));
    }
    let all = |which: usize| -> Option<Residuals> {
        let mut rows = Vec::new();
        for (out, of) in &parts {
            let of = of[which].as_ref()?;
            rows.extend(
                out.iter().copied().zip(of.position.iter().copied().zip(of.orientation.iter().copied())),
            );
        }
        rows.sort_by_key(|(row, _)| *row);
        let (position, orientation) = rows.into_iter().map(|(_, values)| values).unzip();
        Some(Residuals { position, orientation })
    };
    Ok(Sister { made, held_out: all(0).unwrap_or_default(), alone: all(1) })
}

impl Fleet {
    /// Standard deviation from robot to robot of each coefficient, in its unit.
    pub fn deviations(&self) -> Vec<f64> {
        let covariance = self.prior.covariance();
        (0..covariance.nrows()).map(|k| covariance[(k, k)].max(0.0).sqrt()).collect()
    }
}
