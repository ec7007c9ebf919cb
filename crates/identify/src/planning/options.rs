//! What to plan.

use truepose_kinematics::Load;

/// What to plan.
#[derive(Debug, Clone, PartialEq)]
pub struct PlanOptions {
    /// Visits.
    pub count: usize,
    /// Loads that can be put on; none of them: without a load.
    pub loads: Vec<Load>,
    /// Configurations among which is chosen.
    pub pool: usize,
    /// Seed of the pool.
    pub seed: u64,
}

impl Default for PlanOptions {
    fn default() -> Self {
        PlanOptions { count: 30, loads: Vec::new(), pool: 400, seed: 0 }
    }
}
