//! Unmodelled structure: a smooth dependence of some component of some frame on whatever the data has.

use crate::data::independent::independent;
use crate::hypotheses::components::of_series;
use crate::hypotheses::covariate::Covariate;
use crate::hypotheses::driver::Driver;
use crate::hypotheses::family::Family;
use crate::hypotheses::hypothesis::Hypothesis;
use crate::hypotheses::loaded;
use crate::hypotheses::penalty::Penalty;
use crate::hypotheses::place::Place;
use crate::hypotheses::setting::Setting;
use crate::hypotheses::time::instants;
use crate::hypotheses::variant::Variant;
use crate::hypotheses::view::TraceView;
use truepose_errormodel::AnyEffect;
use truepose_errormodel::effects::{Basis, Expansion, Factor, Input, Place as At};
use truepose_kinematics::{Axis, FrameId};

/// Something without a name depends on whatever the data has.
#[derive(Debug)]
pub(crate) struct Unmodelled;

impl Hypothesis for Unmodelled {
    fn family(&self) -> Family {
        Family::Unmodelled
    }

    fn variants(&self, setting: &Setting<'_>) -> Vec<Variant> {
        let mut all = of_frames(setting);
        all.extend(loaded::unmodelled(setting));
        all
    }

    fn meaning(&self, place: &Place) -> String {
        let joint = place.part();
        let own = match &place.covariate {
            Some(Covariate::Value(name)) => place.joint.as_ref() == Some(name) && place.component.is_none(),
            _ => false,
        };
        if own {
            return format!(
                "The axis of {joint} has an error motion as the joint turns. Inspect its bearings and their seats. No named family \
                 describes this error."
            );
        }
        let covariates: Vec<String> =
            [&place.covariate, &place.covariate2].into_iter().flatten().map(Covariate::to_string).collect();
        format!(
            "An error at {joint} depends on {}. No named family describes this error.",
            covariates.join(" and ")
        )
    }

    fn drivers(&self, place: &Place, effects: &[Box<dyn AnyEffect>]) -> Vec<Driver> {
        let factors =
            effects.iter().filter_map(|effect| effect.concrete::<Expansion>()).flat_map(|e| &e.factors);
        let covariates = [&place.covariate, &place.covariate2].into_iter().flatten();
        covariates
            .zip(factors)
            .map(|(covariate, factor)| match (covariate, &factor.of) {
                (Covariate::Time, _) => Driver::Time,
                (Covariate::Load(joint), _) => Driver::JointLoad(joint.clone()),
                (Covariate::Approach(joint), _) => Driver::Approach(joint.clone()),
                (Covariate::Value(name), Input::Channel(_)) => Driver::Channel(name.clone()),
                (Covariate::Value(name), _) => Driver::Joint(name.clone()),
            })
            .collect()
    }

    fn view(&self, place: &Place, effects: &[Box<dyn AnyEffect>]) -> TraceView {
        TraceView::of_site(self.drivers(place, effects).into_iter().take(1))
    }

    // Of frames that move along curves, and of whatever follows the time or a load.
    fn penalty(&self, effects: &[Box<dyn AnyEffect>]) -> Penalty {
        let [effect] = effects else { return Penalty::Number };
        let Some(series) = effect.concrete::<Expansion>() else { return Penalty::Number };
        let moves = matches!(&series.at, At::Frame { components, .. } if components.len() > 1);
        let follows = series.factors.first().is_some_and(|f| matches!(f.of, Input::Time | Input::Load(_)));
        if moves || follows { Penalty::MarginalLikelihood } else { Penalty::Number }
    }

    fn neighbours(&self, effect: &dyn AnyEffect) -> Vec<Box<dyn AnyEffect>> {
        of_series(effect)
    }

    // The same dependence on two inputs with everything up to the third degree.
    fn richer(&self, effect: &dyn AnyEffect) -> Option<Box<dyn AnyEffect>> {
        let mut series = effect.concrete::<Expansion>()?.clone();
        if series.factors.len() != 2 {
            return None;
        }
        for factor in &mut series.factors {
            if let Basis::Chebyshev { degrees, .. } = &mut factor.basis {
                *degrees = vec![0, 1, 2, 3];
            }
        }
        Some(Box::new(series))
    }
}

