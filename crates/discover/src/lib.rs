#![doc = include_str!("../README.md")]

mod candidate;
mod conclude;
mod contest;
mod derived;
mod descend;
mod diagnose;
mod diagnosis;
mod error;
mod evidence;
mod family;
mod flips;
mod functions;
mod gross;
mod law;
mod library;
mod likelihood;
mod linear;
mod look_ahead;
mod merge;
mod nested;
mod normal;
mod options;
mod outliers;
mod payload;
mod periodogram;
mod place;
mod polish;
mod product;
mod projection;
mod reconsider;
mod rival;
mod sample;
mod scene;
mod screen;
mod shape;
mod share;
mod so_far;
mod surprise;
mod tables;
mod trace;
mod trial;
mod whitener;
mod wide;
mod working;

pub use candidate::{Candidate, Change};
pub use diagnose::{Progress, diagnose};
pub use diagnosis::{
    Alternative, Diagnosis, Errors, Finding, Parameter, Refused, RivalFit, Stop, Unexplained, Untestable,
};
pub use error::DiscoverError;
pub use evidence::{Doubt, Evidence, Gain};
pub use family::Family;
pub use nested::{Nested, nested};
pub use options::DiscoverOptions;
pub use place::Place;
pub use trace::{Trace, TracePoint};
