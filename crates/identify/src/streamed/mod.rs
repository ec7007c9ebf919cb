//! Identification from data of any length, in memory that does not depend on it.
//!
//! ```text
//! sample ──► place ──► fit: reduction, shapes, noise, prior, c₀
//! passes    G_f = Σ [A r]ᵀ[A r] at c₀, for each fold f of the configurations      ──►  c = c₀ + δ,  δ_f without fold f
//! the last  residuals at c;  held out: r − A (δ_f − δ), both at c                     ──►  statistics
//! ```
//!
//! | symbol | here | shape |
//! | --- | --- | --- |
//! | c₀ | coefficients of the sample's fit; zero for the linear one | p |
//! | A, r | whitened design matrix over the kept columns, residuals | m × r, m |
//! | G_f | [`Gram`], or the triangular factor where that has too few digits | (r + 1)² |
//!
//! What decides *which* unknowns there are (null spaces, groups, shapes, κ, the noise) is taken from a sample of some thousand numbers all
//! over the data; what they *are* comes from all rows. The linear fit takes one step from zero; the refined one begins at the sample's
//! coefficients and goes on, a pass a step, until nothing moves. What has to see all rows at once cannot be done this way: solvers that
//! weigh rows or validate on them, channels that lag, directions of approach that the data does not state, repeats, and the search for what is
//! missing.

mod pass;
mod run;
mod tally;

pub use pass::{Equations, FitPass, JudgePass, Judged, Pass, Sums};
pub use run::StreamedRun;
pub use tally::Tally;

use crate::{Fit, FitOptions, IdentifyError, Placement, Spread};
use truepose_errormodel::{AnyEffect, Dataset};
use truepose_kinematics::Chain;
use truepose_solvers::Solver;

/// Rows of one robot that can be gone through again and again, in blocks.
pub trait Source {
    /// What can go wrong on the way.
    type Error: From<IdentifyError>;

    /// About so many rows from all over the data.
    ///
    /// # Errors
    /// When they cannot be had.
    fn sample(&mut self, rows: usize) -> Result<Dataset, Self::Error>;

    /// Hands on all rows once, block by block, always the same blocks in the same order, no visit cut.
    ///
    /// # Errors
    /// When they cannot be had, or what `take` says. A source that is to be cancelled returns an error of its own between two blocks.
    fn each(
        &mut self,
        take: &mut dyn FnMut(&Dataset) -> Result<(), IdentifyError>,
    ) -> Result<(), Self::Error>;
}

/// What to do besides fitting.
#[derive(Debug, Clone, PartialEq)]
pub struct StreamedOptions {
    /// How to fit.
    pub fit: FitOptions,
    /// Folds of the cross-validation over configurations; none below two.
    pub folds: usize,
}

/// Held-out residuals.
#[derive(Debug, Clone, PartialEq)]
pub struct HeldOut {
    /// 3-D distances, m.
    pub position: Spread,
    /// Angles, rad.
    pub orientation: Spread,
    /// RMS of the 3-D distance in each fold, m.
    pub fold_rms: Vec<f64>,
}

/// What was found in data of any length.
#[derive(Debug, Clone)]
pub struct Streamed {
    /// Where base, tool and targets were found, from the sample.
    pub placement: Placement,
    /// The fit of all rows; its residuals are empty.
    pub fit: Fit,
    /// Rows of the sample.
    pub sampled: usize,
    /// Rows.
    pub rows: usize,
    /// Visits.
    pub visits: usize,
    /// 3-D distances of all rows to the fitted model, m.
    pub position: Spread,
    /// Angles, rad.
    pub orientation: Spread,
    /// Cross-validation, where it was asked for and every fold can be left out.
    pub held_out: Option<HeldOut>,
    /// Whether Gram matrices had digits enough.
    pub gram: bool,
}

/// Rows of a sample for a model of so many unknowns.
pub fn sample_rows(unknowns: usize) -> usize {
    (4 * unknowns).max(1000)
}

/// Identifies a robot from rows that are nowhere whole in memory.
///
/// # Errors
/// When something of it cannot be done this way, the model does not fit the data, or a solver refuses.
pub fn identify_streamed<S: Source>(
    chain: &Chain,
    effects: &[Box<dyn AnyEffect>],
    source: &mut S,
    solver: &dyn Solver,
    options: &StreamedOptions,
) -> Result<Streamed, S::Error> {
    StreamedRun::supported(solver)?;
    let sample = source.sample(StreamedRun::wanted(chain, effects)?)?;
    let mut run = StreamedRun::begin(chain, effects, sample, solver, options)?;
    loop {
        match run.pass() {
            Pass::Fit(pass) => {
                let mut sums = pass.nothing();
                source.each(&mut |block| sums.merge(&pass.sums(block)?))?;
                run.solve(&sums, solver)?;
            }
            Pass::Judge(pass) => {
                let mut judged = Judged::default();
                source.each(&mut |block| {
                    judged.merge(&pass.judged(block)?);
                    Ok(())
                })?;
                return Ok(run.finish(&judged)?);
            }
        }
    }
}
