//! Effects of real robots, hidden in plants whose law is not the effect's own: found, named, sized.

use crate::plants::with_three_targets;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use truepose_discover::{Diagnosis, DiscoverOptions, diagnose};
use truepose_errormodel::effects::{
    Backlash, Geometric, Instrument, JointCompliance, Side, Transmission, TransmissionMode,
};
use truepose_errormodel::{AnyEffect, Channel, Dataset};
use truepose_identify::{IdentificationOptions, identify};
use truepose_kinematics::nalgebra::Vector3;
use truepose_kinematics::{Chain, Load, Payload, samples};
use truepose_simulate::description::{InstrumentSize, RepeatabilitySize};
use truepose_simulate::physics::backlash::{DeadBand, Side as Flank};
use truepose_simulate::physics::curve::{Centred, SmoothCurve};
use truepose_simulate::physics::presliding::Presliding;
use truepose_simulate::physics::transmission::TransmissionError;
use truepose_simulate::physics::wave::{LoadedWaves, Wave};
use truepose_simulate::{Campaign, Flaws, LogLag, Plant, PlantOptions, Truth, flaws};
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
    let options = DiscoverOptions { rotations: 199, ..DiscoverOptions::default() };
    diagnose(chain, declared, data, &PivotedQr::default(), &options, &|_| ()).unwrap()
}

fn words(found: &Diagnosis) -> Vec<String> {
    found.findings.iter().map(|f| f.candidate.words()).collect()
}

/// 3-D RMS error on the test set, over that of the noise: of the instrument and of the robot's repeatability.
fn over_noise(found: &Diagnosis) -> f64 {
    found.after.holdout.positions().rms / (3f64.sqrt() * 10e-6f64.hypot(20e-6))
}

#[cfg(feature = "slow")]
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
        let play = finding.candidate.effects()[0].concrete::<Backlash>().expect("backlash");
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

#[cfg(feature = "slow")]
#[test]
fn a_smooth_encoder_and_a_wrong_gain_are_transmission_errors_of_their_joint() {
    let chain = with_three_targets(&samples::ur10());
    let declared: Vec<Box<dyn AnyEffect>> = vec![Box::new(Geometric::default())];
    let curve = plant(&chain, 11, |truth| {
        let mut rng = ChaCha8Rng::seed_from_u64(4);
        let drawn = SmoothCurve::draw((-1.8, 1.8), 1.0, 3e-4, Centred::MeanAndSlope, &mut rng).unwrap();
        truth.joints[3].transmission.push(TransmissionError::Smooth(drawn));
    });
    // A line, of points in a file: as if by another gear ratio.
    let gain = plant(&chain, 11, |truth| {
        let line = SmoothCurve::through(-2.0, 1.0, vec![-8e-4, -4e-4, 0.0, 4e-4, 8e-4]).unwrap();
        truth.joints[3].transmission.push(TransmissionError::Smooth(line));
    });
    for (plant, mode) in [(curve, TransmissionMode::Curve), (gain, TransmissionMode::Gain)] {
        let data = plant.measure(&wandering(&chain, 120, 3), 5).unwrap();
        let diagnosis = found(&chain, &declared, &data);
        assert_eq!(words(&diagnosis), ["transmission j4"], "{mode:?}");
        let finding = &diagnosis.findings[0];
        let own = finding.candidate.effects()[0].concrete::<Transmission>().expect("a transmission error");
        // Over half a turn and more a smooth curve is as well a few harmonics of the turn.
        assert!(
            own.mode == mode || (mode, own.mode) == (TransmissionMode::Curve, TransmissionMode::Periodic)
        );
        if mode == TransmissionMode::Gain {
            let [lower, upper] = finding.parameters[0].ci95;
            assert!(lower < 4e-4 && 4e-4 < upper, "{:?}", finding.parameters);
        }
        assert!(over_noise(&diagnosis) < 1.2, "{mode:?}: {}", over_noise(&diagnosis));
    }
}

