//! What moves with time: smoothly, or all at once.

use crate::hypotheses::components::of_spot;
use crate::hypotheses::driver::Driver;
use crate::hypotheses::family::Family;
use crate::hypotheses::hypothesis::Hypothesis;
use crate::hypotheses::nonlinear::{Nonlinear, Refinement};
use crate::hypotheses::penalty::Penalty;
use crate::hypotheses::place::Place;
use crate::hypotheses::setting::Setting;
use crate::hypotheses::variant::Variant;
use truepose_errormodel::effects::{Drift, Shift, Spot};
use truepose_errormodel::{AnyEffect, Dataset, Visits};
use truepose_kinematics::{Axis, Chain, FrameId};

/// A jump needs this many visits on either side.
const EDGE: usize = 4;
/// Instants tried at first.
const INSTANTS: usize = 64;

/// Other ends of an interval that are tried at first.
const ENDS: usize = 16;

/// Places that may move with time.
fn spots(chain: &Chain) -> impl Iterator<Item = Spot> {
    let frames = [Spot::Frame(FrameId::BASE), Spot::Frame(chain.tool_frame())];
    frames.into_iter().chain(chain.movable().iter().map(|&joint| Spot::Joint(joint)))
}

/// The link behind each joint, as what grows with time where nobody measured its temperature: the frame behind the joint, displaced along
/// the link.
fn lengths(chain: &Chain) -> impl Iterator<Item = (Place, Spot, Vec<Axis>)> {
    /// A component of the link's direction that is smaller is none.
    const ALONG: f64 = 0.2;
    chain.movable().iter().filter_map(|&joint| {
        let (root, tip) = chain.link(joint);
        let (span, length) = (tip - root, chain.link_length(joint));
        let along =
            Axis::TRANSLATIONS.into_iter().filter(|axis| span[axis.direction()].abs() > ALONG * length);
        let spot = Spot::Frame(chain.frame_after(joint));
        (length > 1e-6).then(|| (Place::joint(chain, joint), spot, along.collect()))
    })
}

/// A place moves smoothly with time.
#[derive(Debug)]
pub(crate) struct Slow;

impl Hypothesis for Slow {
    fn family(&self) -> Family {
        Family::Drift
    }

    fn variants(&self, setting: &Setting<'_>) -> Vec<Variant> {
        let Some(range) = setting.record_range() else { return Vec::new() };
        let places = spots(setting.chain).map(|spot| (Place::spot(setting.chain, spot), spot, None));
        let growing = lengths(setting.chain).map(|(place, spot, along)| (place, spot, Some(along)));
        let mut all = Vec::new();
        for (place, spot, components) in places.chain(growing) {
            let smooth = [1, 2, 4, 8].map(|pieces| Drift::smooth(spot, range, pieces));
            let settling = [0.05, 0.1, 0.2, 0.4, 0.8]
                .map(|share| Drift::settling(spot, range, share * (range[1] - range[0])));
            for drift in smooth.into_iter().chain(settling) {
                all.push(Variant::new(place.clone(), Drift { components: components.clone(), ..drift }));
            }
        }
        all
    }

    fn meaning(&self, place: &Place) -> String {
        format!(
            "The error of {} changes slowly with time: warm-up, settling, or drift of the instrument{}. Warm up longer, or \
             measure a fixed point at intervals.",
            place.part(),
            stand(place)
        )
    }

    fn drivers(&self, _: &Place, _: &[Box<dyn AnyEffect>]) -> Vec<Driver> {
        vec![Driver::Time]
    }

    fn rank(&self) -> Family {
        Family::Shift
    }

    fn penalty(&self, _: &[Box<dyn AnyEffect>]) -> Penalty {
        Penalty::MarginalLikelihood
    }

    fn is_curve(&self) -> bool {
        true
    }

    fn nonlinear(&self, effect: &dyn AnyEffect) -> Option<Nonlinear> {
        let constant = effect.concrete::<Drift>()?.time_constant?;
        Some(Nonlinear::new(constant, Refinement::Scale([0.4, 2.5])))
    }

    fn with_value(
        &self,
        effect: &dyn AnyEffect,
        value: f64,
        range: Option<[f64; 2]>,
    ) -> Option<Box<dyn AnyEffect>> {
        let drift = effect.concrete::<Drift>()?.clone();
        Some(Box::new(Drift { time_constant: Some(value), time_constant_range: range, ..drift }))
    }

    fn second(&self, effect: &dyn AnyEffect) -> Option<Nonlinear> {
        let constant = effect.concrete::<Drift>()?.second_time_constant?;
        Some(Nonlinear::new(constant, Refinement::Scale([0.4, 2.5])))
    }

    fn with_second(
        &self,
        effect: &dyn AnyEffect,
        value: f64,
        range: Option<[f64; 2]>,
    ) -> Option<Box<dyn AnyEffect>> {
        let drift = effect.concrete::<Drift>()?.clone();
        let (second_time_constant, second_time_constant_range) = (Some(value), range);
        Some(Box::new(Drift { second_time_constant, second_time_constant_range, ..drift }))
    }

    // Housings and castings: a second time constant, on either side of the first.
    fn richer_in(&self, effect: &dyn AnyEffect, _: &Setting<'_>) -> Vec<Box<dyn AnyEffect>> {
        let Some(drift) = effect.concrete::<Drift>() else { return Vec::new() };
        let Some(constant) = drift.time_constant else { return Vec::new() };
        let of = |factor: f64| {
            let second_time_constant = Some(factor * constant);
            Drift { second_time_constant, ..drift.clone() }.boxed()
        };
        [0.2, 5.0].map(of).into()
    }

