//! Errors of a turning joint that follow its own value without a period: a gain, a smooth curve.
//!
//! A slide has both in its guideway (positioning along the travel).

use crate::hypotheses::driver::Driver;
use crate::hypotheses::family::Family;
use crate::hypotheses::hypothesis::Hypothesis;
use crate::hypotheses::limits::Limit;
use crate::hypotheses::penalty::Penalty;
use crate::hypotheses::place::Place;
use crate::hypotheses::setting::Setting;
use crate::hypotheses::variant::Variant;
use crate::hypotheses::view::TraceView;
use truepose_errormodel::AnyEffect;
use truepose_errormodel::effects::Transmission;
use truepose_kinematics::JointId;

/// A joint turns by a constant fraction more than it reports.
#[derive(Debug)]
pub(crate) struct OwnGain;

/// A joint errs smoothly over its travel.
#[derive(Debug)]
pub(crate) struct OwnCurve;

/// Turning joints that moved, with their visited travel, rad.
fn turning<'s>(setting: &'s Setting<'_>) -> impl Iterator<Item = (JointId, [f64; 2])> + use<'s> {
    let moved = setting.chain.movable().iter().filter(|&&joint| !setting.slides(joint));
    moved.filter_map(|&joint| Some((joint, setting.range(joint)?)))
}

fn own(place: &Place) -> Vec<Driver> {
    place.joint.clone().map(Driver::Joint).into_iter().collect()
}

impl Hypothesis for OwnGain {
    fn family(&self) -> Family {
        Family::Transmission
    }

    fn variants(&self, setting: &Setting<'_>) -> Vec<Variant> {
        let one = |(joint, _)| Variant::new(Place::joint(setting.chain, joint), Transmission::gain(joint));
        turning(setting).map(one).collect()
    }

    fn meaning(&self, place: &Place) -> String {
        format!(
            "{} turns by a constant fraction more or less than it reports. Check its encoder's line count, its gear ratio and \
             belt.",
            place.part()
        )
    }

    fn drivers(&self, place: &Place, _: &[Box<dyn AnyEffect>]) -> Vec<Driver> {
        own(place)
    }

    fn view(&self, place: &Place, _: &[Box<dyn AnyEffect>]) -> TraceView {
        TraceView::of_motion(own(place))
    }

    fn limits(&self) -> &[Limit] {
        &[Limit::DriveAngle]
    }
}

impl Hypothesis for OwnCurve {
    fn family(&self) -> Family {
        Family::Transmission
    }

    fn variants(&self, setting: &Setting<'_>) -> Vec<Variant> {
        let mut all = Vec::new();
        for (joint, range) in turning(setting) {
            let place = Place::joint(setting.chain, joint);
            let curve = |pieces| Variant::new(place.clone(), Transmission::curve(joint, range, pieces));
            all.extend([1, 2, 4, 8].map(curve));
        }
        all
    }

    fn meaning(&self, place: &Place) -> String {
        format!(
            "The error of {} follows its own position without a period. Check the calibration of its encoder, and its cable, cam or \
             linkage.",
            place.part()
        )
    }

    fn drivers(&self, place: &Place, _: &[Box<dyn AnyEffect>]) -> Vec<Driver> {
        own(place)
    }

    fn view(&self, place: &Place, _: &[Box<dyn AnyEffect>]) -> TraceView {
        TraceView::of_motion(own(place))
    }

    // Any mechanism with a formula is simpler than a curve.
    fn rank(&self) -> Family {
        Family::Drift
    }

    fn penalty(&self, _: &[Box<dyn AnyEffect>]) -> Penalty {
        Penalty::MarginalLikelihood
    }

    fn limits(&self) -> &[Limit] {
        &[Limit::DriveAngle]
    }

    fn is_curve(&self) -> bool {
        true
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use truepose_errormodel::Dataset;
    use truepose_kinematics::samples;

    #[test]
    fn turning_joints_that_moved_have_candidates() {
        let chain = samples::scara();
        let slides = |joint: JointId| chain.joint(joint).kind == truepose_kinematics::JointKind::Prismatic;
        let mut joints: Vec<Vec<f64>> = vec![vec![0.0, 0.2, 0.5]; chain.movable().len()];
        joints[0] = vec![0.3; 3];
        let data = Dataset { joints, ..Dataset::default() };
        let setting = Setting::new(&chain, &data);
        let moved = chain.movable().iter().skip(1).filter(|&&joint| !slides(joint)).count();
        assert_eq!((OwnGain.variants(&setting).len(), OwnCurve.variants(&setting).len()), (moved, 4 * moved));
        for variant in OwnCurve.variants(&setting) {
            assert!(variant.change.effects().iter().all(|effect| effect.validate(&chain).is_ok()));
        }
    }
}