/// A quantity over which curves are made.
struct Quantity {
    covariate: Covariate,
    input: Input,
    range: [f64; 2],
    /// It is known so finely that a curve may have many pieces.
    fine: bool,
    /// It has two values: no curve, only a difference.
    side: bool,
}

fn quantities(setting: &Setting<'_>) -> Vec<Quantity> {
    let chain = setting.chain;
    let mut list = Vec::new();
    let mut put = |input: Input, range: [f64; 2], fine: bool, side: bool| {
        if let Some(covariate) = Covariate::of(chain, &input) {
            list.push(Quantity { covariate, input, range, fine, side });
        }
    };
    for &joint in chain.movable() {
        if let Some(range) = setting.range(joint)
            && setting.levels(joint).determine_curve(WANDER[0])
        {
            put(Input::Joint(joint), range, true, false);
        }
    }
    for (k, channel) in setting.data.schema.channels.iter().enumerate() {
        if let (Some(range), false) = (setting.channel_range(k), setting.data.late(&channel.name).is_some()) {
            put(Input::Channel(channel.name.clone()), range, false, false);
        }
    }
    if setting.data.schema.approach {
        for &joint in chain.movable() {
            put(Input::Approach(joint), [-1.0, 1.0], false, true);
        }
    }
    list
}

/// The time: what follows it may do so smoothly or at once.
fn time(setting: &Setting<'_>) -> Option<Quantity> {
    let range = setting.record_range()?;
    Some(Quantity { covariate: Covariate::Time, input: Input::Time, range, fine: true, side: false })
}

impl Quantity {
    /// Another value in each of so many equal pieces.
    fn steps(&self, pieces: usize) -> Factor {
        let [lower, upper] = self.range;
        Factor { of: self.input.clone(), basis: Basis::Spline { lower, upper, pieces, degree: 0 } }
    }

    /// One value before and another one from here on.
    fn step(&self, at: f64) -> Factor {
        let [lower, upper] = self.range;
        let (lower, upper) = (at - (upper - lower), at + (upper - lower));
        Factor { of: self.input.clone(), basis: Basis::Spline { lower, upper, pieces: 2, degree: 0 } }
    }

    fn spline(&self, pieces: usize) -> Factor {
        let [lower, upper] = self.range;
        Factor { of: self.input.clone(), basis: Basis::Spline { lower, upper, pieces, degree: 3 } }
    }

    fn polynomial(&self, degrees: Vec<u32>) -> Factor {
        let [lower, upper] = self.range;
        Factor { of: self.input.clone(), basis: Basis::Chebyshev { lower, upper, degrees } }
    }
}

/// Pieces over which all of a frame may wander with the time, and pieces from one to the next of which it may do anything.
const SLOWLY: [usize; 5] = [1, 2, 4, 8, 16];
const AT_ONCE: [usize; 3] = [6, 12, 24];
/// Instants at which something may change for good.
const INSTANTS: usize = 32;
/// Pieces of the curves along which the axis of a turn may wander in all directions as it turns.
const WANDER: [usize; 2] = [5, 10];

