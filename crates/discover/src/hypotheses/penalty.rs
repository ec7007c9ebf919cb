//! How the coefficients of a candidate are penalised: by their number, or by the marginal likelihood.

use crate::hypotheses::candidate::Candidate;
use crate::hypotheses::family::Family;
use crate::hypotheses::nonlinear::seen_as;
use truepose_errormodel::effects::{Expansion, Place};

/// Whether the coefficients of a candidate pay by the evidence.
pub(crate) fn by_evidence(candidate: &Candidate) -> bool {
    match candidate.family {
        Family::Guideway | Family::Drift | Family::Shift | Family::Thermal => true,
        Family::Unmodelled => {
            wanders(candidate) || candidate.follows_the_time() || candidate.follows_a_load()
        }
        _ => false,
    }
}

/// Whether several components of a frame move along curves.
fn wanders(candidate: &Candidate) -> bool {
    let [effect] = candidate.effects() else { return false };
    seen_as::<Expansion>(&**effect)
        .is_some_and(|series| matches!(&series.at, Place::Frame { components, .. } if components.len() > 1))
}
