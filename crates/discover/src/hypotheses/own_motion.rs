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
        turning(setting).filter(|(joint, _)| setting.levels(*joint).determine(1)).map(one).collect()
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
            let levels = setting.levels(joint);
            let determined = [1, 2, 4, 8].into_iter().filter(|pieces| levels.determine_curve(*pieces));
            all.extend(determined.map(curve));
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
        let values = |count: u32| -> Vec<f64> { (0..20).map(|k| 0.1 * f64::from(k % count)).collect() };
        let mut joints = vec![values(20); chain.movable().len()];
        joints[0] = values(1);
        let data = Dataset { joints, ..Dataset::default() };
        let setting = Setting::new(&chain, &data);
        let moved = chain.movable().iter().skip(1).filter(|&&joint| !slides(joint)).count();
        assert_eq!((OwnGain.variants(&setting).len(), OwnCurve.variants(&setting).len()), (moved, 4 * moved));
        for variant in OwnCurve.variants(&setting) {
            assert!(variant.change.effects().iter().all(|effect| effect.validate(&chain).is_ok()));
        }
        // A joint of a grid: of four values nothing is told but that they differ, of eight a curve of one piece.
        for (count, gains, curves) in [(4, 0, 0), (8, moved, moved)] {
            let data = Dataset { joints: vec![values(count); chain.movable().len()], ..Dataset::default() };
            let setting = Setting::new(&chain, &data);
            let of = |hypothesis: &dyn Hypothesis| hypothesis.variants(&setting).len();
            let all = chain.movable().iter().filter(|&&joint| !slides(joint)).count();
            let wanted = |count: usize| if count > 0 { all } else { 0 };
            assert_eq!((of(&OwnGain), of(&OwnCurve)), (wanted(gains), wanted(curves)));
        }
    }
}
