//! Termination of the search.

use serde::{Deserialize, Serialize};

/// Why the search ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum Termination {
    /// No further effect is significant: the smallest family-wise p exceeds α.
    NothingLeft,
    /// A candidate is significant, but none passed all tests.
    NothingConvincing,
    /// The largest allowed number of findings is reached.
    Limit,
    /// The search returned to the same sets of findings: significant structure remains, its family is
    /// undecided.
    Circling,
    /// The findings were withdrawn: the enlarged model predicts unseen data worse than the declared one.
    Withdrawn,
    /// The caller ended the search: further effects are possible, and the final validation is missing.
    Interrupted,
}
