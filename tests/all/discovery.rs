//! The closed loop on simulated robots: it finds what was hidden, at its place, and nothing where nothing is.

use crate::plants::with_three_targets;
use truepose_discover::{
    Covariate, Diagnosis, DiscoverOptions, Family, HeldOut, Library, Termination, diagnose,
};
use truepose_errormodel::effects::{Geometric, JointCompliance, Where};
use truepose_errormodel::{AnyEffect, CARRIED, Dataset};
use truepose_kinematics::nalgebra::{self, Rotation3, Vector3};
use truepose_kinematics::{Chain, FrameId, JointId, Load, PostureBuffer, samples};
use truepose_simulate::description::{InstrumentSize, RepeatabilitySize, ShopDay};
use truepose_simulate::{Campaign, ChannelPlan, Flaws, Plant, PlantOptions, flaws};
use truepose_solvers::PivotedQr;

fn constants() -> Flaws {
    let geometric =
        flaws::Geometric { position_mm: 0.4, angle_mrad: 0.3, target_mm: 0.0, ..flaws::Geometric::default() };
    Flaws { geometric: Some(geometric), ..Flaws::default() }
}

fn measured(chain: &Chain, errors: Flaws, visits: usize, payloads: &[f64], seed: u64) -> Dataset {
    let options = PlantOptions {
        errors,
        instrument: InstrumentSize { sd_um: 10.0, ..InstrumentSize::default() },
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
    let options = DiscoverOptions { seed, rotations: 199, ..DiscoverOptions::default() };
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
    assert_eq!(found.stopped, Termination::NothingLeft);
    assert!(!found.unexplained.significant);
    // 60 poses of three targets: too few for a test set, so that every row is predicted by nested folds.
    assert_eq!((found.held_out, found.holdout_rows.len()), (HeldOut::NestedFolds, 180));
}

/// The stated level is the one that is held: the p of what is left decides on either side of it.
#[test]
fn nothing_is_left_where_p_is_above_the_level_and_only_there() {
    let chain = with_three_targets(&samples::ur10());
    let search = |data: &Dataset, alpha: f64| {
        let options = DiscoverOptions { alpha, rotations: 199, ..DiscoverOptions::default() };
        let declared: [Box<dyn AnyEffect>; 1] = [Box::new(Geometric::default())];
        diagnose(&chain, &declared, data, &PivotedQr::default(), &options, &|_| ()).unwrap()
    };
    let robots = (0..20).map(|seed| measured(&chain, constants(), 30, &[], seed));
    let with_p =
        robots.map(|data| (search(&data, DiscoverOptions::default().alpha).unexplained.p_value, data));
    let (p, data) = with_p.into_iter().find(|(p, _)| (0.02..0.3).contains(p)).unwrap();
    let below = search(&data, 0.7 * p);
    assert_eq!(below.stopped, Termination::NothingLeft, "{p} {}", below.unexplained.p_value);
    assert!(below.findings.is_empty(), "{p} {:?}", words(&below));
    let above = search(&data, 1.4 * p);
    let more = above.stopped != Termination::NothingLeft || !above.findings.is_empty();
    assert!(more, "{p} {}", above.unexplained.p_value);
}

#[cfg(feature = "slow")]
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
    assert!(finding.p_value < 0.002);
    // The same switch under no name is the find itself.
    assert!(finding.alternatives.iter().all(|a| !a.equivalent), "{:?}", finding.alternatives);

    let pool = rayon::ThreadPoolBuilder::new().num_threads(3).build().unwrap();
    let again = pool.install(|| found(&chain, &[Box::new(Geometric::default())], &data, 1));
    assert_eq!(again.fit.fitted.coefficients(), found_once.fit.fitted.coefficients());
}

#[cfg(feature = "slow")]
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

/// Constant errors of all frames but one.
fn constants_without(chain: &Chain, frame: FrameId) -> Geometric {
    Geometric {
        frames: Some(chain.frames().filter(|f| *f != frame).map(Where::Frame).collect()),
        ..Geometric::default()
    }
}

