//! Why the loop stopped.

use serde::{Deserialize, Serialize};

/// Why the loop stopped.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum Stop {
    /// Nothing is left that chance would not do as well.
    NothingLeft,
    /// Something is left, but no candidate passed the tests.
    NothingConvincing,
    /// As many effects as were allowed.
    Limit,
    /// The search came back to findings that it had had before, again and again: something is left, and what it is stays undecided.
    Circling,
    /// What was found did not hold on data that the search had not seen: the declared model stands.
    Withdrawn,
    /// The caller ended it: there may be more, and nothing was judged at the end.
    Interrupted,
}
