//! A plan in a few lines.

use crate::{count, millimetres, significant};
use serde::{Deserialize, Serialize};
use std::fmt;
use truepose_identify::{Plan, Why};

/// What a plan would bring.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct PlanSummary {
    /// Visits that show something new.
    pub new: usize,
    /// Visits that repeat others from the other side.
    pub repeats: usize,
    /// Expected 3-D RMS error that the coefficients leave where it matters, now, mm.
    pub now_mm: f64,
    /// With the plan, mm.
    pub then_mm: f64,
    /// Where rivals are told apart: Σ T, and the value that settles it.
    pub separation: Option<(f64, f64)>,
    /// O1–O5 (now, then), in units of today's deviations.
    pub observability: [(f64, f64); 5],
}

impl PlanSummary {
    /// Of a plan.
    pub fn new(plan: &Plan) -> Self {
        let repeats = plan.visits.iter().filter(|visit| visit.why == Why::Repeat).count();
        PlanSummary {
            new: plan.visits.len() - repeats,
            repeats,
            now_mm: plan.accuracy.0 * 1e3,
            then_mm: plan.accuracy.1 * 1e3,
            separation: plan.separation,
            observability: plan.observability,
        }
    }
}

impl fmt::Display for PlanSummary {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(
            f,
            "{} and {} from the other side",
            count(self.new, "new visit"),
            count(self.repeats, "repeat")
        )?;
        if let Some((total, settled)) = self.separation {
            let word = if total > settled { "enough to settle it" } else { "not enough to settle it" };
            writeln!(
                f,
                "the two explanations differ by T = {} over the plan; {} settles it at 99 %: {word}",
                significant(total, 3),
                significant(settled, 3)
            )?;
        }
        writeln!(
            f,
            "what the coefficients leave open after compensation, RMS: {} now, {} with the plan",
            millimetres(self.now_mm * 1e-3),
            millimetres(self.then_mm * 1e-3)
        )?;
        let words: Vec<String> = (1..)
            .zip(&self.observability)
            .map(|(k, (now, then))| format!("O{k} {} → {}", significant(*now, 3), significant(*then, 3)))
            .collect();
        writeln!(f, "{}", words.join("  "))
    }
}
