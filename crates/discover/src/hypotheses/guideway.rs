//! Slides whose rail is not straight.

use crate::hypotheses::candidate::Candidate;
use crate::hypotheses::family::Family;
use crate::hypotheses::place::Place;
use crate::hypotheses::setting::Setting;
use truepose_errormodel::effects::Guideway;
use truepose_kinematics::Axis;

pub(crate) fn add(setting: &Setting<'_>, all: &mut Vec<Candidate>) {
    let chain = setting.chain;
    for &joint in chain.movable().iter().filter(|&&joint| setting.slides(joint)) {
        let Some(range) = setting.range(joint) else { continue };
        let place = Place::joint(chain, joint);
        let whole = Guideway { range: Some(range), ..Guideway::of(joint) };
        for pieces in [1, 2, 4, 6, 8, 11, 15] {
            let smooth = Guideway { pieces, ..whole.clone() };
            all.push(Candidate::new(Family::Guideway, place.clone(), smooth.clone()));
            let turns = Guideway {
                components: Some(vec![Axis::Ty, Axis::Tz, Axis::Rx, Axis::Ry, Axis::Rz]),
                ..smooth.clone()
            };
            all.push(Candidate::new(Family::Guideway, place.clone(), turns));
            if pieces <= 8 {
                for axis in Axis::ALL {
                    let one = Guideway { components: Some(vec![axis]), ..smooth.clone() };
                    all.push(Candidate::new(Family::Guideway, place.clone(), one));
                }
            }
        }
    }
}
