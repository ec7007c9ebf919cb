use super::*;
use crate::{Residuals, fit};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use truepose_errormodel::{DatasetBuilder, KnownDistance, Landmark, Measurement};
use truepose_kinematics::samples;
use truepose_solvers::PivotedQr;

/// The arm of a light robot with errors, which touches sockets with its tool's origin: joints of touching postures are solved for here, by
/// Newton's method on the true robot, so that the law is not that of the fit.
struct Cell {
    chain: Chain,
    truth: FittedModel,
    sockets: Vec<Vector3<f64>>,
}

fn cell(seed: u64) -> Cell {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let chain = samples::ur10();
    let frames: Vec<_> = chain.frames().collect();
    let arm = Geometric {
        frames: Some(frames[1..].iter().map(|&frame| Where::Frame(frame)).collect()),
        components: None,
    };
    let model = ErrorModel::new(chain.clone(), vec![Box::new(arm)]).unwrap();
    let coefficients: Vec<f64> =
        model.columns().iter().map(|c| c.scale * rng.random_range(-3.0..3.0)).collect();
    let count = coefficients.len();
    let truth = FittedModel::new(model, coefficients, DMatrix::zeros(count, count)).unwrap();
    let mut sockets = Vec::new();
    for _ in 0..6 {
        let at = Vector3::new(
            rng.random_range(0.35..0.8),
            rng.random_range(-0.5..0.5),
            rng.random_range(0.0..0.5),
        );
        let way = Vector3::from_fn(|_, _| rng.random_range(-1.0..1.0)).normalize();
        sockets.push(at);
        sockets.push(at + 0.05 * way);
    }
    Cell { chain, truth, sockets }
}

/// Joints with which the true robot touches a point.
fn touching(of: &Cell, at: &Vector3<f64>, rng: &mut ChaCha8Rng) -> Vec<f64> {
    let mut predictor = of.truth.bind(&Default::default()).unwrap();
    loop {
        let mut q: Vec<f64> = (0..6).map(|_| rng.random_range(-2.5..2.5)).collect();
        for _ in 0..30 {
            let mut at_joints = |q: &[f64]| {
                predictor
                    .predict(&Conditions { joints: q.to_vec(), ..Conditions::default() }, None)
                    .translation
            };
            let here = at_joints(&q);
            if (here - at).norm() < 1e-10 {
                return q;
            }
            let jacobian = DMatrix::from_fn(3, 6, |row, k| {
                let mut moved = q.clone();
                moved[k] += 1e-6;
                (at_joints(&moved)[row] - here[row]) / 1e-6
            });
            let Ok(inverse) = jacobian.pseudo_inverse(1e-6) else { break };
            let step = inverse * DMatrix::from_column_slice(3, 1, (at - here).as_slice());
            q.iter_mut().zip(step.iter()).for_each(|(q, s)| *q += s.clamp(-0.5, 0.5));
        }
    }
}

fn campaign(of: &Cell, touches: usize, scatter: f64, seed: u64) -> (Dataset, Surroundings) {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut builder = DatasetBuilder::new(&of.chain);
    let mut at = Vec::new();
    for (k, socket) in of.sockets.iter().enumerate() {
        for _ in 0..touches {
            let off = Vector3::from_fn(|_, _| scatter * rng.random_range(-1.7..1.7));
            let q = touching(of, &(socket + off), &mut rng);
            builder.push(Measurement::at(q).visit(at.len() as u64)).unwrap();
            at.push(Some(k));
        }
    }
    let mut data = builder.finish();
    data.set_landmarks(Some(&at));
    let landmark = |k: usize| Landmark { name: format!("L{k}"), position: None, known: false };
    let landmarks = (0..of.sockets.len()).map(landmark).collect();
    let distance = |k: usize| KnownDistance { between: [2 * k, 2 * k + 1], value: 0.05, sd: 0.0 };
    (data, Surroundings { landmarks, distances: (0..6).map(distance).collect() })
}

fn geometric() -> Vec<Box<dyn AnyEffect>> {
    vec![Box::new(Geometric::default())]
}

#[test]
fn an_arm_is_calibrated_with_nothing_but_sockets_at_known_distances() {
    let of = cell(4);
    let (data, surroundings) = campaign(&of, 25, 2e-5, 9);
    let solver = PivotedQr::default();
    let options = FitOptions::default();
    let made = touched(&of.chain, &geometric(), &data, &surroundings, (&solver, &options)).unwrap();
    assert_eq!((made.distances.len(), made.groups[2], made.groups[11]), (6, 1, 5));
    let model = ErrorModel::new(made.chain.clone(), made.effects.clone()).unwrap();
    let found = fit(&model, &made.data, &solver, &options).unwrap();
    let spread = Residuals::of(&found.fitted, &made.data).unwrap().positions().rms;
    assert!(spread < 1.1 * 2e-5 * 1.7, "{spread}");
    // Distances between sockets that nothing told, up to 0.9 m: the scale is right, at sockets that the fit has not seen as well.
    let (held, places) =
        landmark_cross_validation(&found, &made.data, &made.groups, (&solver, &options)).unwrap().unwrap();
    let rms = held.residuals.positions().rms;
    assert!(rms < 2.0 * 2e-5 * 1.7, "{rms}");
    let robot = found.fitted.without_landmarks().unwrap();
    assert!(robot.channels.is_empty());
    for fold in &places {
        let apart = (fold.positions[0] - fold.positions[1]).norm();
        assert!((apart - 0.05).abs() < 3e-5, "{apart}");
    }
    for k in (0..10).step_by(2) {
        let (found, truth) = (made.positions[k + 2] - made.positions[k], of.sockets[k + 2] - of.sockets[k]);
        assert!((found.norm() - truth.norm()).abs() < 1.5e-4, "{} m", found.norm() - truth.norm());
    }
}

#[test]
fn without_a_distance_the_scale_is_said_to_be_unknown() {
    let of = cell(5);
    let (data, mut surroundings) = campaign(&of, 8, 2e-5, 3);
    surroundings.distances.clear();
    let (solver, options) = (PivotedQr::default(), FitOptions::default());
    let made = touched(&of.chain, &geometric(), &data, &surroundings, (&solver, &options)).unwrap();
    let told = made.remarks.join("; ");
    assert!(
        told.contains("the base is not determined") && told.contains("the scale is not determined"),
        "{told}"
    );
    assert_eq!(made.groups.iter().max(), Some(&11));
}

#[test]
fn a_landmark_that_was_touched_once_is_refused_and_one_that_was_not_is_told() {
    let of = cell(6);
    let (data, mut surroundings) = campaign(&of, 4, 2e-5, 3);
    surroundings.landmarks.push(Landmark { name: "spare".into(), position: None, known: false });
    surroundings.distances.push(KnownDistance { between: [0, 2], value: 0.3, sd: 0.0 });
    surroundings.distances.push(KnownDistance { between: [1, 2], value: 0.3, sd: 0.0 });
    let (solver, options) = (PivotedQr::default(), FitOptions::default());
    let made = touched(&of.chain, &geometric(), &data, &surroundings, (&solver, &options)).unwrap();
    let told = made.remarks.join("; ");
    assert!(told.contains("no row touched landmark spare"), "{told}");
    assert!(told.contains("the distance from L") && told.contains("close a ring"), "{told}");
    let few = data.select(&(0..5).collect::<Vec<_>>());
    let error = touched(&of.chain, &geometric(), &few, &surroundings, (&solver, &options)).unwrap_err();
    assert!(error.to_string().contains("landmark L1: one row touched it"), "{error}");
}
