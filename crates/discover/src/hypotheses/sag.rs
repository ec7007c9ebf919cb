//! Slides that give way where they are: a rail or bridge between its posts, a ram that is longer the farther it is out.

use crate::hypotheses::driver::Driver;
use crate::hypotheses::family::Family;
use crate::hypotheses::hypothesis::Hypothesis;
use crate::hypotheses::limits::Limit;
use crate::hypotheses::nonlinear::{Nonlinear, Refinement};
use crate::hypotheses::place::Place;
use crate::hypotheses::setting::Setting;
use crate::hypotheses::variant::Variant;
use truepose_errormodel::AnyEffect;
use truepose_errormodel::effects::{Guideway, LinkCompliance};
use truepose_kinematics::JointId;

/// A rail sags by what it carries and where.
#[derive(Debug)]
pub(crate) struct SaggingRail;

/// A ram bends with its extension.
#[derive(Debug)]
pub(crate) struct Ram;

/// Slides that moved, with their visited travel, m.
fn slides<'s>(setting: &'s Setting<'_>) -> impl Iterator<Item = (JointId, [f64; 2])> + use<'s> {
    let moved = setting.chain.movable().iter().filter(|&&joint| setting.slides(joint));
    moved.filter_map(|&joint| Some((joint, setting.range(joint)?)))
}

/// Whether some joint's load differs between poses: else a sag is a curve of the rail.
fn carries(setting: &Setting<'_>) -> bool {
    setting.chain.movable().iter().any(|&joint| setting.load_range(joint).is_some())
}

impl Hypothesis for SaggingRail {
    fn family(&self) -> Family {
        Family::Guideway
    }

    fn variants(&self, setting: &Setting<'_>) -> Vec<Variant> {
        if !carries(setting) {
            return Vec::new();
        }
        let one = |(joint, range)| {
            let place = Place { mode: Some("by_load".into()), ..Place::joint(setting.chain, joint) };
            [1, 2].map(|pieces| Variant::new(place.clone(), Guideway::sagging(joint, range, pieces)))
        };
        slides(setting).flat_map(one).collect()
    }

    fn meaning(&self, place: &Place) -> String {
        format!(
            "The rail or bridge of {} sags under what it carries, by another amount at each place. Inspect its supports, and the bolts between them.",
            place.part()
        )
    }

    fn drivers(&self, place: &Place, _: &[Box<dyn AnyEffect>]) -> Vec<Driver> {
        place.joint.clone().map(Driver::Joint).into_iter().chain([Driver::Wrench]).collect()
    }

    // Links and bases that yield alike are simpler.
    fn rank(&self) -> Family {
        Family::LinkCompliance
    }
}

impl Hypothesis for Ram {
    fn family(&self) -> Family {
        Family::LinkCompliance
    }

    fn variants(&self, setting: &Setting<'_>) -> Vec<Variant> {
        if !carries(setting) {
            return Vec::new();
        }
        let mut all = Vec::new();
        for (joint, [lower, upper]) in slides(setting) {
            let place = Place { mode: Some("ram".into()), ..Place::joint(setting.chain, joint) };
            // What is out at its shortest: a part of the travel, up to three times as long.
            for retracts in [false, true] {
                let shortest = if retracts { upper } else { -lower };
                for part in [0.1, 0.5, 1.5] {
                    let length = shortest + part * (upper - lower);
                    all.push(Variant::new(place.clone(), LinkCompliance::ram(joint, length, retracts)));
                }
            }
        }
        all
    }

    fn meaning(&self, place: &Place) -> String {
        format!(
            "The ram of {} bends more the farther it is out. Inspect its guide and the play of its bearings, or keep heavy work near.",
            place.part()
        )
    }

    fn drivers(&self, place: &Place, _: &[Box<dyn AnyEffect>]) -> Vec<Driver> {
        place.joint.clone().map(Driver::Joint).into_iter().chain([Driver::Wrench]).collect()
    }

    fn limits(&self) -> &[Limit] {
        &[Limit::FirstNotNegative]
    }

    fn nonlinear(&self, effect: &dyn AnyEffect) -> Option<Nonlinear> {
        let length = effect.concrete::<LinkCompliance>()?.ram?;
        Some(Nonlinear::new(length, Refinement::Within([length - REACH, length + REACH])))
    }

    fn with_value(
        &self,
        effect: &dyn AnyEffect,
        value: f64,
        range: Option<[f64; 2]>,
    ) -> Option<Box<dyn AnyEffect>> {
        let ram = effect.concrete::<LinkCompliance>()?.clone();
        Some(Box::new(LinkCompliance { ram: Some(value), ram_range: range, ..ram }))
    }
}

/// How far from a variant the free length is looked for, m.
const REACH: f64 = 0.3;
