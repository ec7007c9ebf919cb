//! Physical causes, each in its own file and in its own terms: none of them is a basis of the model.

pub mod backlash;
pub mod beam;
pub mod bridge;
pub mod changes;
pub mod coupling;
pub mod creep;
pub mod curve;
pub mod foundation;
pub mod guideway;
pub mod heating;
pub mod joint_stiffness;
pub mod linkage;
pub mod mounting;
pub mod presliding;
pub mod spring;
pub mod temperature;
pub mod transmission;
pub mod warming;
pub mod wave;
