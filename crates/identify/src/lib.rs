#![doc = include_str!("../README.md")]

mod against_plain;
mod comparison;
mod cross_validation;
mod error;
mod evidence;
mod excitation;
mod fit;
mod folds;
mod freedom;
mod identification;
mod linearise;
mod minimum;
mod noise;
mod observability;
mod observer;
mod placement;
mod plain;
mod planning;
mod prior;
pub mod reduction;
mod repeats;
mod residuals;
mod resolution;
mod shapes;
mod streamed;
mod suspicion;
mod variance;

pub use comparison::{Compared, Paired, Trial, compare};
pub use cross_validation::{CrossValidation, Method, cross_validate};
pub use error::IdentifyError;
pub use excitation::{Advice, excitation};
pub use fit::{Fit, FitOptions, NoiseSource, Refusal, Warning, fit, fit_again, refit, student_quantile};
pub use folds::{Folds, Split, hold_out};
pub use freedom::Freedom;
pub use identification::{Identification, IdentificationOptions, Stage, Step, identify};
pub use linearise::{
    Batch, Block, Blocks, Lineariser, Rows, accumulate, batches, collect, factorise, gram, left_out,
    left_over, triangular, triangular_of,
};
pub use minimum::minimum;
pub use noise::NoiseModel;
pub use observability::{Observability, observability};
pub use observer::{Answer, proceed};
pub use placement::{Placement, Undetermined, place};
pub use plain::{Plain, Way, plain};
pub use planning::{Plan, PlanOptions, Planned, Why, plan};
pub use prior::{Prior, PriorStrength};
pub use reduction::Reduction;
pub use repeats::{LackOfFit, Repeats, repeats};
pub use residuals::{Residuals, Spread};
pub use shapes::{FittedShape, Shapes, descend_shapes, judge_shapes};
pub use streamed::{HeldOut, Source, Streamed, StreamedOptions, Tally, identify_streamed, sample_rows};
pub use suspicion::{Cause, Suspicion, suspicion, suspicions};
pub use variance::estimate_noise;
