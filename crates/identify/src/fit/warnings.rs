//! What a reduction shows that a user should know.

use crate::reduction::Reduction;
use truepose_errormodel::ErrorModel;

/// Something that a user should know about a fit.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub enum Warning {
    /// The singular values show no clear gap where the rank was cut.
    UnclearRank {
        /// Of all postures within the limits, or of this data.
        structural: bool,
        /// Smallest value kept over largest value dropped.
        gap: f64,
    },
    /// Fewer measured numbers than unknowns: some were set to zero.
    FewerRowsThanUnknowns {
        /// Measured numbers.
        observations: usize,
        /// Unknowns before the reduction.
        unknowns: usize,
    },
    /// The rounds ended before nothing moved any more.
    NotConverged {
        /// How many were taken.
        rounds: usize,
        /// Whether they were all that the options allow; otherwise no step made the fit better.
        all: bool,
    },
    /// An unknown that is no constant error has no effect on anything in this data (no load, a channel that never moves).
    NoEffect {
        /// The column's name.
        column: String,
    },
    /// The best value of a shape parameter lies at an end of the range in which it was looked for.
    NonlinearAtBound {
        /// The effect's family.
        effect: String,
        /// The parameter.
        name: String,
        /// Where it lies.
        value: f64,
    },
    /// A coefficient lies outside of its bounds by more than its 95 % interval; a solver that holds bounds would hold it.
    OutOfBounds {
        /// The column's name.
        column: String,
        /// The coefficient.
        value: f64,
        /// Its bounds.
        bounds: [f64; 2],
    },
    /// A solver that takes or leaves whole effects left one out: all of its coefficients are zero.
    LeftOut {
        /// The effect's family.
        effect: String,
        /// The name of its first column.
        column: String,
    },
    /// What a robust solver found was worse than plain least squares, and was not taken: this is the plain fit.
    FellBack {
        /// The solver's name.
        solver: String,
        /// By what it was refused.
        why: Refusal,
    },
    /// A strategy predicts configurations that it did not see worse than plain least squares does.
    WorseThanPlain {
        /// The solver's name.
        solver: String,
        /// Its bounded held-out error over that of plain least squares.
        ratio: f64,
    },
    /// As many unknowns as numbers: the residual says nothing about the accuracy.
    NoRedundancy,
}

/// By what a robust fit was refused.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Refusal {
    /// It leaves more than plain least squares, by a robust measure on the data of the fit.
    Objective,
    /// It predicts what it did not see worse, by so much: its bounded held-out error over that of plain least squares.
    HeldOut(f64),
}

/// Of a model and the data behind it.
pub(super) fn of(model: &ErrorModel, reduction: &Reduction, observations: usize) -> Vec<Warning> {
    let columns = model.columns();
    let idle = reduction.dropped.iter().filter(|d| d.relation.is_empty() && columns[d.column].site.is_none());
    let mut warnings: Vec<Warning> =
        idle.map(|d| Warning::NoEffect { column: columns[d.column].name.clone() }).collect();
    for (structural, decision) in [(true, &reduction.structural), (false, &reduction.practical)] {
        if !decision.is_clear() {
            warnings.push(Warning::UnclearRank { structural, gap: decision.gap });
        }
    }
    if observations < columns.len() {
        warnings.push(Warning::FewerRowsThanUnknowns { observations, unknowns: columns.len() });
    }
    if observations <= reduction.rank() {
        warnings.push(Warning::NoRedundancy);
    }
    warnings
}
