//! The solvers that a line of text can name, as a tree of enums.

use super::names;
#[cfg(feature = "clarabel")]
use crate::{Bounded, ElasticNet, ExactHuber, GroupLasso, Lasso};
use crate::{Loss, NormalEquations, PivotedQr, Ridge, Robust, Solver, Start, Svd};

/// Every solver that can be named.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub enum SolverSpec {
    /// `normal`
    Normal(NormalEquations),
    /// `qr`
    Qr(PivotedQr),
    /// `svd`
    Svd(Svd),
    /// `ridge`
    Ridge(Ridge),
    /// `lasso`
    #[cfg(feature = "clarabel")]
    Lasso(Lasso),
    /// `elastic_net`
    #[cfg(feature = "clarabel")]
    ElasticNet(ElasticNet),
    /// `group_lasso`
    #[cfg(feature = "clarabel")]
    GroupLasso(GroupLasso),
    /// `bounded`
    #[cfg(feature = "clarabel")]
    Bounded {
        /// Run first; the bounds are imposed on what it minimises.
        inner: Box<SolverSpec>,
    },
    /// `huber_exact`
    #[cfg(feature = "clarabel")]
    ExactHuber(ExactHuber),
    /// `huber` and `tukey`
    Robust {
        /// Run in every iteration.
        inner: Box<SolverSpec>,
        /// Which loss.
        loss: Loss,
        /// Where the iterations start.
        start: Start,
        /// Largest number of iterations (option `rounds`).
        max_iterations: usize,
    },
}

/// Largest number of iterations of a robust solver by default.
pub(crate) const MAX_ITERATIONS: usize = 200;

impl Default for SolverSpec {
    fn default() -> Self {
        SolverSpec::Qr(PivotedQr::default())
    }
}

impl SolverSpec {
    /// The solver.
    pub fn build(&self) -> Box<dyn Solver> {
        match self {
            SolverSpec::Normal(s) => Box::new(*s),
            SolverSpec::Qr(s) => Box::new(*s),
            SolverSpec::Svd(s) => Box::new(*s),
            SolverSpec::Ridge(s) => Box::new(*s),
            #[cfg(feature = "clarabel")]
            SolverSpec::Lasso(s) => Box::new(*s),
            #[cfg(feature = "clarabel")]
            SolverSpec::ElasticNet(s) => Box::new(*s),
            #[cfg(feature = "clarabel")]
            SolverSpec::GroupLasso(s) => Box::new(*s),
            #[cfg(feature = "clarabel")]
            SolverSpec::Bounded { inner } => Box::new(Bounded::new(inner.build())),
            #[cfg(feature = "clarabel")]
            SolverSpec::ExactHuber(s) => Box::new(*s),
            SolverSpec::Robust { inner, loss, start, max_iterations } => {
                let mut robust = Robust::new(inner.build(), *loss, *start);
                robust.max_iterations = *max_iterations;
                Box::new(robust)
            }
        }
    }

    /// The robust solver that this is, or has inside.
    pub(super) fn robust(&self) -> Option<&SolverSpec> {
        match self {
            SolverSpec::Robust { .. } => Some(self),
            #[cfg(feature = "clarabel")]
            SolverSpec::ExactHuber(_) => Some(self),
            #[cfg(feature = "clarabel")]
            SolverSpec::Bounded { inner } => inner.robust(),
            _ => None,
        }
    }

    /// Names that [`FromStr`](std::str::FromStr) knows in this build, with what each does.
    pub fn known() -> Vec<(&'static str, &'static str)> {
        names::NAMES.iter().filter(|n| n.available).map(|n| (n.name, n.about)).collect()
    }
}
