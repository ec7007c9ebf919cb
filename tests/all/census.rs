//! Data of which a sample is searched: what only all rows show is found, and nothing else.

use crate::plants::with_one_target;
use truepose_discover::{Budget, Diagnosis, DiscoverOptions, Family, diagnose};
use truepose_errormodel::AnyEffect;
use truepose_errormodel::effects::Geometric;
use truepose_kinematics::{Chain, samples};
use truepose_simulate::description::{InstrumentSize, RepeatabilitySize};
use truepose_simulate::flaws::{Geometric as Constant, Transmission, Wheel};
use truepose_simulate::{Campaign, Flaws, Plant, PlantOptions};
use truepose_solvers::PivotedQr;

/// A robot that repeats to 20 µm an axis, with a mesh error of so many mrad: 0.01 of them move the target by a seventh of the noise.
fn found(chain: &Chain, amplitude_mrad: f64, budget: Budget) -> Diagnosis {
    let mesh = Transmission {
        joint: "j3".into(),
        wheel: Wheel::Mesh,
        amplitude_mrad,
        cycles: Some(23.0),
        ..Transmission::default()
    };
    let constant = Constant { position_mm: 0.3, angle_mrad: 0.3, target_mm: 0.1, ..Constant::default() };
    let transmission = if amplitude_mrad > 0.0 { vec![mesh] } else { Vec::new() };
    let options = PlantOptions {
        errors: Flaws { geometric: Some(constant), transmission, ..Flaws::default() },
        instrument: InstrumentSize { sd_um: 10.0, ..InstrumentSize::default() },
        repeatability: RepeatabilitySize { sd_um: 20.0, ..RepeatabilitySize::default() },
        ..PlantOptions::default()
    };
    let plant = Plant::random(chain, &options, 11).unwrap();
    let data = plant.observe(&Campaign::random(chain, 2400, 12).unwrap(), 12).unwrap().data;
    let declared: Vec<Box<dyn AnyEffect>> = vec![Box::new(Geometric::default())];
    let options = DiscoverOptions { budget, rotations: 199, ..DiscoverOptions::default() };
    diagnose(chain, &declared, &data, &PivotedQr::default(), &options, &|_| ()).unwrap()
}

/// A sample of 300 rows is searched; of the 1920 training rows 800 are fitted at once. So many findings may come from all of them.
fn budget(census: usize) -> Budget {
    let mut budget = Budget::default();
    (budget.sample_rows, budget.fitted_rows, budget.census) = (300, 800, census);
    budget
}

#[cfg(feature = "slow")]
#[test]
fn all_rows_show_what_a_sample_does_not() {
    let chain = with_one_target(&samples::ur10());
    let deaf = found(&chain, 0.01, budget(0));
    assert!(deaf.findings.is_empty());
    let all = found(&chain, 0.01, budget(8));
    let names: Vec<String> = all.findings.iter().map(|f| f.candidate.words()).collect();
    assert_eq!(names, ["transmission j3"]);
    assert_eq!(all.findings[0].candidate.family, Family::Transmission);
    let evidence = all.findings[0].evidence.as_ref().unwrap();
    assert!(
        evidence.p_value < 1e-4 && evidence.p_sign_flips < 0.01 && evidence.stability > 0.9,
        "{evidence:?}"
    );
    assert!(evidence.random.after < evidence.random.before && evidence.random.t > 2.0, "{evidence:?}");
    // The amplitude is that of the plant, and all rows are judged.
    let size = all.findings[0].parameters.iter().map(|p| p.value * p.value).sum::<f64>().sqrt();
    assert!((0.7e-5..1.3e-5).contains(&size), "{size}");
    assert_eq!((all.rows, all.visits), (2400, 2400));
    assert_eq!((all.after.train.position.len(), all.after.holdout.position.len()), (1920, 480));
    assert!(all.after.holdout.positions().rms < all.before.holdout.positions().rms);
    assert!(all.withdrawn.is_none());
}

#[test]
fn all_rows_of_a_robot_that_lacks_nothing_show_nothing() {
    let chain = with_one_target(&samples::ur10());
    let all = found(&chain, 0.0, budget(8));
    assert!(all.findings.is_empty(), "{:?}", all.findings[0].candidate.words());
}
