//! The hypotheses of a search.
//!
//! One file for each sort of cause. A cause at one place comes in several *variants*, from simple to rich; nonlinear parameters (a period, an
//! instant, a lag) come as a grid that is refined later.

use crate::hypotheses::backlash::LostMotion;
use crate::hypotheses::candidate::Candidate;
use crate::hypotheses::compliance::{OfBase, OfJoints, OfLinks};
use crate::hypotheses::constant::{OfFrames, OfTargets};
use crate::hypotheses::coupling::Drag;
use crate::hypotheses::family::Family;
use crate::hypotheses::guideway::Rail;
use crate::hypotheses::hypothesis::Hypothesis;
use crate::hypotheses::instrument::{JointLog, LengthScale, LineOfSight, Refraction};
use crate::hypotheses::linkage::Parallelogram;
use crate::hypotheses::loaded::CurvedSpring;
use crate::hypotheses::measured_torque::OfMeasuredTorque;
use crate::hypotheses::own_motion::{OwnCurve, OwnGain};
use crate::hypotheses::payload::WrongPayload;
use crate::hypotheses::sag::{Ram, SaggingRail};
use crate::hypotheses::self_heating::SelfHeating;
use crate::hypotheses::setting::Setting;
use crate::hypotheses::thermal::{ArmGrowth, Gradient, Growth};
use crate::hypotheses::time::{Jump, Slow};
use crate::hypotheses::transmission::Drive;
use crate::hypotheses::unmodelled::Unmodelled;
use crate::hypotheses::variant::Variant;
use crate::hypotheses::yielding::{Counterbalance, Creep, SoftWhenWarm, TiltingBearing};
use std::collections::HashMap;
use std::sync::Arc;
use truepose_errormodel::Dataset;
use truepose_kinematics::{Chain, JointId};

/// The hypotheses that a search tests, in order. A library is a value: [`Library::with`] and [`Library::without`] make another one.
///
/// Outliers are always looked for, since they stand in the way of everything else; they are no hypothesis of a library.
#[derive(Debug, Clone)]
pub struct Library {
    /// Those of one group are interleaved by joint.
    groups: Vec<Vec<Arc<dyn Hypothesis>>>,
}

impl Library {
    /// All built-in hypotheses.
    pub fn standard() -> Self {
        let groups = vec![
            vec![Arc::new(OfFrames) as Arc<dyn Hypothesis>],
            vec![Arc::new(OfTargets)],
            vec![
                Arc::new(OfJoints),
                Arc::new(OfMeasuredTorque),
                Arc::new(CurvedSpring),
                Arc::new(TiltingBearing),
                Arc::new(Creep),
                Arc::new(SoftWhenWarm),
                Arc::new(Counterbalance),
                Arc::new(OfLinks),
                Arc::new(Ram),
                Arc::new(OfBase),
            ],
            vec![Arc::new(WrongPayload)],
            vec![
                Arc::new(Drive),
                Arc::new(OwnGain),
                Arc::new(OwnCurve),
                Arc::new(LostMotion),
                Arc::new(Drag),
                Arc::new(Parallelogram),
            ],
            vec![Arc::new(Rail), Arc::new(SaggingRail)],
            vec![Arc::new(JointLog), Arc::new(LengthScale), Arc::new(Refraction), Arc::new(LineOfSight)],
            vec![Arc::new(Growth), Arc::new(Gradient), Arc::new(ArmGrowth), Arc::new(SelfHeating)],
            vec![Arc::new(Slow), Arc::new(Jump)],
            vec![Arc::new(Unmodelled)],
        ];
        Library { groups }
    }

    /// No hypotheses.
    pub fn empty() -> Self {
        Library { groups: Vec::new() }
    }

    /// With a further hypothesis. Two of one family stand beside each other.
    #[must_use]
    pub fn with(mut self, hypothesis: impl Hypothesis + 'static) -> Self {
        self.groups.push(vec![Arc::new(hypothesis)]);
        self
    }

    /// Without the hypotheses of a family: to see what the search makes of a cause that it has no word for.
    #[must_use]
    pub fn without(mut self, family: Family) -> Self {
        for group in &mut self.groups {
            group.retain(|hypothesis| hypothesis.family() != family);
        }
        self
    }

    /// The hypotheses.
    pub fn hypotheses(&self) -> impl Iterator<Item = &Arc<dyn Hypothesis>> {
        self.groups.iter().flatten()
    }

    /// The family with this word among those of the hypotheses.
    pub fn family(&self, word: &str) -> Option<Family> {
        self.hypotheses().map(|hypothesis| hypothesis.family()).find(|family| family.word() == word)
    }

    /// All candidates for a robot and its data, named ones first.
    pub(crate) fn candidates(&self, chain: &Chain, data: &Dataset) -> Vec<Candidate> {
        let mut all = self.named(chain, data);
        all.extend(self.collected(&Setting::new(chain, data), |family| !family.is_named()));
        all
    }

    /// All candidates that have a name.
    pub(crate) fn named(&self, chain: &Chain, data: &Dataset) -> Vec<Candidate> {
        self.collected(&Setting::new(chain, data), Family::is_named)
    }

    /// The hypotheses that have a period in the value of a joint.
    pub(crate) fn periodic(&self, joint: JointId) -> impl Iterator<Item = &Arc<dyn Hypothesis>> {
        self.hypotheses().filter(move |hypothesis| hypothesis.at_period(joint, 1.0).is_some())
    }

