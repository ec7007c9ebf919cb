#![doc = include_str!("../README.md")]

mod against_plain;
mod comparison;
mod conventions;
mod cross_validation;
mod error;
mod evidence;
mod excitation;
mod fit;
mod fit_model;
mod folds;
mod freedom;
mod gross_repeats;
mod identification;
mod landmarks;
mod linearise;
mod noise;
mod numbers;
mod observability;
mod observer;
mod placement;
mod plain;
mod planning;
mod posture_observability;
mod prior;
mod pure_error;
pub mod reduction;
mod repeat_groups;
mod repeats;
mod residuals;
mod resolution;
mod sessions;
mod shapes;
mod streamed;
mod student;
mod suspicion;
mod uncorrected;
mod variance;
mod vertical;

pub use comparison::{Compared, Paired, Trial, compare};
pub use conventions::{Misread, Misreading, NominalResidual, misreadings, nominal_residual};
pub use cross_validation::{CrossValidation, Method, cross_validate};
pub use error::IdentifyError;
pub use excitation::{Advice, Excitation, excitation};
pub use fit::{
    Fit, FitOptions, FittedNonlinear, NoiseSource, NonlinearSearch, Refusal, Warning, fit_again, refit,
};
pub use fit_model::fit;
pub use folds::{Folds, Split, hold_out};
pub use freedom::Freedom;
pub use identification::{
    AsFound, Identification, IdentificationOptions, Stage, Step, TestSet, as_found, identify,
};
pub use landmarks::{
    Contact, ContactRows, Freed, LandmarkFold, SensorFound, Suspect, Touched, allowed_for,
    landmark_cross_validation, landmark_groups, leverages, open_variances, suspects, touched, unmeasured,
};
pub use noise::{beside_others, directions, rays_of, shrinkage};
pub use observability::{Observability, observability};
pub use observer::{Answer, proceed};
pub use placement::{Placement, Undetermined, place, place_fitted};
pub use plain::{Plain, Way, plain};
pub use planning::{
    ObservedPlan, ObservedVisit, Plan, PlanOptions, Planned, Why, Within, plan, plan_observed, within_reach,
};
pub use posture_observability::{PostureObservability, PostureScales, posture_observability};
pub use prior::{Prior, PriorStrength};
pub use pure_error::{PureError, repeats_for, within_dwell};
pub use reduction::Reduction;
pub use repeat_groups::{exact_repeats, near_repeats};
pub use repeats::{LackOfFit, Repeats, ResidualVariance, repeats};
pub use residuals::{Residuals, Spread, distance, measured};
pub use sessions::{SessionPlaced, Unified, unify};
pub use shapes::{descend_nonlinear, judge_nonlinear};
pub use streamed::{
    Equations, FitPass, HeldOut, JudgePass, Judged, Pass, Source, Streamed, StreamedOptions, StreamedRun,
    Sums, Tally, identify_streamed, sample_rows,
};
pub use student::student_quantile;
pub use suspicion::{Cause, Suspicion, suspicion, suspicions};
pub use truepose_errormodel::NoiseModel;
pub use uncorrected::{Uncorrected, uncorrected};
pub use variance::estimate_noise;
pub use vertical::{Vertical, vertical};

/// The steps of a fit one by one, for benchmarks and studies of their cost; no stable interface.
pub mod engine {
    pub use crate::linearise::{
        Batch, Block, Blocks, ByVisits, Lineariser, Rows, accumulate, batches, by_visits, collect, dense,
        factorise, gram, left_out, left_over, triangular, triangular_of,
    };
}

/// What most programs need: `use truepose_identify::prelude::*`.
pub mod prelude {
    pub use crate::{
        Fit, FitOptions, Identification, IdentificationOptions, IdentifyError, PriorStrength, Residuals,
        Split, cross_validate, fit, hold_out, identify, place,
    };
}
