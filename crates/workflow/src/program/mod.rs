//! Robot programs with compensated points.

mod backup;
mod folder;
mod offsets;
mod places;
mod request;
mod rewriting;
mod rows;
mod single;
mod statements;
mod taught;

pub use backup::Backup;
pub use folder::{FolderRewritten, rewrite_folder};
pub use offsets::offset_numbers;
pub use request::{ProgramRequest, TaughtFrom};
pub use rewriting::{Rewritten, RewrittenFile};
pub use rows::{Labels, short};
pub use single::rewrite_program;

/// Most lines of points that a message lists.
pub const LISTED: usize = 20;
