//! What the description leaves open is never a finding.
//!
//! A base, tool or target that is declared `known = false` was found with the nominal arm, so that it is off by what the arm's own errors make
//! of it. It stays an unknown of every fit, whatever else is declared; "its position is wrong, measure it again" would be no news.

use crate::error::DiscoverError;
use std::borrow::Cow;
use truepose_errormodel::effects::{AllTargets, Geometric, Where};
use truepose_errormodel::{AnyEffect, ErrorModel};
use truepose_kinematics::{Chain, FrameId, Site, TargetId};

/// The declared effects, with constant errors of whatever was declared unknown and has none yet.
pub(crate) fn with_unknown<'a>(
    chain: &Chain,
    declared: &'a [Box<dyn AnyEffect>],
) -> Result<Cow<'a, [Box<dyn AnyEffect>]>, DiscoverError> {
    let model = ErrorModel::new(chain.clone(), declared.to_vec())?;
    let has = |wanted: &dyn Fn(Site) -> bool| model.columns().iter().filter_map(|c| c.site).any(wanted);
    let frame = |frame: FrameId| has(&|site| matches!(site, Site::Frame(own, _) if own == frame));
    let target = |target: TargetId| has(&|site| matches!(site, Site::Target(own, _) if own == target));
    let mut open = Vec::new();
    for (placed, at) in [(chain.base(), FrameId::BASE), (chain.tool(), chain.tool_frame())] {
        if !placed.known && !frame(at) {
            open.push(Where::Frame(at));
        }
    }
    let unknown = |(k, at): (usize, &truepose_kinematics::Target)| !at.known && !target(TargetId(k));
    if chain.targets().iter().enumerate().any(unknown) {
        open.push(Where::Targets(AllTargets::All));
    }
    if open.is_empty() {
        return Ok(Cow::Borrowed(declared));
    }
    let mut all = declared.to_vec();
    all.push(Box::new(Geometric { frames: Some(open), components: None }));
    Ok(Cow::Owned(all))
}

#[cfg(test)]
mod tests {
    use super::*;
    use truepose_errormodel::effects::JointCompliance;
    use truepose_kinematics::{Placed, samples};

    #[test]
    fn an_unknown_base_is_an_unknown_of_every_model() {
        let chain = samples::ur10();
        let base = Placed { known: false, ..*chain.base() };
        let open = chain.clone().with_base(base).expect("a base");
        let springs: Vec<Box<dyn AnyEffect>> = vec![Box::new(JointCompliance::of(chain.movable()[1]))];
        let columns = |chain: &Chain, declared: &[Box<dyn AnyEffect>]| {
            let all = with_unknown(chain, declared).expect("fits the robot").into_owned();
            ErrorModel::new(chain.clone(), all).expect("fits the robot").columns().len()
        };
        assert_eq!(columns(&chain, &springs), 1);
        assert_eq!(columns(&open, &springs), 7);
        // What is declared is not added again.
        let whole: Vec<Box<dyn AnyEffect>> = vec![Box::new(Geometric::default())];
        assert_eq!(columns(&open, &whole), columns(&chain, &whole));
    }
}
