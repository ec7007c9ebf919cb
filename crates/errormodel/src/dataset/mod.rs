//! Measurements, column by column, and which rows belong together.

mod approach;
mod derived;
mod dwell;
mod late;
mod matching;
mod schema;
mod table;
mod visits;

pub use approach::approach_from_order;
pub use derived::{CARRIED, is_derived};
pub use dwell::{Dwell, DwellTolerance};
pub use late::late_channel;
pub use schema::{Channel, Schema};
pub use table::{Dataset, Seen};
pub use visits::{Visits, configurations, visits_from_rows};