#[test]
fn a_frame_that_nobody_declared_is_found_beside_a_soft_slide() {
    let chain = with_three_targets(&samples::scara());
    let crooked =
        flaws::Displacement { frame: "r2".into(), xyz_mm: [-0.6, 0.1, 0.2], turn_mrad: [0.9, -0.4, -1.5] };
    // Ten times softer than slides are expected to be; it is declared, so that it is nothing new.
    let soft = flaws::JointCompliance {
        joint: "slide".into(),
        stiffness: Some(1e6),
        ..flaws::JointCompliance::default()
    };
    let errors = Flaws { displacement: vec![crooked], joint_compliance: vec![soft], ..constants() };
    let data = measured(&chain, errors, 40, &[0.0, 4.0], 4);
    let frame = chain.frame_named("r2").unwrap();
    let declared: Vec<Box<dyn AnyEffect>> = vec![
        Box::new(constants_without(&chain, frame)),
        Box::new(JointCompliance { joints: Some(vec![JointId(3)]), ..JointCompliance::default() }),
    ];
    let found = found(&chain, &declared, &data, 0);
    assert_eq!(words(&found), ["geometric r2"]);
    let (before, after) = found.findings[0].holdout;
    assert!(after < 0.6 * before, "{before} {after}");
}

#[cfg(feature = "slow")]
#[test]
fn a_crooked_rail_is_one_finding() {
    let chain = with_three_targets(&samples::pps());
    // Along the rail, across it and in pitch: each alone would pass as a screw's, a coupling's or a nameless error.
    let rail = flaws::Guideway {
        joint: "d1".into(),
        xyz_um: [120.0, 0.0, 150.0],
        turn_urad: [0.0, 120.0, 0.0],
        correlation_mm: 600.0,
    };
    let data = measured(&chain, Flaws { guideway: vec![rail], ..constants() }, 120, &[], 2);
    let found = found(&chain, &[Box::new(Geometric::default())], &data, 0);
    assert_eq!(words(&found), ["guideway d1"]);
}

#[cfg(feature = "slow")]
#[test]
fn a_slide_that_grows_was_right_at_a_temperature_that_nobody_knows() {
    let chain = with_three_targets(&samples::pps());
    let growth = flaws::Thermal {
        at: "d3".into(),
        grows: flaws::Growing::Scale,
        per_kelvin: 90.0,
        ..flaws::Thermal::default()
    };
    let mut campaign = Campaign::random(&chain, 80, 6).unwrap();
    campaign.channels = vec![ChannelPlan::Air { name: "temperature".into(), sd: 0.05 }];
    let hours = campaign.duration_s() / 3600.0;
    let options = PlantOptions {
        errors: Flaws { thermal: vec![growth], ..constants() },
        instrument: InstrumentSize { sd_um: 10.0, ..InstrumentSize::default() },
        repeatability: RepeatabilitySize { sd_um: 20.0, ..RepeatabilitySize::default() },
        // Never at 20 °C, where everything has its nominal size.
        shop: ShopDay { start_c: 23.0, rise_k: 4.0, wander_k: 0.5, hours },
    };
    let plant = Plant::random(&chain, &options, 6).unwrap();
    let data = plant.measure(&campaign, 6).unwrap();
    let found = found(&chain, &[Box::new(Geometric::default())], &data, 0);
    assert_eq!(words(&found), ["thermal d3 on temperature"]);
    let scale = &found.findings[0].parameters[0];
    assert!((scale.value - 90e-6).abs() < 12e-6, "{scale:?}");
}

