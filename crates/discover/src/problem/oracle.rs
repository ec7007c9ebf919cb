//! The accelerated paths against the dense reference: positions, orientations, several rows a pose, a prior, absorbed directions.

use crate::hypotheses::candidate::Candidate;
use crate::hypotheses::family::Family;
use crate::hypotheses::library::Library;
use crate::options::DiscoverOptions;
use crate::problem::anchor::Anchors;
use crate::problem::dense::Dense;
use crate::problem::likelihood::Likelihood;
use crate::problem::linear::Linear;
use crate::problem::linearisation::Linearisation;
use crate::problem::projection::{Projection, Score};
use crate::problem::synthetic::{data, fitted, wave};
use nalgebra::DMatrix;
use truepose_errormodel::{Dataset, Visits};
use truepose_identify::{Fit, Folds, NoiseModel, Split};
use truepose_kinematics::Chain;

const NOISE: NoiseModel = NoiseModel { position_sd: 4e-5, visit_sd: 6e-5, orientation_sd: 2e-4 };

fn measured() -> (Chain, Dataset, Fit) {
    // A joint that wobbles, and what differs from row to row and from pose to pose.
    let error = |pose: usize, joints: &[f64], row: usize| {
        let wobble = 2e-4 * (3.0 * joints[1]).sin();
        std::array::from_fn(|axis| wobble + 6e-5 * wave(7 * pose + axis) + 4e-5 * wave(900 + 5 * row + axis))
    };
    let (chain, data) = data(48, 1, &error);
    let fit = fitted(&chain, &data);
    (chain, data, fit)
}

/// Some candidates of all sorts.
fn candidates(chain: &Chain, data: &Dataset) -> Vec<Candidate> {
    let mut all = Library::standard().candidates(chain, data);
    let named = all.iter().filter(|c| c.family != Family::Unmodelled).cloned().collect::<Vec<_>>();
    all.retain(|candidate| candidate.family == Family::Unmodelled);
    named.into_iter().step_by(11).chain(all.into_iter().step_by(97)).collect()
}

#[track_caller]
fn close(a: f64, b: f64, tolerance: f64, what: &str) {
    assert!((a - b).abs() <= tolerance * (1.0 + b.abs()), "{what}: {a} and {b}");
}

#[track_caller]
fn same_score(fast: Option<&Score>, dense: &Dense, x: &DMatrix<f64>, absorbed: f64, what: &str) {
    let expected = dense.score(x, absorbed);
    assert_eq!(fast.map(|s| s.freedom), expected.as_ref().map(|s| s.freedom), "{what}");
    if let (Some(fast), Some(expected)) = (fast, expected) {
        close(fast.gain, expected.statistic, 1e-6, what);
        close(fast.share, expected.left, 1e-6, what);
        if expected.surprisal < 300.0 {
            close(fast.surprisal, expected.surprisal, 1e-5, what);
        }
    }
}

#[test]
fn scores_through_tables_are_those_of_whole_matrices() {
    let (chain, data, fit) = measured();
    let options = DiscoverOptions::default();
    let mut linearisation = Linearisation::new(&fit, &data, &options).unwrap();
    linearisation.noise = NOISE.into();
    let projection = Projection::new(&linearisation);
    let dense = Dense::new(&linearisation, NOISE);
    let how = options.policy.absorbed;
    let (mut absorbed, mut judged) = (0, 0);
    for candidate in candidates(&chain, &data) {
        let x = linearisation.columns_of(&candidate).unwrap();
        let score = projection.judge(&linearisation, &candidate);
        same_score(score.as_ref(), &dense, &x, how, &candidate.words());
        absorbed += usize::from(score.as_ref().is_none_or(|score| score.freedom < x.ncols()));
        judged += usize::from(score.is_some());
    }
    assert!(absorbed > 3 && judged > 30, "{absorbed} {judged}");
}

