#![doc = include_str!("../README.md")]

mod campaign;
mod cell;
pub mod description;
mod disturbance;
mod equilibrium;
mod error;
pub mod flaws;
mod instrument;
mod measure;
mod moment;
mod path;
pub mod physics;
mod plant;
mod reach;
mod rigid;
pub mod robots;
mod stream;
mod truth;

pub use campaign::{Campaign, ChannelPlan, POUND, TREATMENT_POINT, Task, Visit, payload_at_treatment_point};
pub use cell::{Ball, Camera, Cell, Gauge, Misnamed, Move, Name, Plate, Thing, What, Wire};
pub use description::{PlantDescription, PlantOptions};
pub use disturbance::{Beam, Disturbances, LogLag, StationMotion, Wander};
pub use error::SimulateError;
pub use flaws::Flaws;
pub use instrument::{Blunders, Instrument, Repeatability, Tail};
pub use measure::Observation;
pub use plant::Plant;
pub use truth::{JointTruth, Truth, span};
