//! What the loop has been through, as far as it decides how to go on.

use crate::accept::model::{Model, Structure};
use crate::hypotheses::candidate::Candidate;
use crate::options::DiscoverOptions;
use crate::termination::Termination;

/// State of the search that decides how it continues.
#[derive(Default)]
pub(crate) struct History {
    iterations: usize,
    /// Candidates that passed the tests of the linearised problem and failed those of the refitted model.
    pub barred: Vec<Candidate>,
    /// Findings that the joint fit with later ones refused at the end; the search goes on without them.
    dropped: Vec<Candidate>,
    /// Findings whose nonlinear parameters were optimised jointly.
    descended: Option<Structure>,
    /// Whether all findings were reconsidered at the end.
    reconsidered: bool,
    /// Sets of findings of earlier iterations: a revision that leads back to one of them may repeat without
    /// end.
    met: Vec<Structure>,
    circling: bool,
    /// Whether the noise of the screens has a wander.
    wanders: bool,
    /// Whether a scatter of the joints was looked for.
    scatters: bool,
}

impl History {
    /// Whether the search ends with this smallest family-wise p, and why.
    pub fn decide(&mut self, p_value: f64, model: &Model, options: &DiscoverOptions) -> Option<Termination> {
        self.iterations += 1;
        // A candidate may be significant under the noise of the model that has it: those near α are looked at.
        if p_value > options.policy.second_look * options.alpha {
            Some(Termination::NothingLeft)
        } else if model.findings.len() >= options.most {
            Some(Termination::Limit)
        } else if self.iterations > 2 * options.most {
            Some(Termination::Circling)
        } else {
            None
        }
    }

    /// Bars these findings from the rest of the search.
    pub fn drop(&mut self, findings: Vec<Candidate>) {
        self.dropped.extend(findings);
        self.begin_again();
    }

    /// After a finding: candidates that the refitted model refused may be tested again.
    pub fn begin_again(&mut self) {
        self.barred.clone_from(&self.dropped);
    }

    /// Whether screens have a wander beside the model.
    pub fn wanders(&self) -> bool {
        self.wanders
    }

    /// Whether a wander may be tried now: once, when no effect is left to be found without it.
    pub fn may_wander(&mut self, stop: Option<Termination>) -> bool {
        let may = !self.wanders && matches!(stop, None | Some(Termination::NothingLeft));
        self.wanders |= may;
        may
    }

    /// Whether a scatter of the joints may be looked for now: once, when no effect is left to be found without it.
    pub fn may_scatter(&mut self, stop: Option<Termination>) -> bool {
        let may = !self.scatters && matches!(stop, None | Some(Termination::NothingLeft));
        self.scatters |= may;
        may
    }

    /// Whether earlier findings are reconsidered after a new one: while there are at most `few`, and until a
    /// set of findings occurs twice.
    pub fn may_revise(&mut self, model: &Model, few: usize) -> bool {
        let structure = model.structure();
        self.circling |= self.met.contains(&structure);
        let may = model.findings.len() <= few && !self.circling;
        if may {
            self.met.push(structure);
        }
        may
    }

    /// Whether the nonlinear parameters of these findings have not been optimised jointly yet.
    pub fn may_descend(&mut self, model: &Model) -> bool {
        let structure = Some(model.structure());
        let may = self.descended != structure;
        self.descended = structure;
        may
    }

    /// Whether all findings are reconsidered at the end: once, with more than `few` of them.
    pub fn may_reconsider(&mut self, model: &Model, few: usize) -> bool {
        let may = !self.reconsidered && model.findings.len() > few;
        self.reconsidered |= may;
        may
    }
}
