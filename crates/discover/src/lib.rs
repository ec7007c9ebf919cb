#![doc = include_str!("../README.md")]

mod accept;
mod budget;
mod census;
mod conclude;
mod constants;
mod contest;
mod data;
mod diagnose;
mod error;
mod fold;
mod history;
mod hypotheses;
mod model;
mod nested;
mod observer;
mod options;
mod policy;
mod problem;
mod progress;
mod revise;
mod screen;
mod search;
mod significance;
mod statistics;
mod termination;
mod widened;

pub use accept::evidence::{Doubt, Evidence, Gain, Refused};
pub use budget::Budget;
pub use conclude::diagnosis::{Alternative, Check, CompetingFit, Diagnosis, Finding, Parameter, Withdrawn};
pub use conclude::errors::Errors;
pub use conclude::extrapolation::{Extrapolation, Part};
pub use conclude::floor::{FloorSource, NoiseFloor};
pub use conclude::fold_run::FoldRun;
pub use conclude::held_out::HeldOutIntervals;
pub use conclude::partition::HeldOut;
pub use conclude::stated::StatedScale;
pub use conclude::trace::point::{Trace, TracePoint};
pub use conclude::verdict::{Estimate, Unexplained, Verdict};
pub use diagnose::diagnose;
pub use error::DiscoverError;
pub use hypotheses::candidate::Candidate;
pub use hypotheses::change::Change;
pub use hypotheses::covariate::Covariate;
pub use hypotheses::driver::Driver;
pub use hypotheses::family::Family;
pub use hypotheses::hypothesis::Hypothesis;
pub use hypotheses::levels::Levels;
pub use hypotheses::library::Library;
pub use hypotheses::limits::Limit;
pub use hypotheses::nonlinear::{Nonlinear, Refinement};
pub use hypotheses::penalty::Penalty;
pub use hypotheses::place::Place;
pub use hypotheses::setting::Setting;
pub use hypotheses::variant::Variant;
pub use hypotheses::view::TraceView;
pub use nested::{Nested, nested, nested_fold};
pub use options::DiscoverOptions;
pub use policy::Policy;
pub use problem::dependence::Dependence;
pub use problem::joint_noise::JointRepeatability;
pub use problem::noise::JointNoise;
pub use progress::Progress;
pub use screen::untestable::Untestable;
pub use termination::Termination;

/// What most programs need: `use truepose_discover::prelude::*`.
pub mod prelude {
    pub use crate::{
        Diagnosis, DiscoverError, DiscoverOptions, Family, Finding, Library, Nested, Termination, Verdict,
        diagnose, nested,
    };
}
