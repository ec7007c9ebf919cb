//! Backlash: a joint error that switches with the side of approach or with the load, and friction that winds a drive up along the way.
//!
//! A drive with friction is told from one with a dead band by short reversals alone: after moves much longer than the pre-sliding distance w
//! both are on the side of approach. Distances are proposed between those of which one move in [`FEW`] is short enough to tell (z turns round
//! by 1 − e^−3 = 95 % over 3 w), and [`LONGEST`] of the visited range: real drives wind up over fractions of a degree to some degrees, and what is slower
//! than that is a curve over the way and no friction. Where no move is as short, there is no candidate.

use crate::hypotheses::compliance::weights_declared;
use crate::hypotheses::driver::Driver;
use crate::hypotheses::family::Family;
use crate::hypotheses::hypothesis::Hypothesis;
use crate::hypotheses::limits::Limit;
use crate::hypotheses::nonlinear::{Nonlinear, Refinement};
use crate::hypotheses::place::Place;
use crate::hypotheses::setting::Setting;
use crate::hypotheses::variant::Variant;
use crate::hypotheses::view::TraceView;
use truepose_errormodel::AnyEffect;
use truepose_errormodel::effects::{Backlash, Side};
use truepose_kinematics::JointId;

/// Centres of mass that are tried where no weights are declared ([`Backlash::center`]): from a heavy upper arm to a heavy tool. A robot
/// with forearm and upper arm alike lies at 0.33; motors at the elbow move it down, a payload up.
const CENTERS: [f64; 4] = [0.1, 0.25, 0.5, 1.0];
/// One move in so many is to be short enough.
const FEW: usize = 10;
/// Part of the visited range.
const LONGEST: f64 = 0.2;
/// From one distance to the next, and the reach of the refinement about each ([`Refinement::Scale`]): neighbours overlap.
const RATIO: f64 = 2.5;

/// A joint has backlash.
#[derive(Debug)]
pub(crate) struct LostMotion;

impl Hypothesis for LostMotion {
    fn family(&self) -> Family {
        Family::Backlash
    }

    fn variants(&self, setting: &Setting<'_>) -> Vec<Variant> {
        let chain = setting.chain;
        let approach = setting.data.schema.approach;
        let mut all = Vec::new();
        for &joint in chain.movable().iter().filter(|&&joint| setting.range(joint).is_some()) {
            let place = Place::joint(chain, joint);
            if approach {
                all.push(Variant::new(place.clone(), Backlash::of(joint, Side::Approach)));
            }
            all.push(Variant::new(place.clone(), Backlash::of(joint, Side::Load)));
            if approach && setting.load_range(joint).is_some() {
                all.push(Variant::new(place.clone(), Backlash::of(joint, Side::ByLoad)));
            }
            // Of a tree of several arms nobody knows which of them weighs most.
            if chain.is_serial() && !weights_declared(chain) {
                let assumed = CENTERS.map(|center| Backlash::by_weight(joint, center));
                all.extend(assumed.map(|effect| Variant::new(place.clone(), effect)));
            }
            for flank in flanks(setting, joint) {
                for side in [Side::Load, Side::LoadThenApproach] {
                    if side == Side::Load || approach {
                        let play = Backlash::of(joint, side);
                        let effect = Backlash { flank_load: Some(flank), flank_range: None, ..play };
                        all.push(Variant::new(place.clone(), effect));
                    }
                }
            }
            let wound = |width| Variant::new(place.clone(), Backlash::presliding(joint, width));
            all.extend(widths(setting, joint).into_iter().map(wound));
        }
        all
    }

    fn meaning(&self, place: &Place) -> String {
        format!(
            "The error of {} depends on the direction from which it comes. Inspect gear backlash, belt tension, preload, and friction of \
             seals and bearings.",
            place.part()
        )
    }

    fn drivers(&self, place: &Place, _: &[Box<dyn AnyEffect>]) -> Vec<Driver> {
        place.joint.clone().map(Driver::Joint).into_iter().collect()
    }

    fn view(&self, place: &Place, effects: &[Box<dyn AnyEffect>]) -> TraceView {
        let play = effects.first().and_then(|effect| effect.concrete::<Backlash>());
        let by_load = play.is_some_and(|play| !matches!(play.side, Side::Approach | Side::Weight));
        let driver = if by_load { Driver::JointLoad } else { Driver::Joint };
        TraceView::of_motion(place.joint.clone().map(driver)).by_approach()
    }

    fn limits(&self) -> &[Limit] {
        &[Limit::FirstNotNegative, Limit::DriveAngle]
    }

