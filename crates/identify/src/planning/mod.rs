//! What to measure next.

mod accuracy;
mod choose;
mod discriminate;
mod options;
mod pool;

pub use choose::{Plan, Planned, Why, plan};
pub use options::PlanOptions;