    fn neighbours(&self, effect: &dyn AnyEffect) -> Vec<Box<dyn AnyEffect>> {
        let Some(drift) = effect.concrete::<Drift>() else { return Vec::new() };
        of_spot(drift.spot, drift.components.as_deref(), |axes| {
            Drift { components: Some(axes), ..drift.clone() }.boxed()
        })
    }
}

/// A place jumps once.
#[derive(Debug)]
pub(crate) struct Jump;

impl Hypothesis for Jump {
    fn family(&self) -> Family {
        Family::Shift
    }

    fn variants(&self, setting: &Setting<'_>) -> Vec<Variant> {
        if setting.record_range().is_none() {
            return Vec::new();
        }
        let instants = instants(setting.data);
        let stride = instants.len().div_ceil(INSTANTS).max(1);
        let at = |spot| instants.iter().step_by(stride).map(move |&at| (spot, at));
        let jump = |(spot, at)| Variant::new(Place::spot(setting.chain, spot), Shift::of(spot, at));
        spots(setting.chain).flat_map(at).map(jump).collect()
    }

    fn meaning(&self, place: &Place) -> String {
        format!(
            "The error of {} jumped: a collision, a changed part or a new installation{}. Check the log at that time, and whether it was put \
             right later.",
            place.part(),
            stand(place)
        )
    }

    fn drivers(&self, _: &Place, _: &[Box<dyn AnyEffect>]) -> Vec<Driver> {
        vec![Driver::Time]
    }

    fn penalty(&self, _: &[Box<dyn AnyEffect>]) -> Penalty {
        Penalty::MarginalLikelihood
    }

    fn nonlinear(&self, effect: &dyn AnyEffect) -> Option<Nonlinear> {
        let jump = effect.concrete::<Shift>()?;
        Some(Nonlinear::new(jump.at, Refinement::Instant { gap: jump.gap }))
    }

    fn with_value(
        &self,
        effect: &dyn AnyEffect,
        value: f64,
        range: Option<[f64; 2]>,
    ) -> Option<Box<dyn AnyEffect>> {
        let jump = effect.concrete::<Shift>()?.clone();
        Some(Box::new(Shift { at: value, at_range: range, ..jump }))
    }

    fn second(&self, effect: &dyn AnyEffect) -> Option<Nonlinear> {
        let jump = effect.concrete::<Shift>()?;
        match (jump.until, jump.settling) {
            (Some(until), _) => Some(Nonlinear::new(until, Refinement::Instant { gap: None })),
            (None, settling) => Some(Nonlinear::new(settling?, Refinement::Scale([0.4, 2.5]))),
        }
    }

    fn with_second(
        &self,
        effect: &dyn AnyEffect,
        value: f64,
        range: Option<[f64; 2]>,
    ) -> Option<Box<dyn AnyEffect>> {
        let jump = effect.concrete::<Shift>()?.clone();
        Some(match jump.until {
            Some(_) => Box::new(Shift { until: Some(value), until_range: range, ..jump }),
            None => Box::new(Shift { settling: Some(value), settling_range: range, ..jump }),
        })
    }

    // It was put right later, or it happened before and was put right here; or a part of it settles.
    fn richer_in(&self, effect: &dyn AnyEffect, setting: &Setting<'_>) -> Vec<Box<dyn AnyEffect>> {
        let Some(jump) = effect.concrete::<Shift>() else { return Vec::new() };
        let Some([_, last]) = setting.record_range() else { return Vec::new() };
        if jump.until.is_some() || jump.settling.is_some() {
            return Vec::new();
        }
        let instants = instants(setting.data);
        let coarse = instants.iter().step_by(instants.len().div_ceil(ENDS).max(1)).copied();
        let mut all: Vec<Box<dyn AnyEffect>> = coarse
            .filter(|&other| (other - jump.at).abs() > 0.0)
            .map(|other| {
                let (at, until) = (jump.at.min(other), Some(jump.at.max(other)));
                Shift { at, until, gap: None, ..jump.clone() }.boxed()
            })
            .collect();
        let settling =
            |share: f64| Shift { settling: Some(share * (last - jump.at)), ..jump.clone() }.boxed();
        all.extend([0.05, 0.2].into_iter().filter(|_| last > jump.at).map(settling));
        all
    }

    fn between(&self, effect: &dyn AnyEffect, [before, after]: [f64; 2]) -> Option<Box<dyn AnyEffect>> {
        let jump = effect.concrete::<Shift>()?.clone();
        Some(Box::new(Shift { at: 0.5 * (before + after), gap: Some([before, after]), ..jump }))
    }

    fn neighbours(&self, effect: &dyn AnyEffect) -> Vec<Box<dyn AnyEffect>> {
        let Some(jump) = effect.concrete::<Shift>() else { return Vec::new() };
        of_spot(jump.spot, jump.components.as_deref(), |axes| {
            Shift { components: Some(axes), ..jump.clone() }.boxed()
        })
    }
}

/// What moves as a base does, and cannot be told from it without a fixed point beside the robot.
fn stand(place: &Place) -> &'static str {
    if place.joint.as_deref() == Some("base") {
        " (its stand moves as the base would: fixed points beside the robot tell which)"
    } else {
        ""
    }
}

/// Moments between visits at which something can have jumped, s.
pub(crate) fn instants(data: &Dataset) -> Vec<f64> {
    let mut times: Vec<f64> = Visits::of(data).rows.iter().map(|rows| data.time[rows[0]]).collect();
    times.sort_by(f64::total_cmp);
    let last = times.len().saturating_sub(EDGE);
    (EDGE..last.max(EDGE))
        .filter(|&k| times[k] > times[k - 1])
        .map(|k| 0.5 * (times[k] + times[k - 1]))
        .collect()
}
