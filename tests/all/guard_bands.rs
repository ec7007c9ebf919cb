//! Bounds on which verdicts with guard bands rest, on simulated robots: they hold in 95 %. `cargo xtask study guard-band` has 2000.

use truepose_acceptance::{AssessmentOptions, assess};
use truepose_kinematics::{Conditions, samples};
use truepose_simulate::{Campaign, Plant, PlantDescription, PlantOptions};

const ROBOTS: usize = crate::of(120, 24);

#[test]
fn upper_and_lower_bounds_hold_in_95_percent() {
    let chain = samples::ur10();
    let text = "[errors.geometric]\nposition_mm = 0.4\nangle_mrad = 0.4\ntarget_mm = 0.1\n\
                [instrument]\nsd_um = 10\norientation_urad = 20\n[repeatability]\nsd_um = 20\n";
    let (mut above, mut below, mut all) = (0, 0, 0);
    for seed in 0..ROBOTS as u64 {
        let PlantDescription { errors, shop, instrument, repeatability, .. } =
            PlantDescription::from_toml(text).expect("a description");
        let options = PlantOptions { errors, shop, instrument, repeatability };
        let plant = Plant::random(&chain, &options, seed).expect("a plant");
        let mut campaign = Campaign::random(&chain, 5, seed).expect("a campaign").repeated(30);
        campaign.targets = vec![None];
        let data = plant.measure(&campaign, seed).expect("data");
        let found = assess(&chain, None, &data, &AssessmentOptions::default()).expect("repeats");
        for (pose, visit) in found.before.poses.iter().zip(&campaign.visits) {
            let at = Conditions::at(&chain, &visit.joints);
            let there = plant.true_position(&at, None).expect("a position");
            let truth = (there - chain.forward(&at.joints).translation).norm();
            above += usize::from(truth <= pose.pose.ap.bounds95[1]);
            below += usize::from(truth >= pose.pose.ap.bounds95[0]);
            all += 1;
        }
    }
    assert_eq!(all, 5 * ROBOTS);
    // 95 %, with three and a half standard deviations of a fraction of so many: bounds without the sample's own scatter hold in half of them.
    for held in [above, below] {
        let fraction = held as f64 / all as f64;
        assert!((fraction - 0.95).abs() < 3.5 * (0.95f64 * 0.05 / all as f64).sqrt(), "{fraction}");
    }
}
