//! The scatter of the joints against whole matrices, and on simulated residuals.

use crate::hypotheses::library::Library;
use crate::options::DiscoverOptions;
use crate::problem::dense::Dense;
use crate::problem::joint_noise::{BesideJoints, joint_repeatability};
use crate::problem::likelihood::Likelihood;
use crate::problem::linearisation::Linearisation;
use crate::problem::noise::{JointNoise, Noise};
use crate::problem::projection::Projection;
use crate::problem::restricted::Restricted;
use crate::problem::synthetic::{data, fitted, normal, wave};
use crate::problem::variance::Component;
use nalgebra::{DMatrix, DVector};
use truepose_errormodel::{Dataset, Visits};
use truepose_identify::{Fit, NoiseModel};
use truepose_kinematics::{Chain, rotation_log};

const ROWS: NoiseModel = NoiseModel { position_sd: 2e-5, visit_sd: 1e-5, orientation_sd: 4e-5 };
const NOISE: Noise = Noise { rows: ROWS, joints: JointNoise { turning: 3e-5, sliding: 0.0 } };

fn measured(poses: usize) -> (Chain, Dataset, Fit) {
    let error = |pose: usize, _: &[f64], row: usize| {
        std::array::from_fn(|axis| 6e-5 * wave(7 * pose + axis) + 4e-5 * wave(900 + 5 * row + axis))
    };
    let (chain, data) = data(poses, 2, &error);
    let fit = fitted(&chain, &data);
    (chain, data, fit)
}

/// Residuals of rows, poses and joints that scatter by this noise.
fn scattering(linearisation: &Linearisation<'_>, trial: usize, noise: Noise) -> DVector<f64> {
    let moved = linearisation.levers().scaled(noise.joints);
    let of_joint = |visit: usize, k: usize| normal(3_000_000 + 20_000 * trial + 8 * visit + k);
    DVector::from_fn(linearisation.len(), |at, _| {
        let o = linearisation.observations[at];
        let joints: f64 = (0..moved.ncols()).map(|k| moved[(at, k)] * of_joint(o.visit, k)).sum();
        let rows = match o.component {
            0..3 => {
                let shared = normal(1_000_000 + 20_000 * trial + 3 * o.visit + o.component);
                noise.rows.position(2e-5) * normal(20_000 * trial + at) + noise.rows.visit_sd * shared
            }
            _ => noise.rows.orientation(f64::NAN) * normal(20_000 * trial + at),
        };
        rows + joints
    })
}

#[test]
fn levers_are_what_a_moved_joint_does_to_predictions() {
    let (_, data, fit) = measured(20);
    let options = DiscoverOptions::default();
    let linearisation = Linearisation::new(&fit, &data, &options).unwrap();
    let mut predictor = fit.fitted.bind(&data.schema).unwrap();
    let columns = &linearisation.levers().columns;
    const STEP: f64 = 1e-6;
    for (at, o) in linearisation.observations.iter().enumerate() {
        for joint in 0..6 {
            let conditions = data.conditions(o.row);
            let mut moved = conditions.clone();
            moved.joints[joint] += STEP;
            let [before, after] = [&conditions, &moved].map(|c| predictor.predict(c, None));
            let expected = match o.component {
                0..3 => (after.translation - before.translation)[o.component] / STEP,
                _ => rotation_log(&(after.rotation * before.rotation.transpose()))[o.component - 3] / STEP,
            };
            // The errors of the model change with the joints, too: by a thousandth.
            assert!((columns[(at, joint)] - expected).abs() < 3e-3, "{at} {joint} {expected}");
        }
    }
}

#[test]
fn whitening_beside_joints_is_that_of_the_whole_covariance() {
    let (_, data, fit) = measured(24);
    let options = DiscoverOptions::default();
    let linearisation = Linearisation::new(&fit, &data, &options).unwrap();
    for noise in [NOISE, Noise { joints: JointNoise { turning: 1e-2, sliding: 0.0 }, ..NOISE }] {
        let m = linearisation.len();
        let whitener = linearisation.whitener(noise);
        let dense = Dense::new(&linearisation, noise);
        let inverse = dense.covariance().cholesky().unwrap().inverse();
        let white = whitener.of(&DMatrix::identity(m, m));
        let product = white.transpose() * &white;
        let scale: Vec<f64> = inverse.diagonal().iter().map(|d| d.sqrt()).collect();
        for i in 0..m {
            for j in 0..m {
                let apart = (product[(i, j)] - inverse[(i, j)]) / (scale[i] * scale[j]);
                assert!(apart.abs() < 1e-8, "{i} {j} {apart}");
            }
        }
        let mut transposed = DMatrix::identity(m, m);
        whitener.apply_transposed(&mut transposed);
        assert!((transposed.transpose() - &white).amax() < 1e-9 * white.amax());
        for (own, expected) in whitener.precisions(m).iter().zip(inverse.diagonal().iter()) {
            assert!((own / expected - 1.0).abs() < 1e-8);
        }
        assert!((whitener.log_determinant() - dense.log_determinant()).abs() < 1e-7 * m as f64);
    }
}

