//! What a joint does beyond what it reports: play, gears, what other joints do to it.

use crate::hypotheses::candidate::Candidate;
use crate::hypotheses::family::Family;
use crate::hypotheses::place::Place;
use crate::hypotheses::setting::Setting;
use std::f64::consts::TAU;
use truepose_errormodel::effects::{Backlash, Coupling, Side, Transmission};
use truepose_kinematics::JointId;

pub(crate) fn add(setting: &Setting<'_>, all: &mut Vec<Candidate>) {
    let chain = setting.chain;
    for &joint in chain.movable() {
        let Some([lower, upper]) = setting.range(joint) else { continue };
        let place = Place::joint(chain, joint);
        let turns = !setting.slides(joint);
        if turns {
            for harmonics in [vec![1], vec![2], vec![1, 2], vec![1, 2, 3], vec![1, 2, 3, 4], vec![3], vec![4]]
            {
                let effect = Transmission { joint, harmonics, period: Some(TAU), period_range: None };
                all.push(Candidate::new(Family::Transmission, place.clone(), effect));
            }
        }
        // Long periods that the quick scan leaves out.
        let travel = upper - lower;
        let unit = if turns { TAU } else { 2.0 * travel };
        let periods = (1..=8).map(|cycles| unit / (0.5 + 0.4 * f64::from(cycles)));
        for period in periods.filter(|&p| p <= longest(turns, travel)) {
            all.push(transmission_at(setting.chain, joint, &[period]));
        }
        if setting.data.schema.approach {
            all.push(Candidate::new(Family::Backlash, place.clone(), Backlash::of(joint, Side::Approach)));
        }
        all.push(Candidate::new(Family::Backlash, place.clone(), Backlash::of(joint, Side::Load)));
        for flank in flanks(setting, joint) {
            for side in [Side::Load, Side::LoadThenApproach] {
                if side == Side::Load || setting.data.schema.approach {
                    let effect =
                        Backlash { flank_load: Some(flank), flank_range: None, ..Backlash::of(joint, side) };
                    all.push(Candidate::new(Family::Backlash, place.clone(), effect));
                }
            }
        }
        for &driver in chain.movable().iter().filter(|&&driver| driver != joint) {
            let Some(range) = setting.range(driver) else { continue };
            let mut place = place.clone();
            place.driver = Some(chain.joint(driver).name.clone());
            let linear = Coupling { range: Some(range), ..Coupling::of(joint, driver) };
            for degree in [1, 2, 3] {
                let effect = Coupling { degree, ..linear.clone() };
                all.push(Candidate::new(Family::Coupling, place.clone(), effect));
            }
            if !setting.slides(driver) {
                let effect = Coupling { degree: 0, harmonics: vec![1], ..linear };
                all.push(Candidate::new(Family::Coupling, place, effect));
            }
        }
    }
}

/// Periods of one joint as one cause.
pub(crate) fn transmission_at(
    chain: &truepose_kinematics::Chain,
    joint: JointId,
    periods: &[f64],
) -> Candidate {
    let effects = periods.iter().map(|&p| {
        let effect: Box<dyn truepose_errormodel::AnyEffect> = Box::new(Transmission::of(joint, p));
        effect
    });
    Candidate {
        family: Family::Transmission,
        place: Place::joint(chain, joint),
        change: crate::hypotheses::candidate::Change::Add(effects.collect()),
        width: None,
    }
}

/// Loads at which play may be taken up: shares of the largest load seen.
fn flanks(setting: &Setting<'_>, joint: JointId) -> Vec<f64> {
    let largest = setting.largest_load(joint);
    if largest > 0.0 { vec![0.03 * largest, 0.1 * largest, 0.25 * largest] } else { Vec::new() }
}

/// The longest period that an error of a drive may have and that is found rather than known, rad or m: the visited travel, and at most a turn
/// and a little. Of what is slower not even one cycle was seen: it is a curve, and no drive's period.
pub(crate) fn longest(turns: bool, travel: f64) -> f64 {
    if turns { travel.min(TAU / 0.9) } else { travel }
}
