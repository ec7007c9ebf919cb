//! As few measured poses as there are unknowns: the stated uncertainty has to hold where residuals contain next to nothing.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use truepose_errormodel::effects::Geometric;
use truepose_errormodel::{AnyEffect, Dataset, DatasetBuilder, ErrorModel, FittedModel, Measurement, Schema};
use truepose_identify::{FitOptions, fit};
use truepose_kinematics::nalgebra::{DMatrix, Rotation3, UnitQuaternion, Vector3};
use truepose_kinematics::{Conditions, samples};
use truepose_solvers::PivotedQr;

/// Noise of a position, m, and of an orientation, rad.
const NOISE: [f64; 2] = [5e-5, 1e-4];

fn joints(rng: &mut ChaCha8Rng) -> Vec<f64> {
    (0..6).map(|_| rng.random_range(-1.7..1.7)).collect()
}

/// So many measured poses.
fn measured(truth: &FittedModel, poses: usize, rng: &mut ChaCha8Rng) -> Dataset {
    let mut data = DatasetBuilder::new(truth.chain());
    let mut predictor = truth.bind(&Schema::default()).unwrap();
    for _ in 0..poses {
        let joints = joints(rng);
        let pose = predictor.predict(&Conditions::at(truth.chain(), &joints), None);
        // Of a uniform distribution with this standard deviation.
        let mut error = |sd: f64| Vector3::from_fn(|_, _| sd * 3f64.sqrt() * rng.random_range(-1.0..1.0));
        let mut row = Measurement::at(joints);
        row.position = (pose.translation + error(NOISE[0])).into();
        let turned = UnitQuaternion::from_matrix(&(Rotation3::new(error(NOISE[1])).matrix() * pose.rotation));
        row.orientation = Some([turned.w, turned.i, turned.j, turned.k]);
        data.push(row).unwrap();
    }
    data.finish()
}

#[test]
fn eight_measured_poses_have_a_noise_and_a_band_that_holds() {
    let (mut error, mut band) = (0.0, 0.0);
    for seed in 0..6 {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let model =
            ErrorModel::new(samples::ur10(), vec![Box::new(Geometric::default()) as Box<dyn AnyEffect>]);
        let model = model.unwrap();
        let n = model.columns().len();
        let errors = (0..n).map(|_| 4e-4 * rng.random_range(-1.7..1.7)).collect();
        let truth = FittedModel::new(model.clone(), errors, DMatrix::zeros(n, n)).unwrap();
        let data = measured(&truth, 8, &mut rng);
        let found = fit(&model, &data, &PivotedQr::default(), &FitOptions::default()).unwrap();
        let stated = [found.noise.position_sd, found.noise.orientation_sd];
        let near = |stated: f64, noise: f64| stated > 0.2 * noise && stated < 5.0 * noise;
        assert!(near(stated[0], NOISE[0]) && near(stated[1], NOISE[1]), "{seed}: {stated:?}");
        let bound = |model: &FittedModel| -> Vec<(Vector3<f64>, f64)> {
            let mut rng = ChaCha8Rng::seed_from_u64(100 + seed);
            let mut predictor = model.bind(&data.schema).unwrap();
            let one = |_| {
                let at = Conditions::at(model.chain(), &joints(&mut rng));
                let covariance = predictor.covariance(&at, None);
                (predictor.predict(&at, None).translation, covariance.fixed_view::<3, 3>(0, 0).trace())
            };
            (0..40).map(one).collect()
        };
        for ((real, _), (predicted, variance)) in bound(&truth).into_iter().zip(bound(&found.fitted)) {
            error += (real - predicted).norm_squared();
            band += variance;
        }
    }
    assert!(error < 4.0 * band, "error {:e} m, stated {:e} m", error.sqrt(), band.sqrt());
}
