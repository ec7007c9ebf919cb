//! Solver strategies side by side.

use crate::layout::Alignment::{Left, Right};
use crate::{PositionSpread, significant, table};
use serde::Serialize;
use std::fmt;
use truepose_identify::{Compared, Trial};

/// A row a strategy.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ComparisonSummary {
    /// Name of the robot.
    pub robot: String,
    /// How the held-out columns were made.
    pub held_out_by: String,
    /// The strategies, in the order in which they were asked for.
    pub strategies: Vec<StrategySummary>,
}

/// One strategy.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct StrategySummary {
    /// As it is chosen on the command line.
    pub solver: String,
    /// What it reached.
    #[serde(flatten)]
    pub outcome: StrategyOutcome,
}

/// What a strategy reached, or why it did not.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[serde(untagged)]
pub enum StrategyOutcome {
    /// A fit.
    Fitted {
        /// On the data of the fit.
        train: PositionSpread,
        /// On held-out configurations.
        held_out: PositionSpread,
        /// Grouped errors.
        rank: usize,
        /// Coefficients that are not zero.
        nonzero: usize,
        /// Rounds of the fit.
        rounds: usize,
        /// Whether they came to rest.
        converged: bool,
        /// Wall time of the fit, s.
        seconds: f64,
        /// Two-sided p-value of the paired difference to the first strategy; null for that one.
        p_value: Option<f64>,
    },
    /// No fit.
    Failed {
        /// Why.
        error: String,
    },
}

impl ComparisonSummary {
    /// Of a comparison.
    pub fn new(robot: &str, held_out_by: String, compared: &[Compared]) -> Self {
        let strategies = compared
            .iter()
            .map(|c| StrategySummary {
                solver: c.name.clone(),
                outcome: match &c.outcome {
                    Ok(trial) => fitted(trial),
                    Err(error) => StrategyOutcome::Failed { error: error.to_string() },
                },
            })
            .collect();
        ComparisonSummary { robot: robot.into(), held_out_by, strategies }
    }
}

fn fitted(trial: &Trial) -> StrategyOutcome {
    let fit = &trial.fit;
    StrategyOutcome::Fitted {
        train: fit.positions().into(),
        held_out: trial.held_out.residuals.positions().into(),
        rank: fit.reduction.rank(),
        nonzero: fit.fitted.coefficients().iter().filter(|c| c.abs() > 0.0).count(),
        rounds: fit.rounds,
        converged: fit.converged,
        seconds: trial.seconds,
        p_value: trial.against_first.map(|p| p.p_value),
    }
}

impl fmt::Display for ComparisonSummary {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "{}: solver strategies, RMS of the 3-D position error in mm", self.robot)?;
        let rows: Vec<Vec<String>> = self
            .strategies
            .iter()
            .map(|s| match &s.outcome {
                StrategyOutcome::Fitted {
                    train,
                    held_out,
                    rank,
                    nonzero,
                    rounds,
                    converged,
                    seconds,
                    p_value,
                } => vec![
                    s.solver.clone(),
                    significant(train.rms_mm, 4),
                    significant(held_out.rms_mm, 4),
                    p_value.map_or_else(|| "–".into(), |p| significant(p, 2)),
                    rank.to_string(),
                    nonzero.to_string(),
                    format!("{rounds}{}", if *converged { "" } else { " (still moving)" }),
                    significant(seconds * 1e3, 3),
                ],
                StrategyOutcome::Failed { error } => vec![s.solver.clone(), format!("no answer: {error}")],
            })
            .collect();
        write!(
            f,
            "{}",
            table(
                &["solver", "train", "held out", "p", "rank", "not zero", "rounds", "ms"],
                &[Left, Right, Right, Right, Right, Right, Right, Right],
                &rows
            )
        )?;
        writeln!(
            f,
            " held out: {}; p: paired difference of squared errors to the first line",
            self.held_out_by
        )
    }
}
