//! Measurements, column by column, and which rows belong together.

mod approach;
mod builder;
mod carry;
mod derived;
mod dwell;
mod landmark;
mod late;
mod matching;
mod measurement;
mod part;
mod presliding;
mod ray;
mod record;
mod repeated;
mod schema;
mod session;
mod step;
mod table;
mod visits;

pub use approach::approach_from_order;
pub use builder::DatasetBuilder;
pub use derived::{CARRIED, is_derived};
pub use dwell::{Dwell, DwellTolerance};
pub use landmark::LANDMARK;
pub use late::late_channel;
pub use measurement::Measurement;
pub use presliding::{presliding, presliding_channel, presliding_of};
pub(crate) use ray::of_observation;
pub use ray::{KIND, RAY, Ray, SENSOR, VALUE, own_channel};
pub use record::Record;
pub use schema::{Channel, Schema};
pub use session::{SESSION, SessionRules};
pub use step::{step_channel, step_of};
pub use table::{Dataset, Seen};
pub use visits::{Visits, configurations, visits_from_rows};
