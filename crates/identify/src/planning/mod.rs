//! What to measure next.

mod accuracy;
mod choose;
mod discriminate;
mod observed;
mod options;
mod pool;
mod reach;
mod view;

pub use choose::{Plan, Planned, Why, plan};
pub use observed::{ObservedPlan, ObservedVisit, plan_observed};
pub use options::PlanOptions;
pub use reach::{Within, within_reach};
