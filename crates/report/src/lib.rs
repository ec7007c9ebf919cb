#![doc = include_str!("../README.md")]

mod acceptance;
mod comparison;
mod correction;
mod data_check;
mod discovery;
mod document;
mod explanation;
mod figure;
mod identification;
mod kinds;
mod landmarks;
mod largest;
mod layout;
mod observers;
mod page;
mod parameters;
mod partial;
mod plan;
mod plan_observed;
mod poses;
mod run;
mod sessions;
mod specification;
mod specification_cases;
mod statistics;
mod streamed;
mod suspicion;
mod upkeep;
mod wording;

pub use acceptance::{
    AcceptanceSummary, BudgetSummary, ComplianceSummary, ContributionSummary, FigureSummary, Limit,
    PathSummary, PoseDistanceSummary, StateSummary, TestPoseSummary, VerdictSummary,
};
pub use comparison::ComparisonSummary;
pub use correction::Correction;
pub use data_check::DataCheck;
pub use discovery::{
    AlternativeSummary, DiscoverySettings, DiscoverySummary, FindingSummary, NestedSummary, TooFewPoses,
};
pub use explanation::explanation;
pub use identification::{IdentificationSummary, StageSummary};
pub use kinds::KindsSummary;
pub use landmarks::LandmarksSummary;
pub use layout::{Alignment, table};
pub use observers::{AllowedKind, AllowedSummary, SuspectSummary};
pub use page::{
    ChangedLine, CommandView, CommandsView, CorrectionView, MapView, OffsetView, PlaceView, PlanView,
    PlannedView, PredictionView, ProgramView, Report, acceptance_report, changed_lines, commands_report,
    comparison_report, discovery_report, identification_report, map_report, plan_report, prediction_report,
    program_report,
};
pub use parameters::{OffsetApart, ParameterSummary, ParametersSummary};
pub use plan::PlanSummary;
pub use plan_observed::ObservedPlanSummary;
pub use poses::largest_error_by_pose;
pub use run::{FileRecord, RunRecord};
pub use sessions::{SessionSummary, session_summaries};
pub use specification::{SpecificationSummary, Verdict};
pub use specification_cases::SpecificationLines;
pub use statistics::{OrientationStatistics, PositionStatistics};
pub use streamed::StreamedSummary;
pub use suspicion::suspicion_text;
pub use upkeep::{
    FleetSummary, LookView, MonitorSummary, SisterSummary, TransferSummary, history_page, monitor_report,
};
pub use wording::{count, millimetres, significant, value_with_interval};

pub(crate) use comparison::StrategyOutcome;
pub(crate) use identification::{GroupSummary, NonlinearParameterSummary};
pub(crate) use partial::PartialRows;
pub(crate) use wording::{advice_text, parameter_text, warning_text};
