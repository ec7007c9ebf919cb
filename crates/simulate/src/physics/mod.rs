//! Physical causes, each in its own file and in its own terms: none of them is a basis of the model.

pub mod beam;
pub mod bearing;
pub mod changes;
pub mod coupling;
pub mod curve;
pub mod foundation;
pub mod gear;
pub mod play;
pub mod rail;
pub mod temperature;