#[cfg(feature = "slow")]
#[test]
fn a_rival_that_the_data_cannot_refute_is_fitted_for_a_plan() {
    let chain = with_three_targets(&samples::ur10());
    // The last joint slipped on its flange, or the tool was turned: with the flange's axis alone nobody can tell.
    let slip = flaws::Shift { at: "j6".into(), when_s: 700.0, size_mm: 0.0, size_mrad: 0.8 };
    let data = measured(&chain, Flaws { shift: vec![slip], ..constants() }, 60, &[], 9);
    let options = DiscoverOptions { competing_fits: true, rotations: 199, ..DiscoverOptions::default() };
    let declared: Vec<Box<dyn AnyEffect>> = vec![Box::new(Geometric::default())];
    let found = diagnose(&chain, &declared, &data, &PivotedQr::default(), &options, &|_| ()).unwrap();
    let both = ["shift j6".to_owned(), "shift tool".to_owned()];
    assert_eq!(found.findings.len(), 1, "{:?}", words(&found));
    assert!(both.contains(&words(&found)[0]), "{:?}", words(&found));
    let tried: Vec<String> = found.competitors.iter().map(|r| r.candidate.words()).collect();
    println!("{} beside {tried:?}, {:?}", words(&found)[0], found.findings[0].alternatives);
    let rival = found.competitors.iter().find(|r| both.contains(&r.candidate.words())).expect("a rival");
    assert_eq!(rival.finding, 0);
    assert_ne!(rival.candidate.words(), words(&found)[0]);
    let rms = |fit: &truepose_identify::Fit| fit.residuals.positions().rms;
    assert!((rms(&rival.fit) / rms(&found.fit) - 1.0).abs() < 0.02);
}

#[test]
fn a_spring_whose_name_is_not_in_the_library_is_not_told_for_another_without_a_doubt() {
    let chain = with_three_targets(&samples::heavy());
    let soft = flaws::JointCompliance {
        joint: "a2".into(),
        stiffness: Some(1.5e6),
        ..flaws::JointCompliance::default()
    };
    let errors = Flaws { joint_compliance: vec![soft], ..constants() };
    let data = measured(&chain, errors, 60, &[0.0, 40.0, 90.0], 7);
    let library = Library::standard().without(Family::JointCompliance);
    let options = DiscoverOptions { library, rotations: 199, ..DiscoverOptions::default() };
    let declared: [Box<dyn AnyEffect>; 1] = [Box::new(Geometric::default())];
    let told = diagnose(&chain, &declared, &data, &PivotedQr::default(), &options, &|_| ()).unwrap();
    let first = &told.findings[0];
    let nameless = |a: &truepose_discover::Alternative| {
        a.equivalent
            && a.family == Family::Unmodelled
            && a.place.covariate == Some(Covariate::Load("a2".into()))
    };
    let named = first.candidate.family != Family::Unmodelled;
    assert!(!named || first.alternatives.iter().any(nameless), "{:?} {:?}", words(&told), first.alternatives);
    // With its name in the library nothing is in doubt.
    let told = found(&chain, &declared, &data, 0);
    let refused: Vec<_> = told.refused.iter().map(|r| (r.candidate.words(), r.doubt)).collect();
    assert_eq!(words(&told), ["joint_compliance a2"], "{refused:?} {:?}", told.withdrawn);
}

#[cfg(feature = "slow")]
#[test]
fn a_jump_is_a_jump_and_without_that_word_not_a_drift_without_a_doubt() {
    let chain = with_three_targets(&samples::pps());
    let bump = flaws::Shift { at: "tool".into(), when_s: 1500.0, size_mm: 0.4, size_mrad: 0.6 };
    let data = measured(&chain, Flaws { shift: vec![bump], ..constants() }, 90, &[], 11);
    let declared: Vec<Box<dyn AnyEffect>> = vec![Box::new(Geometric::default())];
    let nameless = |found: &Diagnosis| {
        let first = &found.findings[0];
        first.candidate.family == Family::Unmodelled
            || first.alternatives.iter().any(|a| a.family == Family::Unmodelled && a.equivalent)
    };
    let all = found(&chain, &declared, &data, 0);
    assert_eq!(all.findings[0].candidate.family, Family::Shift, "{:?}", words(&all));
    // Told with certainty: no curve over time does as well, and visits next to it are no outliers.
    assert!(!nameless(&all), "{:?}", all.findings[0].alternatives);
    assert_eq!(all.findings.len(), 1, "{:?}", words(&all));
    // Between the rows on either side nobody knows when.
    let jump = all.findings[0].candidate.effects()[0].parameters();
    let gap: Vec<f64> = jump["gap"].as_array().unwrap().iter().map(|v| v.as_f64().unwrap()).collect();
    assert!(gap[0] < 1500.0 && 1500.0 <= gap[1] && gap[1] - gap[0] < 200.0, "{jump}");
    assert!(data.time.iter().all(|t| *t <= gap[0] || gap[1] <= *t), "{jump}");

    let library = Library::standard().without(Family::Shift);
    let options = DiscoverOptions { library, rotations: 199, ..DiscoverOptions::default() };
    let without = diagnose(&chain, &declared, &data, &PivotedQr::default(), &options, &|_| ()).unwrap();
    assert!(!without.findings.is_empty());
    assert!(nameless(&without), "{:?}: {:?}", words(&without), without.findings[0].alternatives);
}