/// Curves, steps and surfaces at every frame.
fn of_frames(setting: &Setting<'_>) -> Vec<Variant> {
    let chain = setting.chain;
    let mut all = Vec::new();
    let quantities = quantities(setting);
    let frames: Vec<FrameId> = chain.frames().collect();
    let own = |quantity: &Quantity, frame: FrameId| match quantity.input {
        Input::Joint(joint) => chain.frame_after(joint) == frame && !setting.slides(joint),
        _ => false,
    };
    let mut put = |frame: FrameId, components: Vec<Axis>, factors: Vec<Factor>, of: &[&Quantity]| {
        let mut place = Place::frame(chain, frame).depending_on(of[0].covariate.clone());
        place.covariate2 = of.get(1).map(|second| second.covariate.clone());
        if let [axis] = components[..] {
            place = place.along(axis);
        }
        let effect = Expansion { at: At::Frame { frame, components }, factors };
        all.push(Variant::new(place, effect));
    };
    let time = time(setting);
    let instants = if time.is_some() { instants(setting.data) } else { Vec::new() };
    let stride = instants.len().div_ceil(INSTANTS).max(1);
    let instants: Vec<f64> = instants.into_iter().step_by(stride).collect();
    for quantity in quantities.iter().chain(&time) {
        for &frame in &frames {
            for axis in Axis::ALL {
                put(frame, vec![axis], vec![quantity.polynomial(vec![1])], &[quantity]);
                for pieces in [2, 5, 10, 18] {
                    if !quantity.side && (quantity.fine || pieces < 8) {
                        put(frame, vec![axis], vec![quantity.spline(pieces)], &[quantity]);
                    }
                }
            }
            if matches!(quantity.input, Input::Time) {
                for &at in &instants {
                    put(frame, Axis::ALL.to_vec(), vec![quantity.step(at)], &[quantity]);
                    for axis in Axis::ALL {
                        put(frame, vec![axis], vec![quantity.step(at)], &[quantity]);
                    }
                }
                let slowly = SLOWLY.map(|pieces| quantity.spline(pieces));
                let at_once = AT_ONCE.map(|pieces| quantity.steps(pieces));
                for curve in slowly.into_iter().chain(at_once) {
                    put(frame, Axis::ALL.to_vec(), vec![curve], &[quantity]);
                }
            } else if !quantity.side {
                put(frame, Axis::ALL.to_vec(), vec![quantity.spline(3)], &[quantity]);
            }
            for pieces in WANDER.into_iter().filter(|_| own(quantity, frame)) {
                put(frame, Axis::ALL.to_vec(), vec![quantity.spline(pieces)], &[quantity]);
            }
        }
    }
    for (first, second, frames) in pairs(setting, &quantities) {
        let (first, second) = (&quantities[first], &quantities[second]);
        for frame in frames {
            for axis in Axis::ALL {
                let product = vec![first.polynomial(vec![1]), second.polynomial(vec![1])];
                put(frame, vec![axis], product, &[first, second]);
                let surface = vec![first.polynomial(vec![1, 2]), second.polynomial(vec![1, 2])];
                put(frame, vec![axis], surface, &[first, second]);
            }
        }
    }
    all
}

/// Quantities up to which all pairs of them are tried at all frames. Convention: six joints, the load and five channels.
const FEW: usize = 12;
/// Of more: joints that are so near to each other on the arm, and so many channels.
const NEAR: usize = 3;
const CHANNELS: usize = 4;

/// Which two quantities may act together, and at which frames. Of few all pairs at all frames; of many joints those that are near each other, at
/// their own frames and both ends of the arm; with the channels that say the most different things, at the joint's frame and the ends: their
/// number grows with the joints and no faster.
fn pairs(setting: &Setting<'_>, quantities: &[Quantity]) -> Vec<(usize, usize, Vec<FrameId>)> {
    let chain = setting.chain;
    let curves: Vec<usize> = (0..quantities.len()).filter(|&k| !quantities[k].side).collect();
    let both = curves.iter().flat_map(|&a| curves.iter().filter(move |&&b| b > a).map(move |&b| (a, b)));
    if curves.len() <= FEW {
        let frames: Vec<FrameId> = chain.frames().collect();
        return both.map(|(a, b)| (a, b, frames.clone())).collect();
    }
    let channel = |k: usize| match &quantities[k].input {
        Input::Channel(name) => setting.data.schema.channels.iter().position(|channel| channel.name == *name),
        _ => None,
    };
    let all: Vec<usize> = curves.iter().filter_map(|&k| channel(k)).collect();
    let different = independent(setting.data, &all, CHANNELS);
    let place = |k: usize| match quantities[k].input {
        Input::Joint(joint) => chain.movable().iter().position(|&other| other == joint),
        _ => None,
    };
    let frame = |k: usize| match quantities[k].input {
        Input::Joint(joint) => Some(chain.frame_after(joint)),
        _ => None,
    };
    let kept = |(a, b): &(usize, usize)| {
        let near = place(*a).zip(place(*b)).is_none_or(|(a, b)| a.abs_diff(b) <= NEAR);
        near && [*a, *b].into_iter().filter_map(channel).all(|channel| different.contains(&channel))
    };
    both.filter(kept)
        .map(|(a, b)| {
            let own = [a, b].into_iter().filter_map(frame);
            let mut frames: Vec<FrameId> = own.chain([FrameId::BASE, chain.tool_frame()]).collect();
            frames.sort_unstable();
            frames.dedup();
            (a, b, frames)
        })
        .collect()
}