#[cfg(feature = "slow")]
#[test]
fn a_joint_yields_with_its_measured_torque() {
    // The statics does not know what loads this joint: a cable that pulls, and is in the motor's current.
    let chain = with_three_targets(&samples::ur10());
    let plant = plant(&chain, 13, |_| {});
    let campaign = wandering(&chain, 120, 3);
    let mut data = plant.measure(&campaign, 5).unwrap();
    let mut rng = ChaCha8Rng::seed_from_u64(9);
    let pull: Vec<f64> = (0..campaign.visits.len()).map(|_| 40.0 * (rng.random::<f64>() - 0.5)).collect();
    // Joints as they are, and what is reported: 12 µrad/A less.
    let torque: Vec<f64> = data.visit.iter().map(|&visit| pull[visit]).collect();
    for (q, tau) in data.joints[2].iter_mut().zip(&torque) {
        *q -= 12e-6 * tau;
    }
    data.schema.channels.push(Channel { name: "current_j3".into(), unit: "A".into(), temperature: false });
    data.channels.push(torque);
    let declared: Vec<Box<dyn AnyEffect>> = vec![Box::new(Geometric::default())];
    let diagnosis = found(&chain, &declared, &data);
    assert_eq!(words(&diagnosis), ["joint_compliance j3 on current_j3"]);
    let compliance = &diagnosis.findings[0].parameters[0];
    assert!(compliance.ci95[0] < 12e-6 && 12e-6 < compliance.ci95[1], "{compliance:?}");
    assert!(over_noise(&diagnosis) < 1.15, "{}", over_noise(&diagnosis));
}

/// The same way with three loads in turn, kg.
fn loaded(mut campaign: Campaign, heaviest: f64) -> Campaign {
    for (k, visit) in campaign.visits.iter_mut().enumerate() {
        let mass = heaviest * [0.0, 0.5, 1.0][k * 7 % 3];
        visit.load = Load::Payload(Payload { mass, com: Vector3::new(0.02, -0.03, 0.15) });
    }
    campaign
}

/// Constant errors, and compliances of all joints, which are not what is hidden.
fn elastic() -> Vec<Box<dyn AnyEffect>> {
    vec![Box::new(Geometric::default()), Box::new(JointCompliance::default())]
}

#[cfg(feature = "slow")]
#[test]
fn a_log_that_lags_is_an_error_of_the_instrument() {
    let chain = with_three_targets(&samples::ur10());
    // A filter of 0.3 s, read 1.7 s after moves of 1.5 to 2 s: about a thousandth of each move is missing.
    let lag = LogLag { time_constant: 0.3, wait: 1.7, least: 1.5, speed: 3.0 };
    let mut plant = plant(&chain, 5, |_| {});
    plant.disturbances.log = Some(lag);
    let data = plant.measure(&wandering(&chain, 120, 7), 5).unwrap();
    let declared: Vec<Box<dyn AnyEffect>> = vec![Box::new(Geometric::default())];
    let diagnosis = found(&chain, &declared, &data);
    assert_eq!(words(&diagnosis), ["instrument lag"]);
    assert!(over_noise(&diagnosis) < 1.2, "{}", over_noise(&diagnosis));
    // Declared by hand it is fitted as well, and commands are those of the robot without it.
    let hand: Vec<Box<dyn AnyEffect>> =
        vec![Box::new(Geometric::default()), Box::new(Instrument::lag(chain.movable()))];
    let options = IdentificationOptions::default();
    let fitted = identify(&chain, &hand, &data, &PivotedQr::default(), &options, &|_| ()).unwrap().fit.fitted;
    let lags = fitted.model().columns_of(1);
    for value in &fitted.coefficients()[lags.clone()] {
        assert!((2e-4..2e-3).contains(value), "{value}");
    }
    assert!(fitted.of_robot().coefficients()[lags].iter().all(|value| value.abs() <= 0.0));
}

