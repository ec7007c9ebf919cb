//! Structure without a name: a smooth dependence of some component of some frame on whatever the data has.

use crate::hypotheses::candidate::Candidate;
use crate::hypotheses::covariate::TIME;
use crate::hypotheses::family::Family;
use crate::hypotheses::place::Place;
use crate::hypotheses::setting::{Setting, span};
use crate::hypotheses::time::instants;
use truepose_errormodel::effects::{Basis, Expansion, Factor, Input, Place as At};
use truepose_kinematics::{Axis, FrameId};

/// Something that an error may depend on.
struct Covariate {
    name: String,
    input: Input,
    range: [f64; 2],
    /// It is known so finely that a curve may have many pieces.
    fine: bool,
    /// It has two values: no curve, only a difference.
    side: bool,
}

fn covariates(setting: &Setting<'_>) -> Vec<Covariate> {
    let chain = setting.chain;
    let mut list = Vec::new();
    for &joint in chain.movable() {
        if let Some(range) = setting.range(joint) {
            let name = chain.joint(joint).name.clone();
            list.push(Covariate { name, input: Input::Joint(joint), range, fine: true, side: false });
        }
    }
    for (k, channel) in setting.data.schema.channels.iter().enumerate() {
        if let (Some(range), false) = (setting.channel_range(k), setting.data.late(&channel.name).is_some()) {
            let input = Input::Channel(channel.name.clone());
            list.push(Covariate { name: channel.name.clone(), input, range, fine: false, side: false });
        }
    }
    if setting.data.schema.approach {
        for &joint in chain.movable() {
            let name = format!("approach_{}", chain.joint(joint).name);
            let input = Input::Approach(joint);
            list.push(Covariate { name, input, range: [-1.0, 1.0], fine: false, side: true });
        }
    }
    list
}

/// The time: what follows it may do so smoothly or at once.
fn time(setting: &Setting<'_>) -> Option<Covariate> {
    let range = span(&setting.data.time).filter(|_| setting.data.schema.time)?;
    Some(Covariate { name: TIME.into(), input: Input::Time, range, fine: true, side: false })
}

impl Covariate {
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

pub(crate) fn add(setting: &Setting<'_>, all: &mut Vec<Candidate>) {
    let chain = setting.chain;
    let covariates = covariates(setting);
    let frames: Vec<FrameId> = chain.frames().collect();
    let own = |covariate: &Covariate, frame: FrameId| match covariate.input {
        Input::Joint(joint) => chain.frame_after(joint) == frame && !setting.slides(joint),
        _ => false,
    };
    let mut put = |frame: FrameId, components: Vec<Axis>, factors: Vec<Factor>, of: &[&Covariate]| {
        let mut place = Place::frame(chain, frame).depending_on(&of[0].name);
        place.covariate2 = of.get(1).map(|second| second.name.clone());
        if let [axis] = components[..] {
            place = place.along(axis);
        }
        let effect = Expansion { at: At::Frame { frame, components }, factors };
        all.push(Candidate::new(Family::Unmodelled, place, effect));
    };
    let time = time(setting);
    let instants = if time.is_some() { instants(setting.data) } else { Vec::new() };
    let stride = instants.len().div_ceil(INSTANTS).max(1);
    let instants: Vec<f64> = instants.into_iter().step_by(stride).collect();
    for covariate in covariates.iter().chain(&time) {
        for &frame in &frames {
            for axis in Axis::ALL {
                put(frame, vec![axis], vec![covariate.polynomial(vec![1])], &[covariate]);
                for pieces in [2, 5, 10, 18] {
                    if !covariate.side && (covariate.fine || pieces < 8) {
                        put(frame, vec![axis], vec![covariate.spline(pieces)], &[covariate]);
                    }
                }
            }
            if matches!(covariate.input, Input::Time) {
                for &at in &instants {
                    put(frame, Axis::ALL.to_vec(), vec![covariate.step(at)], &[covariate]);
                    for axis in Axis::ALL {
                        put(frame, vec![axis], vec![covariate.step(at)], &[covariate]);
                    }
                }
                let slowly = SLOWLY.map(|pieces| covariate.spline(pieces));
                let at_once = AT_ONCE.map(|pieces| covariate.steps(pieces));
                for curve in slowly.into_iter().chain(at_once) {
                    put(frame, Axis::ALL.to_vec(), vec![curve], &[covariate]);
                }
            } else if !covariate.side {
                put(frame, Axis::ALL.to_vec(), vec![covariate.spline(3)], &[covariate]);
            }
            for pieces in WANDER.into_iter().filter(|_| own(covariate, frame)) {
                put(frame, Axis::ALL.to_vec(), vec![covariate.spline(pieces)], &[covariate]);
            }
        }
    }
    for (k, first) in covariates.iter().enumerate() {
        for second in covariates[k + 1..].iter().filter(|second| !first.side && !second.side) {
            for &frame in &frames {
                for axis in Axis::ALL {
                    let product = vec![first.polynomial(vec![1]), second.polynomial(vec![1])];
                    put(frame, vec![axis], product, &[first, second]);
                    let surface = vec![first.polynomial(vec![1, 2]), second.polynomial(vec![1, 2])];
                    put(frame, vec![axis], surface, &[first, second]);
                }
            }
        }
    }
}

/// The same dependence on two inputs with everything up to the third degree; none of a candidate that depends on one.
pub(crate) fn richer(candidate: &Candidate) -> Option<Candidate> {
    let [effect] = candidate.effects() else { return None };
    let mut series = crate::hypotheses::nonlinear::seen_as::<Expansion>(&**effect)?.clone();
    if candidate.family != Family::Unmodelled || series.factors.len() != 2 {
        return None;
    }
    for factor in &mut series.factors {
        if let Basis::Chebyshev { degrees, .. } = &mut factor.basis {
            *degrees = vec![0, 1, 2, 3];
        }
    }
    Some(Candidate::new(candidate.family, candidate.place.clone(), series))
}
