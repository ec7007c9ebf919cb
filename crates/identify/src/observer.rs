//! One closure that receives the steps of a long run, and decides whether it goes on.

use crate::IdentifyError;
use std::ops::ControlFlow;

/// What a closure that observes a run returns: nothing, where it only reports, or a [`ControlFlow`], of which `Break` ends the run with
/// [`IdentifyError::Cancelled`] before its next step.
///
/// ```
/// use std::cell::Cell;
/// use std::ops::ControlFlow;
/// use truepose_identify::{Answer, Step};
///
/// fn takes<A: Answer>(observer: &dyn Fn(Step) -> A) -> bool {
///     observer(Step::Placing).flow().is_continue()
/// }
/// let steps = Cell::new(0);
/// assert!(takes(&|_| steps.set(steps.get() + 1)));
/// assert!(!takes(&|step| if step == Step::Placing { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }));
/// assert_eq!(steps.get(), 1);
/// ```
pub trait Answer {
    /// Whether to go on.
    fn flow(self) -> ControlFlow<()>;
}

impl Answer for () {
    fn flow(self) -> ControlFlow<()> {
        ControlFlow::Continue(())
    }
}

impl Answer for ControlFlow<()> {
    fn flow(self) -> ControlFlow<()> {
        self
    }
}

/// An error where the answer is to end.
///
/// # Errors
/// [`IdentifyError::Cancelled`].
pub fn proceed(answer: impl Answer) -> Result<(), IdentifyError> {
    match answer.flow() {
        ControlFlow::Continue(()) => Ok(()),
        ControlFlow::Break(()) => Err(IdentifyError::Cancelled),
    }
}