    /// The candidates of some families. What does not fit this robot (a link without a length) is no candidate.
    fn collected(&self, setting: &Setting<'_>, wanted: impl Fn(Family) -> bool) -> Vec<Candidate> {
        let fits = |variant: &Variant| {
            variant.change.effects().iter().all(|effect| effect.validate(setting.chain).is_ok())
        };
        let mut all = Vec::new();
        for group in &self.groups {
            let first = all.len();
            for hypothesis in group.iter().filter(|hypothesis| wanted(hypothesis.family())) {
                let variants = hypothesis.variants(setting).into_iter().filter(fits);
                all.extend(variants.map(|variant| Candidate::new(Arc::clone(hypothesis), variant)));
            }
            if group.len() > 1 {
                by_joint(&mut all[first..]);
            }
        }
        all
    }
}

/// Brings together what concerns one joint, in the order in which joints come first.
fn by_joint(candidates: &mut [Candidate]) {
    let mut first: HashMap<Option<String>, usize> = HashMap::new();
    for candidate in candidates.iter() {
        let next = first.len();
        first.entry(candidate.place.joint.clone()).or_insert(next);
    }
    candidates.sort_by_key(|candidate| first[&candidate.place.joint]);
}

impl Default for Library {
    fn default() -> Self {
        Library::standard()
    }
}

/// Libraries are equal when their hypotheses have the same families in the same order.
impl PartialEq for Library {
    fn eq(&self, other: &Self) -> bool {
        self.hypotheses().map(|h| h.family()).eq(other.hypotheses().map(|h| h.family()))
    }
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
        let families = |library: Library| -> Vec<Family> {
            library.candidates(&chain, &data).iter().map(|candidate| candidate.family).collect()
        };
        let all = families(Library::standard());
        assert!(all.contains(&Family::Transmission) && all.contains(&Family::Guideway));
        let fewer = families(Library::standard().without(Family::Transmission));
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
            let all = Library::standard().candidates(&chain, &data);
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

    /// A robot that moves in all joints, is loaded, and has a time.
    fn eventful() -> (Chain, Dataset) {
        let chain = samples::ur10();
        let rows = 40;
        let column = |joint: usize| (0..rows).map(|row| (0.7 * ((row * (joint + 3)) as f64)).sin()).collect();
        let carried = Load::Payload(truepose_kinematics::Payload { mass: 5.0, com: [0.1, 0.0, 0.0].into() });
        let mut data = Dataset {
            joints: (0..chain.movable().len()).map(column).collect(),
            position: vec![[0.0; 3]; rows],
            target: vec![None; rows],
            visit: (0..rows).collect(),
            load: vec![carried; rows],
            time: (0..rows).map(|row| 10.0 * row as f64).collect(),
            approach: vec![vec![1.0; rows]; chain.movable().len()],
            ..Dataset::default()
        };
        data.schema.time = true;
        data.schema.approach = true;
        (chain, data)
    }

    #[test]
    fn candidates_at_one_joint_are_side_by_side() {
        let (chain, data) = eventful();
        let all = Library::standard().named(&chain, &data);
        let mut causes: Vec<String> = all
            .iter()
            .filter(|c| [Family::Transmission, Family::Backlash].contains(&c.family))
            .map(Candidate::words)
            .collect();
        causes.dedup();
        let names: Vec<&str> =
            chain.movable().iter().map(|&joint| chain.joint(joint).name.as_str()).collect();
        let expected: Vec<String> =
            names.iter().flat_map(|j| [format!("transmission {j}"), format!("backlash {j}")]).collect();
        assert_eq!(causes, expected);
    }

    #[test]
    fn a_nonlinear_parameter_keeps_its_effect_and_can_be_released() {
        let (chain, data) = eventful();
        let mut families = Vec::new();
        for candidate in Library::standard().named(&chain, &data) {
            let hypothesis = candidate.hypothesis();
            for effect in candidate.effects() {
                let Some(found) = hypothesis.nonlinear(&**effect) else { continue };
                families.push(candidate.family);
                let same = hypothesis.with_value(&**effect, found.value, None).unwrap();
                assert_eq!(same.parameters(), effect.parameters(), "{}", candidate.words());
                let range = [0.5 * found.value, 2.0 * found.value];
                let free = hypothesis.with_value(&**effect, found.value, Some(range)).unwrap().shape();
                assert_eq!((free.len(), free[0].value), (1, found.value), "{}", candidate.words());
                let other = hypothesis.with_value(&**effect, 1.5 * found.value, None).unwrap();
                let difference = hypothesis.nonlinear(&*other).unwrap().value - 1.5 * found.value;
                // The very number that was given.
                assert!(difference.abs() <= 0.0, "{}", candidate.words());
            }
        }
        families.sort_unstable();
        families.dedup();
        let expected = [
            Family::JointCompliance,
            Family::Backlash,
            Family::Transmission,
            Family::Coupling,
            Family::LoadNonlinearity,
            Family::Shift,
            Family::Thermal,
            Family::Drift,
        ];
        assert_eq!(families, expected);
    }

    #[test]
    fn libraries_are_values() {
        let all = Library::standard();
        let fewer = all.clone().without(Family::Drift);
        assert_eq!(all.hypotheses().count(), fewer.hypotheses().count() + 1);
        assert_ne!(all, fewer);
        assert_eq!(all.family("drift"), Some(Family::Drift));
        assert_eq!(fewer.family("drift"), None);
        assert_eq!(Library::empty().with(Slow).family("drift"), Some(Family::Drift));
        assert_eq!(Library::empty().candidates(&eventful().0, &eventful().1).len(), 0);
    }
}
