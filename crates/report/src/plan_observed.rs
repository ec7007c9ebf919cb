//! A plan at landmarks and sensors in a few lines.

use crate::plan::indices;
use crate::{count, millimetres};
use serde::{Deserialize, Serialize};
use std::fmt;
use truepose_identify::ObservedPlan;

/// The expected benefit of a plan at landmarks and sensors.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ObservedPlanSummary {
    /// Pose measurements.
    pub new: usize,
    /// Landmarks and sensors with the number of pose measurements at each, in the order of their names.
    pub at: Vec<(String, usize)>,
    /// Expected 3-D RMS error from the uncertainty of the coefficients, at the poses of interest, now, mm: the part that such rows can tell.
    pub now_mm: f64,
    /// The same with the plan, mm.
    pub then_mm: f64,
    /// The same with as many pose measurements drawn at random, mm.
    pub at_random_mm: f64,
    /// What no number of such rows tells, mm.
    pub beyond_mm: f64,
    /// O1–O5 (now, then), in units of today's deviations.
    pub observability: [(f64, f64); 5],
    /// What nothing was planned for, and why.
    pub left_out: Vec<(String, String)>,
    /// Whether the postures were drawn, without knowledge of what they would collide with.
    pub drawn: bool,
}

impl ObservedPlanSummary {
    /// Summary of a plan; `at`: what each pose measurement observes.
    pub fn new(
        plan: &ObservedPlan,
        at: &[Vec<String>],
        left_out: Vec<(String, String)>,
        drawn: bool,
    ) -> Self {
        let mut names: Vec<&String> = at.iter().flatten().filter(|name| !name.is_empty()).collect();
        names.sort_unstable();
        names.dedup();
        let visits = |name: &String| at.iter().filter(|visit| visit.contains(name)).count();
        ObservedPlanSummary {
            new: plan.visits.len(),
            at: names.into_iter().map(|name| (name.clone(), visits(name))).collect(),
            now_mm: plan.accuracy.0 * 1e3,
            then_mm: plan.accuracy.1 * 1e3,
            at_random_mm: plan.at_random * 1e3,
            beyond_mm: plan.beyond * 1e3,
            observability: plan.observability,
            left_out,
            drawn,
        }
    }
}

impl fmt::Display for ObservedPlanSummary {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let at: Vec<String> = self.at.iter().map(|(name, visits)| format!("{name} {visits}")).collect();
        writeln!(f, "{}: {}", count(self.new, "new pose measurement"), at.join(", "))?;
        writeln!(
            f,
            "expected position error after compensation, from the uncertainty of the coefficients (RMS): {} now, {} with the plan, {} with as many at random",
            millimetres(self.now_mm * 1e-3),
            millimetres(self.then_mm * 1e-3),
            millimetres(self.at_random_mm * 1e-3)
        )?;
        if self.beyond_mm > 0.01 * self.now_mm {
            writeln!(
                f,
                "beside it {} that no number of such rows tells: of a base, a tool or a scale that they do not see",
                millimetres(self.beyond_mm * 1e-3)
            )?;
        }
        writeln!(f, "{}", indices(&self.observability))?;
        for (name, why) in &self.left_out {
            writeln!(f, "not planned: {name}: {why}")?;
        }
        if self.drawn {
            writeln!(
                f,
                "The postures lie within the joints' ranges; what they collide with is not known. Give the postures that your cell allows with --among."
            )?;
        }
        Ok(())
    }
}
