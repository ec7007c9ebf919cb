//! The effect of a third party the whole way: declared, fitted, written, read, compensated, and discovered.

#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

use truepose_compensate::{Compensator, CompensatorOptions, Status, Target};
use truepose_discover::{Diagnosis, DiscoverOptions, Family, Library, diagnose};
use truepose_errormodel::effects::Geometric;
use truepose_errormodel::{AnyEffect, Dataset, EffectRegistry, ErrorModel, Schema};
use truepose_identify::{FitOptions, fit};
use truepose_io::{read_fit, read_model, write_fit};
use truepose_kinematics::nalgebra::Vector3;
use truepose_kinematics::{Chain, Conditions, JointId, samples};
use truepose_simulate::description::{InstrumentSize, RepeatabilitySize};
use truepose_simulate::{Campaign, Flaws, Plant, PlantOptions, flaws};
use truepose_solvers::PivotedQr;
use truepose_third_party::{EncoderGain, EncoderGains};

/// The encoder of this joint reads this fraction too little.
const JOINT: &str = "j3";
const GAIN: f64 = 8e-4;

/// An arm with constant errors, and nothing else that a model of ours knows.
fn plant(chain: &Chain) -> Plant {
    let geometric =
        flaws::Geometric { position_mm: 0.4, angle_mrad: 0.3, target_mm: 0.0, ..flaws::Geometric::default() };
    let options = PlantOptions {
        errors: Flaws { geometric: Some(geometric), ..Flaws::default() },
        instrument: InstrumentSize { sd_um: 10.0, ..InstrumentSize::default() },
        repeatability: RepeatabilitySize { sd_um: 20.0, ..RepeatabilitySize::default() },
        ..PlantOptions::default()
    };
    Plant::random(chain, &options, 4).unwrap()
}

fn joint(chain: &Chain) -> JointId {
    chain.joint_named(JOINT).unwrap()
}

/// What the plant does, with joint values as the encoder reads them: where the joint stands at q, it reads q / (1 + g).
fn measured(plant: &Plant, visits: usize, seed: u64) -> Dataset {
    let chain = plant.chain();
    let mut data = plant.measure(&Campaign::random(chain, visits, seed).unwrap(), seed).unwrap();
    let column = chain.coordinate(joint(chain)).unwrap();
    data.joints[column].iter_mut().for_each(|q| *q /= 1.0 + GAIN);
    data
}

fn discovered(chain: &Chain, data: &Dataset, library: Library) -> Diagnosis {
    let declared: [Box<dyn AnyEffect>; 1] = [Box::new(Geometric::default())];
    let options = DiscoverOptions { library, ..DiscoverOptions::default() };
    diagnose(chain, &declared, data, &PivotedQr::default(), &options, &|_| ()).unwrap()
}

#[test]
fn it_is_declared_fitted_written_read_and_compensated() {
    let plant = plant(&samples::ur10());
    let chain = plant.chain();
    let data = measured(&plant, 80, 9);

    let folder = tempfile::tempdir().unwrap();
    let registry = EffectRegistry::builtin().with::<EncoderGain>();
    let model = folder.path().join("model.toml");
    let text = format!(
        "[[effects]]\nfamily = \"geometric\"\n[[effects]]\nfamily = \"acme/encoder_gain\"\njoint = \"{JOINT}\"\n"
    );
    std::fs::write(&model, text).unwrap();
    let effects = read_model(&model, chain, &registry).unwrap();
    let model = ErrorModel::new(chain.clone(), effects).unwrap();
    let fit = fit(&model, &data, &PivotedQr::default(), &FitOptions::default()).unwrap();
    let column = model.columns().iter().position(|c| c.name == format!("gain {JOINT}")).unwrap();
    let (found, sd) = (fit.fitted.coefficients()[column], fit.fitted.covariance()[(column, column)].sqrt());
    assert!((found - GAIN).abs() < 4.0 * sd && sd < 0.1 * GAIN, "{found} ± {sd}");

    let path = folder.path().join("fit.json");
    write_fit(&path, &fit.fitted).unwrap();
    assert!(read_fit(&path, &EffectRegistry::builtin()).is_err(), "a program that does not know the effect");
    let fitted = read_fit(&path, &registry).unwrap();
    assert_eq!(fitted.coefficients(), fit.fitted.coefficients());

    let mut compensator =
        Compensator::bind(&fitted, &Schema::default(), CompensatorOptions::default()).unwrap();
    let coordinate = chain.coordinate(joint(chain)).unwrap();
    let (mut nominal, mut compensated, mut count) = (0.0, 0.0, 0.0);
    for visit in &Campaign::random(chain, 40, 31).unwrap().visits {
        let pose = chain.forward(&visit.joints);
        let wanted = Target::at(pose.translation).turned(pose.rotation);
        let command =
            compensator.command(&wanted, &Conditions::at(chain, &visit.joints), Some(&visit.joints));
        if command.status != Status::Ok {
            continue;
        }
        // The drive stops where its encoder reads what was commanded: the joint then stands at (1 + g) of it.
        let square = |joints: &[f64]| {
            let mut reached = joints.to_vec();
            reached[coordinate] *= 1.0 + GAIN;
            let at: Vector3<f64> = plant.true_position(&Conditions::at(chain, &reached), None).unwrap();
            (at - pose.translation).norm_squared()
        };
        nominal += square(&visit.joints);
        compensated += square(&command.joints);
        count += 1.0;
    }
    assert!(count > 30.0, "{count} of 40");
    let (nominal, compensated) = (f64::sqrt(nominal / count), f64::sqrt(compensated / count));
    assert!(compensated < 0.05e-3 && nominal > 10.0 * compensated, "{nominal} m, {compensated} m");
}

#[test]
fn it_is_discovered_where_its_hypothesis_is_in_the_library() {
    let plant = plant(&samples::ur10());
    let chain = plant.chain();
    let data = measured(&plant, 60, 5);

    let with = discovered(chain, &data, Library::standard().with(EncoderGains));
    let first = &with.findings[0];
    assert_eq!(first.candidate.family, Family::Other("acme/encoder_gain"));
    assert_eq!(first.candidate.words(), format!("acme/encoder_gain {JOINT}"));
    assert_eq!(with.findings.len(), 1);
    let gain = &first.parameters[0];
    assert!(gain.ci95[0] < GAIN && GAIN < gain.ci95[1], "{gain:?}");
    assert!(gain.ci95[1] - gain.ci95[0] < 0.2 * GAIN, "{gain:?}");
    assert!(first.holdout.1 < 0.5 * first.holdout.0, "{:?}", first.holdout);
    assert!(first.candidate.meaning().starts_with("The encoder of j3 reads"));
    let trace = first.trace.as_ref().unwrap();
    assert_eq!((trace.what.as_str(), trace.driver.as_str()), ("j3 about its axis", JOINT));

    // The fit of the discovery knows the effect as any other.
    assert!(with.fit.fitted.model().columns().iter().any(|c| c.name == format!("gain {JOINT}")));

    // Without it the same error is found under another name, or under none.
    let without = discovered(chain, &data, Library::standard());
    assert!(without.findings.iter().all(|f| f.candidate.family != Family::Other("acme/encoder_gain")));
    assert!(!without.findings.is_empty());
}