#[test]
fn scores_beside_further_columns_are_those_of_the_larger_model() {
    let (chain, data, fit) = measured();
    let options = DiscoverOptions::default();
    let mut linearisation = Linearisation::new(&fit, &data, &options).unwrap();
    linearisation.noise = NOISE.into();
    let projection = Projection::new(&linearisation);
    let more = DMatrix::from_fn(linearisation.len(), 3, |i, j| 1e-4 * wave(31 * i + j));
    let larger = projection.with(&more).expect("three directions");
    let dense = Dense::new(&linearisation, NOISE).with(&more);
    let how = options.policy.absorbed;
    for candidate in candidates(&chain, &data).into_iter().step_by(2) {
        let x = linearisation.columns_of(&candidate).unwrap();
        let score = larger.judge(&linearisation, &candidate);
        same_score(score.as_ref(), &dense, &x, how, &candidate.words());
    }
}

#[test]
fn likelihoods_folds_and_halves_are_those_of_whole_matrices() {
    let (chain, data, fit) = measured();
    let options = DiscoverOptions::default();
    // Once by classes of poses that are alike, once observation by observation.
    let mut uneven = data.clone();
    uneven
        .position_sd
        .iter_mut()
        .enumerate()
        .for_each(|(row, sd)| *sd = [1e-5 * (1.0 + 0.1 * row as f64); 3]);
    for (data, by_classes) in [(&data, true), (&uneven, false)] {
        let linearisation = Linearisation::new(&fit, data, &options).unwrap();
        assert_eq!(linearisation.normal().is_some(), by_classes);
        let (m, r, wide) = (linearisation.len(), linearisation.base.ncols(), options.policy.wide);
        let folds = Folds::new(data, &Split::Random { folds: 5, seed: 3 }).unwrap();
        let half: Vec<bool> = (0..48).map(|pose| wave(pose) > 0.0).collect();
        for candidate in candidates(&chain, data).into_iter().step_by(9) {
            let what = candidate.words();
            let x = linearisation.columns_of(&candidate).unwrap();
            let likelihood = Likelihood::new(&linearisation, &x, &Visits::of(data)).unwrap();
            let dense = Dense::new(&linearisation, likelihood.noise);
            let (solution, covariance, _) = dense.solve(&x, &vec![true; m], wide);
            close(likelihood.deviance, dense.deviance(&x, wide), 1e-8, &what);
            for k in 0..x.ncols() {
                let deviation = covariance[(r + k, r + k)].sqrt();
                close(likelihood.deviation(k) / deviation, 1.0, 1e-5, &what);
                close(likelihood.coefficients[k] / deviation, solution[r + k] / deviation, 1e-5, &what);
            }
            let held_out = likelihood.held_out(&linearisation, &folds, 2.0).unwrap();
            for fold in 0..folds.count {
                let used: Vec<bool> =
                    linearisation.observations.iter().map(|o| folds.of_visit[o.visit] != fold).collect();
                let expected = dense.residuals(&x, &dense.solve(&x, &used, 2.0).0);
                for at in (0..m).filter(|&at| !used[at]) {
                    close(held_out[at] / 1e-5, expected[at] / 1e-5, 1e-5, &what);
                }
            }
            let halves = likelihood.on_halves(&linearisation, &half, x.ncols()).unwrap();
            for (first, (value, spread)) in [true, false].into_iter().zip(halves) {
                let used: Vec<bool> =
                    linearisation.observations.iter().map(|o| half[o.visit] == first).collect();
                let (expected, covariance, _) = dense.solve(&x, &used, wide);
                for k in 0..x.ncols() {
                    let deviation = covariance[(r + k, r + k)].sqrt();
                    close(spread[(k, k)].sqrt() / deviation, 1.0, 1e-5, &what);
                    close(value[k] / deviation, expected[r + k] / deviation, 1e-4, &what);
                }
            }
        }
    }
}

