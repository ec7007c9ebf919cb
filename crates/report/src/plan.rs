//! A plan in a few lines.

use crate::{count, millimetres, significant};
use serde::{Deserialize, Serialize};
use std::fmt;
use truepose_identify::{Plan, Why};

/// The expected benefit of a plan.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct PlanSummary {
    /// New pose measurements.
    pub new: usize,
    /// Repeated pose measurements, approached from the opposite direction.
    pub repeats: usize,
    /// Expected 3-D RMS error from the uncertainty of the coefficients, at the poses of interest, now, mm.
    pub now_mm: f64,
    /// The same with the plan, mm.
    pub then_mm: f64,
    /// With a competing hypothesis: the discrimination statistic Σ T, and its critical value.
    pub separation: Option<(f64, f64)>,
    /// O1–O5 (now, then), in units of today's deviations.
    pub observability: [(f64, f64); 5],
}

impl PlanSummary {
    /// Summary of a plan.
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
            "{} and {} with the opposite direction of approach",
            count(self.new, "new pose measurement"),
            count(self.repeats, "repeat")
        )?;
        if let Some((total, critical)) = self.separation {
            let conclusion = if total > critical { "sufficient" } else { "not sufficient" };
            writeln!(
                f,
                "discrimination of the two hypotheses: T = {} with the plan, critical value {} (99 %): {conclusion}",
                significant(total, 3),
                significant(critical, 3)
            )?;
        }
        writeln!(
            f,
            "expected position error after compensation, from the uncertainty of the coefficients (RMS): {} now, {} with the plan",
            millimetres(self.now_mm * 1e-3),
            millimetres(self.then_mm * 1e-3)
        )?;
        writeln!(f, "{}", indices(&self.observability))
    }
}

/// O1–O5, now and then.
pub(crate) fn indices(observability: &[(f64, f64); 5]) -> String {
    let each = (1..).zip(observability);
    let words =
        each.map(|(k, (now, then))| format!("O{k} {} → {}", significant(*now, 3), significant(*then, 3)));
    words.collect::<Vec<String>>().join("  ")
}
