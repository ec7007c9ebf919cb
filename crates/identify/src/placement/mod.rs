//! Where the instrument stood, and what the tool and the targets are.

mod fitted;
mod refine;
mod search;
mod sight;
mod start;
mod undetermined;

pub use fitted::place_fitted;
pub use search::{Placement, place};
pub use undetermined::Undetermined;
