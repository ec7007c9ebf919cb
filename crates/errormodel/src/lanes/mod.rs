//! What a block of [`LANES`] rows consists of: postures, emissions, errors and levers, number by number.
//!
//! [`crate::batch`] evaluates a model in such a block; an effect that supports it emits into one ([`crate::Effect::eval_lanes`]).

mod contact;
mod emission;
mod errors;
mod jacobian;
mod loads;
mod posture;
mod postures;
mod standing;
mod store;
mod walk;
mod width;

pub(crate) use emission::LaneEntry;
pub use emission::{LaneEmission, LaneValue};
pub(crate) use errors::LaneErrors;
pub(crate) use loads::LaneLoad;
pub use posture::LanePosture;
pub use postures::{JacobianGram, PACKED, error_jacobians, error_jacobians_packed, error_variances};
pub(crate) use standing::Standing;
pub(crate) use store::Store;
pub use width::LANES;
