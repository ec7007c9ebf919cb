#![doc = include_str!("../README.md")]

mod comparison;
mod discovery;
mod figure;
mod identification;
mod layout;
mod page;
mod plan;
mod poses;
mod run;
mod specification;
mod spread;
mod streamed;
mod suspicion;
mod words;

pub use comparison::{ComparisonSummary, StrategyOutcome, StrategySummary};
pub use discovery::{
    AlternativeSummary, BeforeAfter, BothParts, DiscoverySummary, FindingSummary, LackOfFitSummary,
    NestedSummary, Reference, RefusedSummary, Settings, UnexplainedSummary, UntestableSummary,
};
pub use identification::{
    GroupSummary, IdentificationSummary, NoiseSummary, PlacementSummary, ShapeSummary, StageSummary,
};
pub use layout::{Alignment, table};
pub use page::{
    CommandView, CommandsView, Report, commands_report, comparison_report, discovery_report,
    identification_report,
};
pub use plan::PlanSummary;
pub use poses::worst_of_poses;
pub use run::{FileRecord, RunRecord};
pub use specification::{SpecificationSummary, Verdict};
pub use spread::{PositionSpread, RotationSpread};
pub use streamed::StreamedSummary;
pub use suspicion::suspicion_words;
pub use words::{
    advice_words, count, millimetres, milliradians, parameter_words, significant, value_with_interval,
    warning_words,
};
