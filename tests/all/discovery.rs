//! The closed loop on simulated robots: it finds what was hidden, at its place, and nothing where nothing is.

use crate::plants::with_three_targets;
use truepose_discover::{Diagnosis, DiscoverOptions, Family, Stop, diagnose};
use truepose_errormodel::effects::{Geometric, JointCompliance};
use truepose_errormodel::{AnyEffect, Dataset};
use truepose_kinematics::{Chain, JointId, samples};
use truepose_simulate::description::RepeatabilitySize;
use truepose_simulate::{Campaign, Flaws, Plant, PlantOptions, flaws};
use truepose_solvers::PivotedQr;

fn constants() -> Flaws {
    let geometric =
        flaws::Geometric { position_mm: 0.4, angle_mrad: 0.3, target_mm: 0.0, ..flaws::Geometric::default() };
    Flaws { geometric: Some(geometric), ..Flaws::default() }
}

fn measured(chain: &Chain, errors: Flaws, visits: usize, payloads: &[f64], seed: u64) -> Dataset {
    let options = PlantOptions {
        errors,
        repeatability: RepeatabilitySize { sd_um: 20.0, ..RepeatabilitySize::default() },
        ..PlantOptions::default()
    };
    let plant = Plant::random(chain, &options, seed).unwrap();
    let mut campaign = Campaign::random(chain, visits, seed).unwrap();
    if !payloads.is_empty() {
        campaign = campaign.with_each_payload(payloads, [0.03, -0.02, 0.1]);
    }
    plant.measure(&campaign.shuffled(seed), seed).unwrap()
}

fn found(chain: &Chain, declared: &[Box<dyn AnyEffect>], data: &Dataset, seed: u64) -> Diagnosis {
    let options = DiscoverOptions { seed, ..DiscoverOptions::default() };
    diagnose(chain, declared, data, &PivotedQr::default(), &options, &|_| ()).unwrap()
}

fn words(found: &Diagnosis) -> Vec<String> {
    found.findings.iter().map(|f| f.candidate.words()).collect()
}

#[test]
fn nothing_is_found_in_noise() {
    let chain = with_three_targets(&samples::ur10());
    let data = measured(&chain, constants(), 60, &[], 3);
    let found = found(&chain, &[Box::new(Geometric::default())], &data, 0);
    assert!(found.findings.is_empty(), "{:?}", words(&found));
    assert_eq!(found.stopped, Stop::NothingLeft);
    assert!(!found.unexplained.significant);
    assert_eq!(found.holdout_rows.len(), 36);
}

#[test]
fn play_is_found_named_and_sized_and_the_ledger_is_the_same_again() {
    let chain = with_three_targets(&samples::ur10());
    let play = flaws::Backlash { joint: "j3".into(), width_mrad: Some(0.3), ..flaws::Backlash::default() };
    let data = measured(&chain, Flaws { backlash: vec![play], ..constants() }, 60, &[], 5);
    let found_once = found(&chain, &[Box::new(Geometric::default())], &data, 1);
    assert_eq!(words(&found_once), ["backlash j3"]);
    let finding = &found_once.findings[0];
    let gap = &finding.parameters[0];
    assert!((gap.value - 3e-4).abs() < 3e-5, "{gap:?}");
    assert!(gap.ci95[0] < 3e-4 && 3e-4 < gap.ci95[1], "{gap:?}");
    assert!(finding.holdout.1 < 0.6 * finding.holdout.0, "{:?}", finding.holdout);
    assert!(finding.evidence.p_value < 0.002);

    let pool = rayon::ThreadPoolBuilder::new().num_threads(3).build().unwrap();
    let again = pool.install(|| found(&chain, &[Box::new(Geometric::default())], &data, 1));
    assert_eq!(again.fit.fitted.coefficients(), found_once.fit.fitted.coefficients());
}

#[test]
fn a_wrong_payload_is_weighed() {
    let chain = with_three_targets(&samples::heavy());
    let springs = [("a2", 2.0e6), ("a3", 1.5e6), ("a5", 5.0e5)]
        .map(|(joint, stiffness)| flaws::JointCompliance {
            joint: joint.into(),
            stiffness: Some(stiffness),
            ..flaws::JointCompliance::default()
        })
        .to_vec();
    let errors = Flaws { joint_compliance: springs, ..constants() };
    for seed in [7, 8] {
        let mut data = measured(&chain, errors.clone(), 30, &[0.0, 60.0, 120.0], seed);
        // The label on the weight was wrong: 120 kg carried, 100 kg declared.
        for load in &mut data.load {
            if let truepose_kinematics::Load::Payload(payload) = load
                && (payload.mass - 120.0).abs() < 1e-9
            {
                payload.mass = 100.0;
            }
        }
        let joints = [2, 3, 5].map(JointId).to_vec();
        let declared: Vec<Box<dyn AnyEffect>> = vec![
            Box::new(Geometric::default()),
            Box::new(JointCompliance { joints: Some(joints), ..JointCompliance::default() }),
        ];
        let found = found(&chain, &declared, &data, 0);
        assert_eq!(found.findings[0].candidate.family, Family::Payload, "{:?}", words(&found));
        assert_eq!(found.findings.len(), 1, "{:?}", words(&found));
        let carried = found.fit.fitted.loads[0];
        assert!((carried.declared - 100.0).abs() < 1e-6, "{carried:?}");
        assert!((carried.carried - 120.0).abs() < 2.0, "{carried:?}");
        assert_eq!(found.findings[0].rows.len(), 90);
    }
}