#[test]
fn scores_and_likelihoods_beside_joints_are_those_of_whole_matrices() {
    let (chain, data, fit) = measured(40);
    let options = DiscoverOptions::default();
    let mut linearisation = Linearisation::new(&fit, &data, &options).unwrap();
    linearisation.noise = NOISE;
    let projection = Projection::new(&linearisation);
    let dense = Dense::new(&linearisation, NOISE);
    let all = Library::standard().candidates(&chain, &data);
    let mut judged = 0;
    for candidate in all.iter().step_by(67) {
        let x = linearisation.columns_of(candidate).unwrap();
        let score = projection.judge(&linearisation, candidate);
        let expected = dense.score(&x, options.policy.absorbed);
        assert_eq!(score.as_ref().map(|s| s.freedom), expected.as_ref().map(|s| s.freedom));
        if let (Some(score), Some(expected)) = (score, expected) {
            assert!((score.gain - expected.statistic).abs() < 1e-6 * (1.0 + expected.statistic));
            judged += 1;
        }
    }
    assert!(judged > 10, "{judged}");
    for candidate in all.iter().step_by(307) {
        let x = linearisation.columns_of(candidate).unwrap();
        let likelihood = Likelihood::new(&linearisation, &x, &Visits::of(&data)).unwrap();
        let expected = Dense::new(&linearisation, likelihood.noise).deviance(&x, options.policy.wide);
        assert!((likelihood.deviance - expected).abs() < 1e-7 * expected.abs(), "{}", candidate.words());
    }
}

#[test]
fn score_and_information_of_the_components_are_those_of_whole_matrices() {
    let (_, data, fit) = measured(24);
    let options = DiscoverOptions::default();
    let mut linearisation = Linearisation::new(&fit, &data, &options).unwrap();
    linearisation.y = scattering(&linearisation, 1, NOISE);
    let m = linearisation.len();
    let extra = DMatrix::from_fn(m, 2, |i, j| 1e-4 * wave(31 * i + j));
    let r = linearisation.base.ncols();
    let prior = linearisation.prior_precision().clone().resize(r + 2, r + 2, 0.0);
    for integrated in [r + 2, r] {
        let restricted = Restricted::new(&linearisation, &extra, 0.0);
        let restricted = if integrated == r { restricted.beside() } else { restricted };
        let found = restricted.derivatives_at(NOISE).unwrap();
        let mut columns = linearisation.base.clone().resize_horizontally(r + 2, 0.0);
        columns.columns_mut(r, 2).copy_from(&extra);
        // P of the first columns of A, with their prior.
        let inverse = Dense::new(&linearisation, NOISE).covariance().cholesky().unwrap().inverse();
        let projector = |n: usize| {
            let a = columns.columns(0, n).into_owned();
            let normal = a.transpose() * &inverse * &a + prior.view((0, 0), (n, n));
            let solved = normal.lu().solve(&(a.transpose() * &inverse)).unwrap();
            &inverse - &inverse * &a * solved
        };
        let (of_trace, whole) = (projector(integrated), projector(r + 2));
        let o = &linearisation.observations;
        let part = |component: Component| {
            let levers = &linearisation.levers().columns;
            DMatrix::from_fn(m, m, |i, j| match component {
                Component::Rows => f64::from(u8::from(i == j && o[i].component < 3)),
                Component::Turns => f64::from(u8::from(i == j && o[i].component > 2)),
                Component::Poses => {
                    let same = (o[i].visit, o[i].component) == (o[j].visit, o[j].component);
                    f64::from(u8::from(same && o[i].component < 3))
                }
                _ if o[i].visit == o[j].visit => levers.row(i).dot(&levers.row(j)),
                _ => 0.0,
            })
        };
        assert_eq!(
            found.components,
            [Component::Rows, Component::Poses, Component::Turns, Component::Turning]
        );
        let weighed = &whole * &linearisation.y;
        let parts: Vec<_> = found.components.iter().map(|component| part(*component)).collect();
        for (i, first) in parts.iter().enumerate() {
            let through = first * &weighed;
            let trace = (&of_trace * first).trace();
            let expected = 0.5 * (weighed.dot(&through) - trace);
            assert!((found.score[i] - expected).abs() < 1e-5 * trace, "{i} {} {expected}", found.score[i]);
            for (j, second) in parts.iter().enumerate() {
                let expected = 0.5 * through.dot(&(&whole * (second * &weighed)));
                let size = (found.information[(i, i)] * found.information[(j, j)]).sqrt();
                assert!((found.information[(i, j)] - expected).abs() < 1e-5 * size, "{i} {j}");
            }
        }
    }
}

