//! Structure without a name: a smooth dependence of some component of some frame on whatever the data has.

use super::Setting;
use crate::{Candidate, Family, Place};
use truepose_errormodel::effects::{Basis, Expansion, Factor, Input, Place as At};
use truepose_kinematics::{Axis, FrameId};

/// Something that an error may depend on.
struct Covariate {
    name: String,
    input: Input,
    range: [f64; 2],
    joint: bool,
    /// It has two values: no curve, only a difference.
    side: bool,
}

fn covariates(setting: &Setting<'_>) -> Vec<Covariate> {
    let chain = setting.chain;
    let mut list = Vec::new();
    for &joint in chain.movable() {
        if let Some(range) = setting.range(joint) {
            let name = chain.joint(joint).name.clone();
            list.push(Covariate { name, input: Input::Joint(joint), range, joint: true, side: false });
        }
    }
    for (k, channel) in setting.data.schema.channels.iter().enumerate() {
        if let (Some(range), false) = (setting.channel_range(k), channel.name.contains('~')) {
            let input = Input::Channel(channel.name.clone());
            list.push(Covariate { name: channel.name.clone(), input, range, joint: false, side: false });
        }
    }
    if setting.data.schema.approach {
        for &joint in chain.movable() {
            let name = format!("approach_{}", chain.joint(joint).name);
            let input = Input::Approach(joint);
            list.push(Covariate { name, input, range: [-1.0, 1.0], joint: false, side: true });
        }
    }
    list
}

impl Covariate {
    fn spline(&self, pieces: usize) -> Factor {
        let [lower, upper] = self.range;
        Factor { of: self.input.clone(), basis: Basis::Spline { lower, upper, pieces, degree: 3 } }
    }

    fn polynomial(&self, degrees: Vec<u32>) -> Factor {
        let [lower, upper] = self.range;
        Factor { of: self.input.clone(), basis: Basis::Chebyshev { lower, upper, degrees } }
    }
}

/// Pieces of the curves along which the axis of a turn may wander in all directions as it turns.
const WANDER: [usize; 2] = [5, 10];

pub(super) fn add(setting: &Setting<'_>, all: &mut Vec<Candidate>) {
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
    for covariate in &covariates {
        for &frame in &frames {
            for axis in Axis::ALL {
                put(frame, vec![axis], vec![covariate.polynomial(vec![1])], &[covariate]);
                for pieces in [2, 5, 10, 18] {
                    if !covariate.side && (covariate.joint || pieces < 8) {
                        put(frame, vec![axis], vec![covariate.spline(pieces)], &[covariate]);
                    }
                }
            }
            if !covariate.side {
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
    let mut series = crate::shape::seen_as::<Expansion>(&**effect)?.clone();
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
