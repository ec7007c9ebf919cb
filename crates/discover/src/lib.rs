#![doc = include_str!("../README.md")]

mod accept;
mod conclude;
mod contest;
mod data;
mod diagnose;
mod error;
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

pub use accept::evidence::{Doubt, Evidence, Gain, Refused};
pub use conclude::diagnosis::{
    Alternative, Check, Diagnosis, Finding, Parameter, RivalFit, Unexplained, Withdrawn,
};
pub use conclude::errors::Errors;
pub use conclude::floor::{FloorSource, NoiseFloor, Verdict};
pub use conclude::trace::point::{Trace, TracePoint};
pub use diagnose::diagnose;
pub use error::DiscoverError;
pub use hypotheses::candidate::{Candidate, Change};
pub use hypotheses::family::Family;
pub use hypotheses::place::Place;
pub use nested::{Nested, nested};
pub use options::DiscoverOptions;
pub use progress::Progress;
pub use screen::untestable::Untestable;
pub use termination::Stop;
