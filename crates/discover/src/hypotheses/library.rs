//! Every family at every place where it can act, as ordinary effects.
//!
//! One file for each sort of cause. A cause at one place comes in several *variants*, from simple to rich; shapes (a
//! period, an instant, a lag) come as a grid that is refined later.

use crate::hypotheses::candidate::Candidate;
use crate::hypotheses::family::Family;
use crate::hypotheses::setting::Setting;
use crate::hypotheses::{compliance, constant, guideway, loaded, motion, payload, thermal, time, unmodelled};
use truepose_errormodel::Dataset;
use truepose_kinematics::Chain;

/// All candidates for this robot and data but those of some families, named ones first.
pub(crate) fn candidates(chain: &Chain, data: &Dataset, without: &[Family]) -> Vec<Candidate> {
    let mut all = named(chain, data, without);
    if !without.contains(&Family::Unmodelled) {
        let setting = Setting { chain, data };
        unmodelled::add(&setting, &mut all);
        loaded::add_nameless(&setting, &mut all);
    }
    all
}

/// All candidates that have a name.
pub(crate) fn named(chain: &Chain, data: &Dataset, without: &[Family]) -> Vec<Candidate> {
    let setting = Setting { chain, data };
    let mut all = Vec::new();
    constant::add(&setting, &mut all);
    compliance::add(&setting, &mut all);
    payload::add(&setting, &mut all);
    loaded::add(&setting, &mut all);
    motion::add(&setting, &mut all);
    guideway::add(&setting, &mut all);
    thermal::add(&setting, &mut all);
    time::add(&setting, &mut all);
    all.retain(|candidate| !without.contains(&candidate.family));
    // What does not fit this robot (a link without a length) is no candidate.
    all.retain(|candidate| candidate.effects().iter().all(|effect| effect.validate(chain).is_ok()));
    all
}

#[cfg(test)]
mod tests {
    use super::*;
    use truepose_kinematics::{Load, samples};

    #[test]
    fn a_family_that_is_not_looked_for_has_no_candidate() {
        let chain = samples::scara();
        let rows = 10;
        let column = |joint: usize| (0..rows).map(|row| 0.02 * ((row + joint) as f64)).collect();
        let data = Dataset {
            joints: (0..chain.movable().len()).map(column).collect(),
            position: vec![[0.0; 3]; rows],
            target: vec![None; rows],
            visit: (0..rows).collect(),
            load: vec![Load::None; rows],
            time: vec![0.0; rows],
            approach: vec![vec![0.0; rows]; chain.movable().len()],
            ..Dataset::default()
        };
        let families = |without: &[Family]| -> Vec<Family> {
            candidates(&chain, &data, without).iter().map(|candidate| candidate.family).collect()
        };
        let all = families(&[]);
        assert!(all.contains(&Family::Transmission) && all.contains(&Family::Guideway));
        let fewer = families(&[Family::Transmission]);
        assert!(!fewer.contains(&Family::Transmission) && fewer.contains(&Family::Guideway));
        assert!(fewer.len() < all.len());
    }

    #[test]
    fn a_load_bends_where_there_is_one_under_a_name_and_without() {
        let chain = samples::ur10();
        let rows = 40;
        let column = |joint: usize| (0..rows).map(|row| (0.7 * ((row * (joint + 3)) as f64)).sin()).collect();
        let carried = Load::Payload(truepose_kinematics::Payload { mass: 5.0, com: [0.0; 3].into() });
        let data = Dataset {
            joints: (0..chain.movable().len()).map(column).collect(),
            position: vec![[0.0; 3]; rows],
            target: vec![None; rows],
            visit: (0..rows).collect(),
            load: vec![carried; rows],
            time: vec![0.0; rows],
            approach: vec![vec![0.0; rows]; chain.movable().len()],
            ..Dataset::default()
        };
        let curves = |family: Family| -> Vec<String> {
            let follows = |candidate: &&Candidate| {
                let text = candidate.effects().iter().map(|e| e.parameters().to_string()).collect::<String>();
                candidate.family == family && text.contains("load") && text.contains("spline")
            };
            let all = candidates(&chain, &data, &[]);
            let mut words: Vec<String> = all.iter().filter(follows).map(Candidate::words).collect();
            words.dedup();
            words
        };
        let named = curves(Family::LoadNonlinearity);
        // The first joint turns about the vertical: no weight loads it.
        assert_eq!(named[..2], ["load_nonlinearity j2", "load_nonlinearity j3"]);
        assert_eq!(curves(Family::Unmodelled)[0], "unmodelled j2 on load_j2");
        assert_eq!(curves(Family::Unmodelled).len(), named.len());
    }
}