#[cfg(feature = "slow")]
#[test]
fn a_scale_of_the_instrument_is_seen_where_slides_share_it_and_is_in_the_lengths_of_an_arm() {
    // All lengths of an arm are constant errors that may be longer alike; a slide's scale is none.
    for (chain, expected) in [(samples::pps(), &["instrument scale"][..]), (samples::ur10(), &[])] {
        let chain = with_three_targets(&chain);
        let plant = plant(&chain, 3, |_| {});
        let campaign = Campaign::random(&chain, 120, 4).unwrap();
        let mut data = plant.measure(&campaign, 5).unwrap();
        data.position.iter_mut().flatten().for_each(|value| *value *= 1.0 + 2e-4);
        let declared: Vec<Box<dyn AnyEffect>> = vec![Box::new(Geometric::default())];
        let diagnosis = found(&chain, &declared, &data);
        assert_eq!(words(&diagnosis), expected, "{}", chain.name());
        assert!(over_noise(&diagnosis) < 1.15, "{}: {}", chain.name(), over_noise(&diagnosis));
        if let Some(scale) = diagnosis.findings.first() {
            let [lower, upper] = scale.parameters[0].ci95;
            assert!(lower < 2e-4 && 2e-4 < upper, "{:?}", scale.parameters);
        }
    }
}

#[test]
fn friction_that_grows_with_the_load_is_backlash_by_load() {
    let chain = with_three_targets(&samples::heavy());
    let joint = chain.movable()[2];
    // Of 0.12 mrad, one fifth without a load.
    let side = Flank::Friction { part: 0.8, half_load: 3000.0 };
    let plant = plant(&chain, 5, |truth| {
        truth.joints[joint.index()].backlash = Some(DeadBand { width: 4e-4, side });
    });
    let data = plant.measure(&loaded(wandering(&chain, 150, 7), 150.0), 5).unwrap();
    let diagnosis = found(&chain, &elastic(), &data);
    assert_eq!(words(&diagnosis), ["backlash a3"]);
    let play = diagnosis.findings[0].candidate.effects()[0].concrete::<Backlash>().expect("backlash");
    assert_eq!(play.side, Side::ByLoad);
    assert!(over_noise(&diagnosis) < 1.2, "{}", over_noise(&diagnosis));
}

#[test]
fn a_wave_that_grows_with_the_load_is_a_transmission_error_by_load() {
    let chain = with_three_targets(&samples::heavy());
    let joint = chain.movable()[1];
    let waves = vec![Wave { amplitude: 1e-4, cycles: 101.0 / 11.0, phase: 0.7 }];
    let plant = plant(&chain, 5, |truth| {
        truth.joints[joint.index()].waves =
            Some(LoadedWaves { waves: waves.clone(), edge: 0.6, by_load: 3.0, load: 4000.0 });
    });
    let data = plant.measure(&loaded(wandering(&chain, 150, 7), 150.0), 5).unwrap();
    let diagnosis = found(&chain, &elastic(), &data);
    assert_eq!(words(&diagnosis), ["transmission a2"]);
    let wave = diagnosis.findings[0].candidate.effects()[0].concrete::<Transmission>().expect("a wave");
    assert!(wave.by_load);
    assert!(over_noise(&diagnosis) < 1.25, "{}", over_noise(&diagnosis));
}

#[cfg(feature = "slow")]
#[test]
fn a_switch_is_no_friction_with_memory() {
    // With this seed a distance of 5 mrad, shorter than any move but a few, fits a little better by chance.
    let chain = with_three_targets(&samples::ur10());
    let plant = plant(&chain, 5, |truth| {
        truth.joints[2].backlash = Some(DeadBand { width: 3e-4, side: Flank::Approach });
    });
    let data = plant.measure(&wandering(&chain, 100, 25), 5).unwrap();
    let declared: Vec<Box<dyn AnyEffect>> = vec![Box::new(Geometric::default())];
    let diagnosis = found(&chain, &declared, &data);
    assert_eq!(words(&diagnosis), ["backlash j3"]);
    let play = diagnosis.findings[0].candidate.effects()[0].concrete::<Backlash>().expect("backlash");
    assert_eq!(play.side, Side::Approach);
}
