//! What moves with time: smoothly, or all at once.

use crate::hypotheses::candidate::Candidate;
use crate::hypotheses::family::Family;
use crate::hypotheses::place::Place;
use crate::hypotheses::setting::{Setting, span};
use truepose_errormodel::effects::{Drift, Shift, Spot};
use truepose_errormodel::{Dataset, Visits};
use truepose_kinematics::{Chain, FrameId};

/// A jump needs this many visits on either side.
const EDGE: usize = 4;
/// Instants tried at first.
const INSTANTS: usize = 64;

pub(crate) fn add(setting: &Setting<'_>, all: &mut Vec<Candidate>) {
    if !setting.data.schema.time {
        return;
    }
    let chain = setting.chain;
    let Some(range) = span(&setting.data.time) else { return };
    let mut spots = vec![Spot::Frame(FrameId::BASE), Spot::Frame(chain.tool_frame())];
    spots.extend(chain.movable().iter().map(|&joint| Spot::Joint(joint)));
    let all_instants = instants(setting.data);
    let stride = all_instants.len().div_ceil(INSTANTS).max(1);
    for spot in spots {
        let place = Place::spot(chain, spot);
        for pieces in [1, 2, 4, 8] {
            let effect = Drift::smooth(spot, range, pieces);
            all.push(Candidate::new(Family::Drift, place.clone(), effect));
        }
        for share in [0.05, 0.1, 0.2, 0.4, 0.8] {
            let effect = Drift::settling(spot, range, share * (range[1] - range[0]));
            all.push(Candidate::new(Family::Drift, place.clone(), effect));
        }
        for &at in all_instants.iter().step_by(stride) {
            all.push(shift_at(chain, spot, at));
        }
    }
}

/// A jump of one place at one instant.
fn shift_at(chain: &Chain, spot: Spot, at: f64) -> Candidate {
    let effect = Shift::of(spot, at);
    Candidate::new(Family::Shift, Place::spot(chain, spot), effect)
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
