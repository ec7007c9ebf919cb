//! What a front end learns of a run while it lasts.

use crate::interim::Interim;
use std::ops::ControlFlow;

/// Observes a run; `Break` ends it with an error.
pub trait Observer: Sync {
    /// A step begins.
    fn step(&self, words: &str) -> ControlFlow<()>;

    /// What a user should see before the result is there.
    fn remark(&self, words: &str) {
        let _ = words;
    }

    /// A search has found something: what there is of it so far.
    fn interim(&self, so_far: Interim) -> ControlFlow<()> {
        drop(so_far);
        ControlFlow::Continue(())
    }
}

/// Observes nothing.
#[derive(Debug, Clone, Copy, Default)]
pub struct Unobserved;

impl Observer for Unobserved {
    fn step(&self, _: &str) -> ControlFlow<()> {
        ControlFlow::Continue(())
    }
}
