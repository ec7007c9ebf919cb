//! Effects, solvers and hypotheses that the program knows: its own, and those of the program that it is part of.

use std::fmt;
use std::str::FromStr;
use std::sync::OnceLock;
use truepose_discover::{Hypothesis, Library};
use truepose_errormodel::{Effect, EffectRegistry};
use truepose_solvers::{Solver, SolverSpec};

/// Makes a solver.
type Make = fn() -> Box<dyn Solver>;

/// What a program knows.
#[derive(Debug, Clone)]
pub struct Extensions {
    effects: EffectRegistry,
    solvers: Vec<(&'static str, Make)>,
    library: Library,
}

impl Extensions {
    /// Of `truepose`: built-in effects, solvers and hypotheses alone.
    pub fn builtin() -> Self {
        Extensions { effects: EffectRegistry::builtin(), solvers: Vec::new(), library: Library::standard() }
    }

    /// With an effect, for `family` in model files and for fits that contain it.
    #[must_use]
    pub fn with_effect<E: Effect>(mut self) -> Self {
        self.effects = self.effects.with::<E>();
        self
    }

    /// With a solver, for `--solver NAME`.
    #[must_use]
    pub fn with_solver(mut self, name: &'static str, make: fn() -> Box<dyn Solver>) -> Self {
        self.solvers.push((name, make));
        self
    }

    /// With a hypothesis, which `discover` tests beside its own.
    #[must_use]
    pub fn with_hypothesis(mut self, hypothesis: impl Hypothesis + 'static) -> Self {
        self.library = self.library.with(hypothesis);
        self
    }
}

static INSTALLED: OnceLock<Extensions> = OnceLock::new();

/// Sets what the program knows, once.
pub(crate) fn install(extensions: Extensions) {
    let _ = INSTALLED.set(extensions);
}

fn installed() -> &'static Extensions {
    INSTALLED.get_or_init(Extensions::builtin)
}

/// The effects.
pub(crate) fn effects() -> &'static EffectRegistry {
    &installed().effects
}

/// The hypotheses.
pub(crate) fn library() -> Library {
    installed().library.clone()
}

/// Names of the solvers that were added.
pub(crate) fn own_solvers() -> impl Iterator<Item = &'static str> {
    installed().solvers.iter().map(|(name, _)| *name)
}

/// A solver as it is chosen on the command line.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum SolverChoice {
    /// One of the built-in strategies.
    Builtin(SolverSpec),
    /// One that was added, by its name.
    Own(&'static str, MakeOf),
}

/// How a solver is made; two of one name are the same.
#[derive(Clone, Copy)]
pub(crate) struct MakeOf(Make);

impl fmt::Debug for MakeOf {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("fn")
    }
}

impl PartialEq for MakeOf {
    fn eq(&self, _: &Self) -> bool {
        true
    }
}

impl SolverChoice {
    /// The solver.
    pub fn build(&self) -> Box<dyn Solver> {
        match self {
            SolverChoice::Builtin(spec) => spec.build(),
            SolverChoice::Own(_, make) => (make.0)(),
        }
    }
}

impl FromStr for SolverChoice {
    type Err = <SolverSpec as FromStr>::Err;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        match installed().solvers.iter().find(|(name, _)| *name == text) {
            Some((name, make)) => Ok(SolverChoice::Own(name, MakeOf(*make))),
            None => text.parse().map(SolverChoice::Builtin),
        }
    }
}

impl fmt::Display for SolverChoice {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            SolverChoice::Builtin(spec) => spec.fmt(f),
            SolverChoice::Own(name, _) => f.write_str(name),
        }
    }
}
