//! The observer of a run, as the loop has it.

use crate::{DiscoverError, Progress};

/// Begins a step, or ends the run.
pub(crate) type Begin<'a> = dyn Fn(Progress) -> Result<(), DiscoverError> + Sync + 'a;
