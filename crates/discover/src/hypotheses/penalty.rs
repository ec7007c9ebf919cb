//! How the coefficients of a candidate are penalised: by their number, or by the marginal likelihood.

/// How coefficients are penalised.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum Penalty {
    /// By their number: ln m each (Schwarz 1978), m the number of observations.
    Number,
    /// By the marginal likelihood, where that penalises less: many small coefficients of a curve are one quantity with a variance.
    MarginalLikelihood,
}
