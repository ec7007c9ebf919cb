//! When the search ends, and why.

use crate::accept::model::{Model, Structure};
use crate::hypotheses::candidate::Candidate;
use crate::options::DiscoverOptions;
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

/// What the loop has been through, as far as it decides how to go on.
#[derive(Default)]
pub(crate) struct History {
    iterations: usize,
    /// Candidates that passed the tests of the linearised problem and failed as part of the present model.
    pub barred: Vec<Candidate>,
    /// Findings whose nonlinear parameters were brought to their joint optimum.
    descended: Option<Structure>,
    /// Whether all findings were reconsidered at the end.
    reconsidered: bool,
    /// Findings that were together before: a revision that takes one out only for it to come back does not end.
    met: Vec<Structure>,
    circling: bool,
}

impl History {
    /// Whether no iteration has been decided on yet.
    pub fn first(&self) -> bool {
        self.iterations == 0
    }

    /// Why the search ends with this smallest p, if it does.
    pub fn decide(&mut self, p_value: f64, model: &Model, options: &DiscoverOptions) -> Option<Stop> {
        self.iterations += 1;
        if p_value > options.alpha {
            Some(Stop::NothingLeft)
        } else if model.findings.len() >= options.most {
            Some(Stop::Limit)
        } else if self.iterations > 2 * options.most {
            Some(Stop::Circling)
        } else {
            None
        }
    }

    /// Whether earlier findings are tested again after a new one: while there are few, and as long as that leads to findings not met before.
    pub fn may_revise(&mut self, model: &Model, few: usize) -> bool {
        let structure = model.structure();
        self.circling |= self.met.contains(&structure);
        let may = model.findings.len() <= few && !self.circling;
        if may {
            self.met.push(structure);
        }
        may
    }

    /// Whether these findings have not been through a joint descent yet.
    pub fn may_descend(&mut self, model: &Model) -> bool {
        let structure = Some(model.structure());
        let may = self.descended != structure;
        self.descended = structure;
        may
    }

    /// Whether all findings are reconsidered at the end: once, where they were too many to do it after each.
    pub fn may_reconsider(&mut self, model: &Model, few: usize) -> bool {
        let may = !self.reconsidered && model.findings.len() > few;
        self.reconsidered |= may;
        may
    }
}
