//! Two arms on a torso that touch each other, or hold a bar of known length between them. Where they meet is found on the true robot by Newton's
//! method, so that the law is not that of the fit.

use super::*;
use crate::{
    Fit, Folds, Method, NoiseModel, NoiseSource, PriorStrength, Residuals, Split, cross_validate, fit,
};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use truepose_errormodel::observation::{FRAMES, KINDS};
use truepose_errormodel::{DatasetBuilder, KnownDistance, Landmark, Measurement, RobotPoint};
use truepose_kinematics::{Conditions, TargetId, samples};
use truepose_solvers::PivotedQr;

const LEFT: TargetId = TargetId(0);
const RIGHT: TargetId = TargetId(1);
const BAR: f64 = 0.15;
const NOISE: f64 = 3e-5;

/// A robot whose joints, and nothing else, have errors.
fn truth(chain: &Chain, rng: &mut ChaCha8Rng) -> FittedModel {
    let frames: Vec<FrameId> = chain.frames().collect();
    let arms = Geometric {
        frames: Some(frames[1..=chain.joints().len()].iter().map(|&frame| Where::Frame(frame)).collect()),
        components: None,
    };
    let model = ErrorModel::new(chain.clone(), vec![Box::new(arms)]).unwrap();
    let coefficients: Vec<f64> =
        model.columns().iter().map(|c| c.scale * rng.random_range(-3.0..3.0)).collect();
    let count = coefficients.len();
    FittedModel::new(model, coefficients, DMatrix::zeros(count, count)).unwrap()
}

/// From one hand to the other, m.
fn way(robot: &FittedModel, q: &[f64]) -> Vector3<f64> {
    let mut predictor = robot.bind(&Default::default()).unwrap();
    let mut at = |target: TargetId| {
        let tool = robot.chain().targets()[target.0].tool;
        let conditions = Conditions { joints: q.to_vec(), tool, ..Conditions::default() };
        predictor.predict(&conditions, Some(target)).translation
    };
    at(RIGHT) - at(LEFT)
}

/// Joints with which the hands are this way apart.
fn meeting(robot: &FittedModel, apart: &Vector3<f64>, rng: &mut ChaCha8Rng) -> Vec<f64> {
    let joints = robot.chain().movable().len();
    loop {
        let mut q: Vec<f64> = (0..joints).map(|_| rng.random_range(-1.5..1.5)).collect();
        for _ in 0..40 {
            let here = way(robot, &q) - apart;
            if here.norm() < 1e-10 {
                return q;
            }
            let jacobian = DMatrix::from_fn(3, joints, |row, k| {
                let mut moved = q.clone();
                moved[k] += 1e-6;
                (way(robot, &moved) - apart - here)[row] / 1e-6
            });
            let Ok(inverse) = jacobian.pseudo_inverse(1e-6) else { break };
            let step = inverse * DMatrix::from_column_slice(3, 1, here.as_slice());
            q.iter_mut().zip(step.iter()).for_each(|(q, s)| *q -= s.clamp(-0.4, 0.4));
        }
    }
}

/// Rows of these distances between the hands, m; zero: they touch.
fn campaign(robot: &FittedModel, distances: &[f64], rng: &mut ChaCha8Rng) -> Dataset {
    let chain = robot.chain();
    let mut builder = DatasetBuilder::new(chain);
    for (visit, &distance) in distances.iter().enumerate() {
        let direction = Vector3::from_fn(|_, _| rng.random_range(-1.0..1.0)).normalize();
        let noise =
            Vector3::from_fn(|_, _| NOISE * (0..12).map(|_| rng.random_range(-0.5..0.5)).sum::<f64>());
        let q = meeting(robot, &(direction * distance + noise), rng);
        builder.push(Measurement::at(q).target(LEFT).visit(visit as u64)).unwrap();
    }
    let mut data = builder.finish();
    let kind = KINDS.iter().position(|kind| *kind == FRAMES).unwrap() + 1;
    let values = [Some(distances.to_vec()), None, None];
    data.set_kinds(Some(vec![kind as f64; data.len()]), values);
    data.set_meets(Some(&vec![Some(RobotPoint::Target(RIGHT)); data.len()]));
    data.set_tools(chain, &vec![ToolId::FIRST; data.len()]);
    data
}

fn errors_of_arms() -> Vec<Box<dyn AnyEffect>> {
    vec![Box::new(Geometric::default())]
}

