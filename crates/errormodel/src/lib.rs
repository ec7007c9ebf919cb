//! The error model of a robot.

mod dataset;
mod error;

pub use dataset::{
    Channel, Dataset, Schema, Seen, Visits, approach_from_order, configurations, visits_from_rows,
};
pub use error::ModelError;
