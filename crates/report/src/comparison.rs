//! A comparison of solver strategies.

use crate::layout::Alignment::{Left, Right};
use crate::{PositionStatistics, significant, table, warning_text};
use serde::Serialize;
use std::fmt;
use truepose_identify::{Compared, Trial, Warning};

/// The strategies, one row each.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ComparisonSummary {
    /// Name of the robot.
    pub robot: String,
    /// How the folds of the cross-validation were made.
    pub held_out_by: String,
    /// The strategies, in the order of the options.
    pub strategies: Vec<StrategySummary>,
}

/// One strategy.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct StrategySummary {
    /// As it is chosen on the command line.
    pub solver: String,
    /// Its result.
    #[serde(flatten)]
    pub outcome: StrategyOutcome,
}

/// The result of a strategy, or why there is none.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[serde(untagged)]
pub enum StrategyOutcome {
    /// A fit.
    Fitted {
        /// On the data of the fit.
        train: PositionStatistics,
        /// On held-out configurations.
        held_out: PositionStatistics,
        /// Grouped errors.
        rank: usize,
        /// Coefficients that are not zero.
        nonzero: usize,
        /// Iterations of the fit.
        rounds: usize,
        /// Whether they converged.
        converged: bool,
        /// Wall time of the fit, s.
        seconds: f64,
        /// Held-out error (errors limited to three medians), divided by that of the first strategy.
        ratio: f64,
        /// Warnings: not converged, rejected, much worse than the first.
        warnings: Vec<String>,
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
    /// Summary of a comparison.
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
        ratio: trial.ratio,
        warnings: warnings(trial),
        p_value: trial.against_first.map(|p| p.p_value),
    }
}

/// Warnings that qualify the figures of a strategy.
fn warnings(trial: &Trial) -> Vec<String> {
    let relevant = |w: &&Warning| matches!(w, Warning::NotConverged { .. } | Warning::FellBack { .. });
    let mut list: Vec<String> = trial.fit.warnings.iter().filter(relevant).map(warning_text).collect();
    if trial.is_worse() {
        list.push(format!(
            "predicts held-out configurations WORSE than the first strategy, by a factor of {} (errors limited to three medians): do \
             not use it for this data",
            significant(trial.ratio, 3)
        ));
    }
    list
}

impl StrategySummary {
    /// Its name, marked where the fit did not converge.
    pub(crate) fn marked(&self) -> String {
        match &self.outcome {
            StrategyOutcome::Fitted { converged: false, .. } => format!("{}, NOT CONVERGED", self.solver),
            _ => self.solver.clone(),
        }
    }
}

impl ComparisonSummary {
    /// Each warning with the strategy that it is about.
    pub fn warnings(&self) -> Vec<String> {
        let of = |s: &StrategySummary| match &s.outcome {
            StrategyOutcome::Fitted { warnings, .. } => {
                warnings.iter().map(|words| format!("{}: {words}", s.solver)).collect()
            }
            StrategyOutcome::Failed { .. } => Vec::new(),
        };
        self.strategies.iter().flat_map(of).collect()
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
                    train, held_out, rank, nonzero, rounds, seconds, p_value, ..
                } => vec![
                    s.marked(),
                    significant(train.rms_mm, 4),
                    significant(held_out.rms_mm, 4),
                    p_value.map_or_else(|| "–".into(), |p| significant(p, 2)),
                    rank.to_string(),
                    nonzero.to_string(),
                    rounds.to_string(),
                    significant(seconds * 1e3, 3),
                ],
                StrategyOutcome::Failed { error } => vec![s.solver.clone(), format!("no fit: {error}")],
            })
            .collect();
        write!(
            f,
            "{}",
            table(
                &["solver", "training", "held out", "p", "rank", "not zero", "iterations", "ms"],
                &[Left, Right, Right, Right, Right, Right, Right, Right],
                &rows
            )
        )?;
        writeln!(
            f,
            " held out: {}; p: paired test of the squared errors against the first line",
            self.held_out_by
        )?;
        self.warnings().iter().try_for_each(|words| writeln!(f, "warning: {words}"))
    }
}
