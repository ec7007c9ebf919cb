//! Effects of real robots, hidden in plants whose law is not the effect's own: found, named, sized.

use crate::plants::with_three_targets;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use truepose_discover::{Diagnosis, DiscoverOptions, concrete, diagnose};
use truepose_errormodel::effects::{Backlash, Geometric, Side};
use truepose_errormodel::{AnyEffect, Dataset};
use truepose_kinematics::{Chain, samples};
use truepose_simulate::description::{InstrumentSize, RepeatabilitySize};
use truepose_simulate::physics::presliding::Presliding;
use truepose_simulate::{Campaign, Flaws, Plant, PlantOptions, Truth, flaws};
use truepose_solvers::PivotedQr;

fn plant(chain: &Chain, seed: u64, hide: impl Fn(&mut Truth)) -> Plant {
    let geometric =
        flaws::Geometric { position_mm: 0.4, angle_mrad: 0.3, target_mm: 0.0, ..flaws::Geometric::default() };
    let options = PlantOptions {
        errors: Flaws { geometric: Some(geometric), ..Flaws::default() },
        instrument: InstrumentSize { sd_um: 10.0, ..InstrumentSize::default() },
        repeatability: RepeatabilitySize { sd_um: 20.0, ..RepeatabilitySize::default() },
        ..PlantOptions::default()
    };
    let plant = Plant::random(chain, &options, seed).unwrap();
    let mut truth = plant.truth().clone();
    hide(&mut truth);
    plant.with_truth(truth).unwrap()
}

/// Poses of which every joint comes by moves from 0.01 to 1.5 rad, in equal parts of the logarithm, within ±1.8 rad.
fn wandering(chain: &Chain, poses: usize, seed: u64) -> Campaign {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut q = vec![0.3; chain.movable().len()];
    let way = (0..poses).map(|_| {
        for q in &mut q {
            let step = 0.01 * 150f64.powf(rng.random::<f64>());
            let side = if rng.random::<bool>() { 1.0 } else { -1.0 };
            let to = *q + side * step;
            *q = if to.abs() > 1.8 { *q - side * step } else { to };
        }
        q.clone()
    });
    Campaign::of(way.collect())
}

fn found(chain: &Chain, declared: &[Box<dyn AnyEffect>], data: &Dataset) -> Diagnosis {
    diagnose(chain, declared, data, &PivotedQr::default(), &DiscoverOptions::default(), &|_| ()).unwrap()
}

fn words(found: &Diagnosis) -> Vec<String> {
    found.findings.iter().map(|f| f.candidate.words()).collect()
}

/// 3-D RMS error on the test set, over that of the noise: of the instrument and of the robot's repeatability.
fn over_noise(found: &Diagnosis) -> f64 {
    found.after.holdout.positions().rms / (3f64.sqrt() * 10e-6f64.hypot(20e-6))
}

#[test]
fn friction_with_memory_is_found_with_its_distance() {
    let chain = with_three_targets(&samples::ur10());
    let slip = Presliding::MaxwellSlip {
        amplitude: 3e-4,
        widths: vec![0.03, 0.1, 0.25],
        parts: vec![2.0, 2.0, 1.0],
    };
    for (friction, name) in [(Presliding::Dahl { amplitude: 3e-4, width: 0.12 }, "Dahl"), (slip, "slip")] {
        let plant = plant(&chain, 5, |truth| truth.joints[2].presliding = Some(friction.clone()));
        let data = plant.measure(&wandering(&chain, 120, 7), 5).unwrap();
        let declared: Vec<Box<dyn AnyEffect>> = vec![Box::new(Geometric::default())];
        let diagnosis = found(&chain, &declared, &data);
        assert_eq!(words(&diagnosis), ["backlash j3"], "{name}");
        let finding = &diagnosis.findings[0];
        let play = concrete::<Backlash>(&*finding.candidate.effects()[0]).expect("backlash");
        assert_eq!(play.side, Side::Presliding, "{name}");
        // The amplitude is half the gap.
        let gap = &finding.parameters[0];
        assert!((gap.value - 6e-4).abs() < 6e-5, "{name}: {gap:?}");
        let width = play.width.unwrap();
        if name == "Dahl" {
            assert!((width / 0.12).ln().abs() < 0.25, "{width}");
        } else {
            assert!((0.03..0.25).contains(&width), "{width}");
        }
        // What a law with one distance leaves of one with three.
        let limit = if name == "Dahl" { 1.15 } else { 1.3 };
        assert!(over_noise(&diagnosis) < limit, "{name}: {}", over_noise(&diagnosis));
    }
}