#[test]
fn two_arms_that_touch_and_hold_a_bar_are_calibrated_against_each_other() {
    let mut rng = ChaCha8Rng::seed_from_u64(21);
    let chain = samples::dual();
    let robot = truth(&chain, &mut rng);
    let distances: Vec<f64> = (0..50).map(|k| if k % 2 == 0 { 0.0 } else { BAR }).collect();
    let data = campaign(&robot, &distances, &mut rng);
    let (solver, options) = (PivotedQr::default(), FitOptions::default());
    let made =
        touched(&chain, &errors_of_arms(), &data, &Surroundings::default(), (&solver, &options)).unwrap();
    assert_eq!((made.data.len(), made.contacts.len()), (50, 50));
    assert_eq!(
        (made.contacts[1].rows, made.contacts[1].distance.to_bits()),
        (ContactRows::Difference(1), BAR.to_bits())
    );
    // Of a contact three numbers, of a bar one, and no unknown place.
    let numbers: usize = (0..50).map(|row| made.data.seen(row).count()).sum();
    assert_eq!((numbers, made.names.len()), (25 * 3 + 25, 0));
    // Both arms stand on fixed joints, whose frames have errors.
    assert!(!made.remarks.iter().any(|remark| remark.contains("as described")), "{:?}", made.remarks);
    // A bar of known length fixes the scale.
    assert!(!made.remarks.iter().any(|remark| remark.contains("scale")), "{:?}", made.remarks);
    let model = ErrorModel::new(made.chain.clone(), made.effects.clone()).unwrap();
    let found = fit(&model, &made.data, &solver, &options).unwrap();
    // Gaps of contacts that the fit has not seen: of the touching ones all three coordinates, of the bar its length.
    assert_eq!(landmark_groups(&made.effects), None);
    let folds = Folds::new(&made.data, &Split::Random { folds: 10, seed: 3 }).unwrap();
    let held = cross_validate(&found, &made.data, &folds, &solver, Method::Auto).unwrap();
    let gap = |of: &Residuals, k: usize| made.contacts[k].gap(of).norm_squared();
    let rms = |bar: usize| ((bar..50).step_by(2).map(|k| gap(&held.residuals, k)).sum::<f64>() / 25.0).sqrt();
    assert!((0.9..1.6).contains(&(rms(0) / (3f64.sqrt() * NOISE))), "{}", rms(0));
    assert!((0.8..1.6).contains(&(rms(1) / NOISE)), "{}", rms(1));
    // And anywhere: how far apart the hands are, which errors of the torso do not change.
    let fitted = found.fitted.without_landmarks().unwrap();
    let nominal = bare(&chain).unwrap();
    let (mut left, mut before) = (0.0, 0.0);
    for _ in 0..200 {
        let q: Vec<f64> = (0..8).map(|_| rng.random_range(-1.2..1.2)).collect();
        let apart = way(&robot, &q).norm();
        left += (way(&fitted, &q).norm() - apart).powi(2);
        before += (way(&nominal, &q).norm() - apart).powi(2);
    }
    assert!(left.sqrt() < 0.05 * before.sqrt(), "{} of {}", left.sqrt(), before.sqrt());
}

#[test]
fn contacts_alone_leave_the_scale_open_and_points_of_one_tool_say_nothing() {
    let mut rng = ChaCha8Rng::seed_from_u64(22);
    let chain = samples::dual();
    let robot = truth(&chain, &mut rng);
    let mut data = campaign(&robot, &[0.0; 40], &mut rng);
    let (solver, options) = (PivotedQr::default(), FitOptions::default());
    let surroundings = Surroundings::default();
    let made = touched(&chain, &errors_of_arms(), &data, &surroundings, (&solver, &options)).unwrap();
    let told = made.remarks.join("; ");
    assert!(
        told.contains("the scale is not determined") && told.contains("the fit keeps the scale"),
        "{told}"
    );
    // Ten contacts far from each other keep a place, between which a distance is held; the others are differences.
    let places = made.contacts.iter().filter(|contact| matches!(contact.rows, ContactRows::Landmark(_)));
    assert_eq!((places.count(), made.names.len(), made.data.len()), (10, 10, 50));
    // Folds hold the scale as well: either side of a contact that was left out has half of its gap.
    let model = ErrorModel::new(made.chain.clone(), made.effects.clone()).unwrap();
    let found = fit(&model, &made.data, &solver, &options).unwrap();
    let groups = landmark_groups(&made.effects).unwrap();
    let (held, _) =
        landmark_cross_validation(&found, &made.data, &groups, (&solver, &options)).unwrap().unwrap();
    for contact in &made.contacts {
        let gap = contact.gap(&held.residuals).norm();
        assert!((1e-7..30.0 * NOISE).contains(&gap), "{gap}");
        if let ContactRows::Landmark(rows) = contact.rows {
            let [a, b] = rows.map(|row| held.residuals.position[row]);
            assert!((a + b).norm() < 1e-12, "{a} {b}");
        }
    }
    data.set_meets(Some(&[Some(RobotPoint::Tool(ToolId::FIRST)); 40]));
    let error = touched(&chain, &errors_of_arms(), &data, &surroundings, (&solver, &options)).unwrap_err();
    assert!(error.to_string().contains("L and left are on one tool"), "{error}");
}

