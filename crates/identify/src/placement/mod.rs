//! Where the instrument stood, and what the tool and the targets are.

mod refine;
mod search;
mod sight;
mod start;
mod undetermined;

pub use search::{Placement, place};
pub use undetermined::Undetermined;
