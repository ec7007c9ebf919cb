//! A finding with its evidence.

use crate::accept::evidence::Evidence;
use crate::contest::names::name_probabilities;
use crate::hypotheses::candidate::Candidate;
use crate::policy::Policy;

/// An accepted finding: the candidate, its evidence, and the hypotheses that it was preferred to.
#[derive(Debug, Clone)]
pub(crate) struct Accepted {
    pub candidate: Candidate,
    pub evidence: Evidence,
    /// Competing hypotheses, each with its difference in −2 ln L + coefficient penalty from the finding
    /// (positive: less likely); smallest difference first.
    pub competitors: Vec<(Candidate, f64)>,
    /// Unnamed candidates with high scores at the time of the finding; reconsideration tests them again.
    pub shortlist: Vec<Candidate>,
    /// Candidates that would explain this finding and another one as one cause, with their difference from both, as above.
    pub instead: Vec<(Candidate, f64)>,
}

impl Accepted {
    /// Whether a competing hypothesis has a more probable name.
    pub fn is_outnamed(&self, policy: &Policy) -> bool {
        let finding = (&self.candidate, self.evidence.p_surrogates);
        let names = name_probabilities(finding, &self.competitors, policy);
        names.each.iter().any(|&other| other > names.own)
    }

    /// The simplest of the named hypotheses that are not distinguishable from the finding, where it is simpler than the finding.
    pub fn simplest(&self, policy: &Policy) -> Option<&Candidate> {
        let size =
            |c: &Candidate| (c.hypothesis().rank(), c.nonlinear().count() + c.ends(), c.effects().len());
        let tied = self.competitors.iter().filter(|(c, behind)| c.family.is_named() && *behind < policy.tie);
        let simplest = tied.map(|(candidate, _)| candidate).min_by_key(|candidate| size(candidate))?;
        (size(simplest) < size(&self.candidate)).then_some(simplest)
    }

    /// Sets the competing hypotheses; those that would explain another finding as well are among them.
    pub fn compete(&mut self, mut competitors: Vec<(Candidate, f64)>) {
        for (other, behind) in &self.instead {
            match competitors.iter_mut().find(|(known, _)| known.same_cause(other)) {
                Some(known) => known.1 = known.1.min(*behind),
                None => competitors.push((other.clone(), *behind)),
            }
        }
        competitors.sort_by(|a, b| a.1.total_cmp(&b.1));
        self.competitors = competitors;
    }

    /// Notes a candidate that would explain this finding and another one as one cause.
    pub fn note_instead(&mut self, other: &Candidate, behind: f64) {
        self.instead.retain(|(known, _)| !known.same_cause(other));
        self.instead.push((other.clone(), behind));
        self.compete(self.competitors.clone());
    }
}