/// The same rows, each contact as four rows of kind `same_point`, two of each side, at a landmark of its own, or at two at their distance.
fn as_landmarks(chain: &Chain, data: &Dataset, distances: &[f64]) -> (Dataset, Surroundings) {
    let source: Vec<usize> = (0..data.len()).flat_map(|row| [row; 4]).collect();
    let mut rows = data.select(&source);
    let mut around = Surroundings::default();
    let mut of_row = Vec::new();
    for (k, &distance) in distances.iter().enumerate() {
        let first = around.landmarks.len();
        let mut add = |side: &str| {
            around.landmarks.push(Landmark { name: format!("{k}{side}"), ..Landmark::default() })
        };
        add("a");
        if distance > 0.0 {
            add("b");
            around.distances.push(KnownDistance { between: [first, first + 1], value: distance, sd: 0.0 });
        }
        let last = around.landmarks.len() - 1;
        of_row.extend([first, first, last, last].map(Some));
        (2..4).for_each(|side| rows.target[4 * k + side] = Some(RIGHT));
    }
    rows.set_meets(None);
    rows.set_kinds(None, [None, None, None]);
    rows.set_tools(chain, &vec![ToolId::FIRST; rows.len()]);
    rows.set_landmarks(Some(&of_row));
    (rows, around)
}

/// Eliminating the place of a contact changes nothing: two rows of its difference weigh as much as two rows of each side at a landmark of its own.
#[test]
fn differences_say_what_landmarks_of_their_own_say() {
    let mut rng = ChaCha8Rng::seed_from_u64(23);
    let chain = samples::dual();
    let robot = truth(&chain, &mut rng);
    let distances: Vec<f64> = (0..45).map(|k| if k % 3 == 2 { BAR } else { 0.0 }).collect();
    let data = campaign(&robot, &distances, &mut rng);
    let noise = NoiseModel { position_sd: NOISE, visit_sd: 0.0, orientation_sd: 1e-4 };
    // Errors are within three expected sizes.
    let prior = PriorStrength::Fixed(3.0);
    let options = FitOptions { prior, noise: NoiseSource::Fixed(noise), ..FitOptions::default() };
    let solver = PivotedQr::default();
    let made = |data: &Dataset, around: &Surroundings| {
        let made = touched(&chain, &errors_of_arms(), data, around, (&solver, &options)).unwrap();
        let model = ErrorModel::new(made.chain.clone(), made.effects.clone()).unwrap();
        let found = fit(&model, &made.data, &solver, &options).unwrap();
        (made, found)
    };
    let twice: Vec<usize> = (0..data.len()).flat_map(|row| [row; 2]).collect();
    let (differences, eliminated) = made(&data.select(&twice), &Surroundings::default());
    let (rows, around) = as_landmarks(&chain, &data, &distances);
    let (landmarks, carried) = made(&rows, &around);
    // Thirty places of three unknowns and fifteen pairs of five are gone.
    let unknowns = |fit: &Fit| fit.fitted.coefficients().len();
    assert_eq!(unknowns(&carried) - unknowns(&eliminated), 30 * 3 + 15 * 5);
    assert_eq!((differences.data.len(), landmarks.data.len()), (90, 180));
    // What is left of the rows, and where the hands are from each other, anywhere.
    let squares = |of: &Residuals| of.position.iter().map(Vector3::norm_squared).sum::<f64>();
    let (a, b) = (squares(&eliminated.residuals), squares(&carried.residuals));
    assert!((a / b - 1.0).abs() < 0.02, "{a} {b}");
    let fitted = [&eliminated, &carried].map(|of| of.fitted.without_landmarks().unwrap());
    let (mut apart, mut off) = (0.0, 0.0);
    for _ in 0..100 {
        let q: Vec<f64> = (0..8).map(|_| rng.random_range(-1.2..1.2)).collect();
        let [a, b] = [0, 1].map(|k| way(&fitted[k], &q).norm());
        apart += (a - b).powi(2);
        off += (a - way(&robot, &q).norm()).powi(2);
    }
    assert!(apart.sqrt() < 0.1 * off.sqrt(), "{} of {}", apart.sqrt(), off.sqrt());
}
