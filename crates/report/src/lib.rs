#![doc = include_str!("../README.md")]

mod comparison;
mod discovery;
mod identification;
mod layout;
mod plan;
mod spread;
mod words;

pub use comparison::{ComparisonSummary, StrategyOutcome, StrategySummary};
pub use discovery::{
    AlternativeSummary, BeforeAfter, BothParts, DiscoverySummary, FindingSummary, LackOfFitSummary,
    NestedSummary, Reference, RefusedSummary, Settings, UnexplainedSummary, UntestableSummary,
};
pub use identification::{GroupSummary, IdentificationSummary, NoiseSummary, PlacementSummary, StageSummary};
pub use layout::{Alignment, table};
pub use plan::PlanSummary;
pub use spread::{PositionSpread, RotationSpread};
pub use words::{
    advice_words, count, millimetres, milliradians, significant, value_with_interval, warning_words,
};