#[test]
fn a_model_with_one_effect_in_place_of_another_is_that_of_whole_matrices() {
    let (chain, data, fit) = measured();
    let options = DiscoverOptions::default();
    let linearisation = Linearisation::new(&fit, &data, &options).unwrap();
    let usable: Vec<bool> = (0..data.len()).map(|row| row % 5 != 0).collect();
    // Rows of a pose are whitened together, so a pose is used as a whole or not at all.
    let usable: Vec<bool> =
        (0..data.len()).map(|row| usable[data.visit.partition_point(|&v| v < data.visit[row])]).collect();
    let linear = Linear::new(&linearisation, &usable);
    let used: Vec<bool> = linearisation.observations.iter().map(|o| usable[o.row]).collect();
    let model = fit.fitted.model();
    // The compliances go.
    let without = 1..2;
    let Some(reduced) = Linearisation::new(&fit, &data, &options).unwrap().muting(without.clone()) else {
        panic!("constant errors and compliances are not entangled");
    };
    assert!(reduced.base.ncols() < linearisation.base.ncols() && model.columns_of(1).len() > 1);
    let dense = Dense::new(&reduced, reduced.noise);
    for candidate in candidates(&chain, &data).into_iter().step_by(13) {
        let x = linearisation.columns_of(&candidate).unwrap();
        let (solution, ..) = dense.solve(&x, &used, options.policy.wide);
        let expected = dense.residuals(&x, &solution);
        let left = linear.left(std::slice::from_ref(&without), Some(&candidate)).unwrap();
        let mut squares = vec![0.0; data.len()];
        let positions =
            linearisation.observations.iter().zip(expected.iter()).filter(|(o, _)| o.component < 3);
        positions.for_each(|(o, e)| squares[o.row] += e * e);
        for (row, (left, expected)) in left.iter().zip(&squares).enumerate() {
            close(
                left.sqrt() / 1e-5,
                expected.sqrt() / 1e-5,
                1e-5,
                &format!("{} row {row}", candidate.words()),
            );
        }
    }
}

/// What a problem keeps of its columns: the Gram matrix of `[A | X | y]`, yᵀP y under its noise, and what a kilogram of payload does.
fn kept(problem: &Linearisation<'_>) -> Vec<f64> {
    let more = DMatrix::from_fn(problem.len(), 2, |i, j| 1e-4 * wave(31 * i + j));
    let normal = problem.normal().expect("few classes");
    let (gram, _) = normal.gram(NOISE, &normal.candidate_products(&more));
    let anchor = problem.kept::<Anchors>().at(problem, NOISE.into()).expect("a solution");
    let heavier = problem.heavier(5.0, None).unwrap();
    gram.iter().chain([&anchor.squares]).chain(heavier.iter()).copied().collect()
}

/// A problem whose columns have changed is the one that was never asked before: what it kept of the columns that it had is not used.
#[test]
fn nothing_that_was_kept_outlives_a_change_of_the_columns() {
    let (_, data, fit) = measured();
    let options = DiscoverOptions::default();
    let problem = || Linearisation::new(&fit, &data, &options).unwrap();
    let asked = || {
        let problem = problem();
        assert!(kept(&problem).iter().all(|v| v.is_finite()));
        problem
    };
    let muted =
        |problem: Linearisation<'_>| kept(&problem.muting(1..2).expect("compliances that stand alone"));
    let wandering = |mut problem: Linearisation<'_>| {
        let r = problem.base.ncols();
        let columns = DMatrix::from_fn(problem.len(), 3, |i, j| 1e-4 * wave(17 * i + j));
        problem.join_wander(&columns, DMatrix::identity(r + 3, r + 3));
        kept(&problem)
    };
    let same = |old: &[f64], new: &[f64]| {
        old.len() == new.len() && old.iter().zip(new).all(|(a, b)| a.to_bits() == b.to_bits())
    };
    assert!(same(&muted(asked()), &muted(problem())));
    assert!(same(&wandering(asked()), &wandering(problem())));
    // Without compliances a payload moves nothing.
    let (loads, count) = (muted(asked()), problem().len());
    assert!(loads[loads.len() - count..].iter().all(|v| v.abs() < f64::MIN_POSITIVE));
}
