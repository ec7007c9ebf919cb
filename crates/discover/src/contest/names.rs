//! Probability of a name, given that an effect exists.
//!
//! ```text
//! P(h) ∝ exp(−(Δ_h + u_h) / 2T),     Δ_h = (−2 ln L + C)_h − (−2 ln L + C)_winner,     u_h: prior of its family
//! ```
//!
//! | symbol | here | |
//! | --- | --- | --- |
//! | Δ | second element of `competitors` | difference of score from the data alone ([`crate::contest::competitor`]) |
//! | u | [`Policy::unnamed_name`], [`Policy::link_name`], 0 | log prior odds against a name that the library lacks, and against a link that bends |
//! | T | [`Policy::name_temperature`] | the linearised likelihood is too certain: its errors are neither normal nor of known covariance |
//!
//! The classes are the families and places that were compared, and "none of these": all unnamed structures together. Existence is the
//! family-wise p of [`crate::significance`], and apart.

use crate::hypotheses::candidate::Candidate;
use crate::hypotheses::family::Family;
use crate::policy::Policy;

/// Probabilities of the names of one finding; they add up to one.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct NameProbabilities {
    /// Of the finding's own family and place.
    pub own: f64,
    /// Of each competing hypothesis.
    pub each: Vec<f64>,
    /// Of no name that the library has.
    pub unnamed: f64,
}

/// Log prior odds (−2 ln) against the name of a family.
pub(crate) fn name_prior(family: Family, policy: &Policy) -> f64 {
    match family {
        Family::LinkCompliance => policy.link_name,
        family if family.is_named() => 0.0,
        _ => policy.unnamed_name,
    }
}

/// The probabilities of a finding and of its competing hypotheses (candidate, Δ). `among_surrogates`: p of a finding that reads a channel
/// among surrogates of that channel; as far as others do as well, another record that nobody kept is as likely.
pub(crate) fn name_probabilities(
    (finding, among_surrogates): (&Candidate, Option<f64>),
    competitors: &[(Candidate, f64)],
    policy: &Policy,
) -> NameProbabilities {
    let weight = |family: Family, behind: f64| {
        (-(behind + name_prior(family, policy)) / (2.0 * policy.name_temperature)).exp()
    };
    let own = weight(finding.family, 0.0);
    let each: Vec<f64> = competitors.iter().map(|(c, behind)| weight(c.family, *behind)).collect();
    let total: f64 = own + each.iter().sum::<f64>();
    let of_unnamed = competitors.iter().zip(&each).filter(|((c, _), _)| !c.family.is_named());
    let unnamed = of_unnamed.map(|(_, w)| w).sum::<f64>() + if finding.family.is_named() { 0.0 } else { own };
    let doubt =
        if finding.family.is_named() { doubtful(among_surrogates, policy) * own / total } else { 0.0 };
    NameProbabilities {
        own: own / total - doubt,
        each: each.into_iter().map(|w| w / total).collect(),
        unnamed: unnamed / total + doubt,
    }
}

/// Share of a name's probability that its channel does not deserve.
fn doubtful(among_surrogates: Option<f64>, policy: &Policy) -> f64 {
    among_surrogates.map_or(0.0, |p| (2.0 * (p - policy.surrogates_level)).clamp(0.0, 1.0))
}

/// Δ of a competing hypothesis whose channel was held against its surrogates: its probability is smaller by the same share, but for a tenth:
/// a channel that only rises has no surrogates that do worse, whether it is the cause or not.
pub(crate) fn doubted(behind: f64, among_surrogates: Option<f64>, policy: &Policy) -> f64 {
    behind - 2.0 * policy.name_temperature * (1.0 - doubtful(among_surrogates, policy)).max(0.1).ln()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::hypotheses::constant::OfFrames;
    use crate::hypotheses::place::Place;
    use crate::hypotheses::variant::Variant;
    use std::sync::Arc;
    use truepose_errormodel::effects::Guideway;
    use truepose_kinematics::JointId;

    #[test]
    fn names_share_one_and_a_far_competitor_gets_nothing() {
        let at = |joint: &str| {
            let place = Place { joint: Some(joint.into()), ..Place::default() };
            Candidate::new(Arc::new(OfFrames), Variant::new(place, Guideway::of(JointId(0))))
        };
        let policy = Policy::default();
        let of = |behind: &[f64]| {
            let competitors: Vec<_> = behind.iter().map(|&behind| (at("b"), behind)).collect();
            name_probabilities((&at("a"), None), &competitors, &policy)
        };
        let tied = of(&[0.0, 200.0]);
        assert!((tied.own - 0.5).abs() < 1e-9 && tied.each[1] < 1e-6, "{tied:?}");
        let alone = of(&[]);
        assert!((alone.own - 1.0).abs() < 1e-12 && alone.unnamed <= 0.0, "{alone:?}");
        // One temperature behind: odds of the square root of e.
        let close = of(&[policy.name_temperature]);
        assert!((close.own / close.each[0] - 0.5f64.exp()).abs() < 1e-9, "{close:?}");
        assert!((close.own + close.each[0] - 1.0).abs() < 1e-12);
        // Where half of the surrogates do as well, the name is nearly as doubtful as without a channel.
        let doubtful = name_probabilities((&at("a"), Some(0.5)), &[], &policy);
        assert!((doubtful.own + doubtful.unnamed - 1.0).abs() < 1e-12 && doubtful.own < 0.2, "{doubtful:?}");
        // As a competing hypothesis it has as small a share: 0.1 against 1.
        for (p, share) in [(0.3, 0.5), (0.9, 0.1)] {
            let beside = of(&[doubted(0.0, Some(p), &policy)]);
            assert!((beside.each[0] / beside.own - share).abs() < 1e-9, "{beside:?}");
        }
    }
}
