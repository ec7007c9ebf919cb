//! Where a discovery is.

use crate::conclude::diagnosis::Diagnosis;

/// Where a discovery is, for a progress bar.
#[derive(Debug, Clone)]
pub enum Progress {
    /// Fitting the declared model.
    Fitting,
    /// Screening all candidates, so many effects having been found.
    Screening(usize),
    /// An effect was added.
    Found(String),
    /// What there is after each find, for whoever interrupts the loop: fitted to the training rows, without rivals.
    SoFar(Box<Diagnosis>),
    /// Looking at earlier finds again.
    Reconsidering,
    /// Holding the enlarged model against the declared one on data that it has not seen.
    Checking,
    /// Judging the result on the rows that were drawn out first.
    Judging,
}
