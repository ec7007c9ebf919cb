//! The observer of a run, as the search has it.

use crate::error::DiscoverError;
use crate::progress::Progress;

/// Begins a step, or ends the run.
pub(crate) type Begin<'a> = dyn Fn(Progress) -> Result<(), DiscoverError> + Sync + 'a;