#[test]
fn the_grid_has_a_noise_near_the_best_for_every_candidate() {
    let (chain, data, fit) = measured(60);
    let options = DiscoverOptions::default();
    let mut linearisation = Linearisation::new(&fit, &data, &options).unwrap();
    linearisation.y = scattering(&linearisation, 3, NOISE);
    // The start has half as much again as is there.
    linearisation.noise = Noise {
        rows: NoiseModel { position_sd: 3e-5, visit_sd: 1.5e-5, ..ROWS },
        joints: JointNoise { turning: 4.5e-5, sliding: 0.0 },
    };
    let all = Library::standard().candidates(&chain, &data);
    let mut noises = Vec::new();
    for candidate in all.iter().step_by(211) {
        let x = linearisation.columns_of(candidate).unwrap();
        let restricted = Restricted::new(&linearisation, &x, 1e-4);
        let best = restricted.fitted(linearisation.noise, true).unwrap();
        let near = restricted.on_grid().unwrap();
        let behind = near.restricted - best.restricted;
        assert!((-0.05..0.25).contains(&behind), "{}: {behind}", candidate.words());
        noises.push(near.noise());
    }
    let count = noises.len();
    noises.sort_by(|a, b| a.joints.turning.total_cmp(&b.joints.turning));
    noises.dedup_by(|a, b| a.joints == b.joints);
    assert!(count > 20 && 3 * noises.len() < count, "{count} candidates meet at {} noises", noises.len());
}

#[test]
fn joints_that_scatter_are_found_and_noise_that_is_the_same_everywhere_is_none() {
    let (_, data, fit) = measured(60);
    let options = DiscoverOptions::default();
    let mut linearisation = Linearisation::new(&fit, &data, &options).unwrap();
    linearisation.noise.rows = ROWS;
    let mut sum = 0.0;
    const TRIALS: usize = 12;
    for trial in 0..TRIALS {
        linearisation.y = scattering(&linearisation, trial, NOISE);
        let found = joint_repeatability(&linearisation).expect("joints that scatter");
        assert!(found.p_value <= options.policy.joint_noise_level && found.at_tool > 0.0);
        sum += (found.joints.turning / NOISE.joints.turning).powi(2) / TRIALS as f64;
    }
    assert!((sum - 1.0).abs() < 0.1, "{sum}");
    let same = Noise { joints: JointNoise::default(), rows: NoiseModel { visit_sd: 4e-5, ..ROWS } };
    let several = (0..40).filter(|&trial| {
        linearisation.y = scattering(&linearisation, 100 + trial, same);
        joint_repeatability(&linearisation).is_some()
    });
    assert!(several.count() <= 1);
}

#[test]
fn an_effect_of_a_joint_stays_significant_beside_the_scatter_of_joints_and_what_they_imitate_does_not() {
    let (_, data, fit) = measured(60);
    let options = DiscoverOptions::default();
    let mut linearisation = Linearisation::new(&fit, &data, &options).unwrap();
    linearisation.noise.rows = ROWS;
    // The second joint errs by a wave of its own value, and by less than the joints scatter.
    let lever = linearisation.levers().columns.column(1).into_owned();
    let value = |at: usize| data.joints[1][linearisation.observations[at].row];
    let effect = DVector::from_fn(lever.len(), |at, _| lever[at] * (5.0 * value(at)).sin());
    let column = DMatrix::from_column_slice(effect.len(), 1, effect.as_slice());
    for trial in 0..5 {
        let noise = scattering(&linearisation, 200 + trial, NOISE);
        let p = |y: DVector<f64>, linearisation: &mut Linearisation<'_>| {
            linearisation.y = y;
            BesideJoints::of(linearisation).p_value(&column, 1)
        };
        let with = p(&noise + &effect * 6e-5, &mut linearisation).expect("joints that scatter");
        let without = p(noise, &mut linearisation).expect("joints that scatter");
        assert!(with < 1e-3 && without > 0.5, "{with} {without}");
    }
}

#[test]
fn weighed_residuals_scatter_alike_in_all_poses() {
    let (_, data, fit) = measured(60);
    let options = DiscoverOptions::default();
    let mut linearisation = Linearisation::new(&fit, &data, &options).unwrap();
    linearisation.noise.rows = ROWS;
    linearisation.y = scattering(&linearisation, 7, NOISE);
    let found = joint_repeatability(&linearisation).expect("joints that scatter");
    let weights = found.weights(&linearisation);
    let sd = linearisation.deviations(Noise { rows: found.rows, joints: found.joints });
    let mut each = vec![(0.0, 0.0); linearisation.visits];
    let (mut plain, mut count) = (0.0, 0.0);
    for ((o, sd), k) in
        linearisation.observations.iter().zip(&sd).zip(0..).filter(|((o, _), _)| o.component < 3)
    {
        let _: usize = k;
        each[o.visit].0 += (weights[o.row] * sd).powi(2);
        each[o.visit].1 += 1.0;
        (plain, count) = (plain + sd * sd, count + 1.0);
    }
    for (sum, own) in each {
        assert!((sum / own / (plain / count) - 1.0).abs() < 1e-9);
    }
}