    fn nonlinear(&self, effect: &dyn AnyEffect) -> Option<Nonlinear> {
        let play = effect.concrete::<Backlash>()?;
        if let Some([lower, _]) = play.between {
            return Some(Nonlinear::new(lower, Refinement::Edge(play.joint)));
        }
        if let Some(width) = play.width {
            return Some(Nonlinear::new(width, Refinement::Scale([1.0 / RATIO, RATIO])));
        }
        if let Some(center) = play.center {
            return Some(Nonlinear::new(center, Refinement::Plateau([0.4, 1.8])));
        }
        Some(Nonlinear::new(play.flank_load?, Refinement::Scale([0.4, 1.8])))
    }

    fn with_value(
        &self,
        effect: &dyn AnyEffect,
        value: f64,
        range: Option<[f64; 2]>,
    ) -> Option<Box<dyn AnyEffect>> {
        let play = effect.concrete::<Backlash>()?.clone();
        if let Some([_, upper]) = play.between {
            return Some(Box::new(Backlash { between: Some([value, upper]), ..play }));
        }
        if play.side == Side::Presliding {
            return Some(Box::new(Backlash { width: Some(value), width_range: range, ..play }));
        }
        if play.side == Side::Weight {
            return Some(Box::new(Backlash { center: Some(value), center_range: range, ..play }));
        }
        Some(Box::new(Backlash { flank_load: Some(value), flank_range: range, ..play }))
    }

    fn second(&self, effect: &dyn AnyEffect) -> Option<Nonlinear> {
        let play = effect.concrete::<Backlash>()?;
        Some(Nonlinear::new(play.between?[1], Refinement::Edge(play.joint)))
    }

    fn with_second(
        &self,
        effect: &dyn AnyEffect,
        value: f64,
        _: Option<[f64; 2]>,
    ) -> Option<Box<dyn AnyEffect>> {
        let play = effect.concrete::<Backlash>()?.clone();
        let between = Some([play.between?[0], value]);
        Some(Box::new(Backlash { between, ..play }))
    }

    // Local wear: in a part of the travel.
    fn richer_in(&self, effect: &dyn AnyEffect, setting: &Setting<'_>) -> Vec<Box<dyn AnyEffect>> {
        let Some(play) = effect.concrete::<Backlash>() else { return Vec::new() };
        if play.between.is_some() || play.side != Side::Approach {
            return Vec::new();
        }
        parts(setting, play.joint)
            .map(|part| Backlash { between: Some(part), ..play.clone() }.boxed())
            .collect()
    }
}

/// Parts of the visited travel in which a joint may be worn: all runs of sixths but the whole.
pub(crate) fn parts(setting: &Setting<'_>, joint: JointId) -> impl Iterator<Item = [f64; 2]> {
    const PARTS: usize = 6;
    let range = setting.range(joint);
    range.into_iter().flat_map(|[lower, upper]| {
        let margin = 1e-6 * (upper - lower);
        let at = move |k: usize| match k {
            0 => lower - margin,
            PARTS => upper + margin,
            _ => lower + (upper - lower) * k as f64 / PARTS as f64,
        };
        let runs = (0..PARTS).flat_map(|from| (from + 1..=PARTS).map(move |to| (from, to)));
        runs.filter(|&(from, to)| to - from < PARTS).map(move |(from, to)| [at(from), at(to)])
    })
}

/// Loads at which play may be taken up: shares of the largest load seen.
fn flanks(setting: &Setting<'_>, joint: JointId) -> Vec<f64> {
    let largest = setting.largest_load(joint);
    if largest > 0.0 { vec![0.03 * largest, 0.1 * largest, 0.25 * largest] } else { Vec::new() }
}

/// Pre-sliding distances that the moves of a joint can tell from a dead band, rad or m.
fn widths(setting: &Setting<'_>, joint: JointId) -> Vec<f64> {
    let Some([lower, upper]) = setting.range(joint) else { return Vec::new() };
    let moves = setting.moves(joint);
    let Some(short) = moves.get(moves.len() / FEW) else { return Vec::new() };
    let (shortest, longest) = (short / 3.0, LONGEST * (upper - lower));
    if shortest > longest {
        return Vec::new();
    }
    // At most five, so that there are candidates in proportion to joints.
    let count = ((longest / shortest).ln() / RATIO.ln()).ceil().clamp(0.0, 4.0) as i32;
    (0..=count).map(|k| shortest * RATIO.powi(k)).filter(|&width| width <= longest * RATIO).collect()
}