#[cfg(feature = "slow")]
#[test]
fn what_shows_within_visits_is_told_while_whole_visits_are_off_for_other_reasons() {
    let chain = with_three_targets(&samples::heavy());
    let errors = Flaws {
        coupling: vec![flaws::Dragging {
            joint: "a6".into(),
            driver: "a1".into(),
            ratio_milli: 0.6,
            eccentricity_mrad: 0.0,
        }],
        shift: vec![flaws::Shift { at: "base".into(), when_s: 2000.0, size_mm: 0.3, size_mrad: 0.3 }],
        transmission: vec![flaws::Transmission {
            joint: "a3".into(),
            wheel: flaws::Wheel::Eccentric,
            amplitude_mrad: 0.3,
            cycles: Some(7.0),
            phase_deg: None,
        }],
        ..constants()
    };
    let data = measured(&chain, errors, 110, &[], 12);
    let told = found(&chain, &[Box::new(Geometric::default())], &data, 0);
    let mut words = words(&told);
    words.sort();
    assert_eq!(words, ["coupling a6 by a1", "shift base", "transmission a3"]);
}

#[cfg(feature = "slow")]
#[test]
fn what_depends_on_a_joint_and_on_what_is_carried_has_no_name_but_a_place() {
    let chain = with_three_targets(&samples::heavy());
    let mut data = measured(&chain, constants(), 40, &[0.0, 60.0, 120.0], 13);
    // The frame behind a4 turns about its z with a6 and with the mass: told to the data by geometry alone.
    let frame = chain.frame_named("a4").unwrap();
    let last = chain.coordinate(JointId(6)).unwrap();
    for row in 0..data.len() {
        let conditions = data.conditions(row);
        let mass = match conditions.load {
            Load::Payload(payload) => payload.mass,
            _ => 0.0,
        };
        let mut buffer = PostureBuffer::new(&chain);
        let place = *buffer.update(&chain, &conditions).frame(frame);
        let axis = nalgebra::Unit::new_normalize(place.rotation * Vector3::z());
        let turn = Rotation3::from_axis_angle(&axis, 4e-6 * mass * conditions.joints[last]);
        let point = Vector3::from(data.position[row]) - place.translation;
        data.position[row] = (turn * point + place.translation).into();
    }
    let joints = [2, 3, 5].map(JointId).to_vec();
    let declared: [Box<dyn AnyEffect>; 2] = [
        Box::new(Geometric::default()),
        Box::new(JointCompliance { joints: Some(joints), ..JointCompliance::default() }),
    ];
    let told = found(&chain, &declared, &data, 0);
    let first = &told.findings[0];
    assert_eq!(first.candidate.family, Family::Unmodelled, "{:?}", words(&told));
    let covariates = [&first.candidate.place.covariate, &first.candidate.place.covariate2];
    let mut covariates: Vec<String> = covariates.into_iter().flatten().map(Covariate::to_string).collect();
    covariates.sort_unstable();
    assert_eq!(covariates, ["a6", CARRIED]);
    let (before, after) = first.holdout;
    assert!(after < 0.5 * before, "{before} {after}");
    // Wherever the fit is used the mass comes from the load.
    let predicted = truepose_identify::Residuals::of(&told.fit.fitted, &data).unwrap();
    let noise = told.fit.noise.floor(f64::NAN);
    assert!(predicted.positions().rms < 1.2 * noise, "{:?} {noise}", predicted.positions());
}
