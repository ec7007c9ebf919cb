//! The wander against whole matrices, and what it does to the search where poses depend on each other and where they do not.

use crate::options::DiscoverOptions;
use crate::problem::dependence::{BesideWander, dependence};
use crate::problem::linearisation::Linearisation;
use crate::problem::sequence::{Ordered, Process, Sequence};
use crate::problem::synthetic::{data, fitted, normal};
use crate::problem::wander::Wander;
use nalgebra::{DMatrix, DVector};
use truepose_errormodel::Dataset;
use truepose_identify::{Fit, NoiseModel};

const POSES: usize = 120;
const NOISE: NoiseModel = NoiseModel { position_sd: 2e-5, visit_sd: 3e-5, orientation_sd: 2e-4 };

fn measured() -> (Dataset, Fit) {
    let (chain, data) = data(POSES, 3, &|_, _, _| [0.0; 3]);
    let fit = fitted(&chain, &data);
    (data, fit)
}

/// Observations of a model that lacks nothing: noise, and a wander of each axis with this standard deviation and correlation of neighbours.
fn wandering(linearisation: &Linearisation<'_>, trial: usize, sd: f64, phi: f64) -> DVector<f64> {
    let axis = |axis: usize| {
        let mut w = vec![normal(9_000_000 + 10_000 * trial + axis)];
        for pose in 1..POSES {
            let new = (1.0 - phi * phi).sqrt() * normal(9_000_000 + 10_000 * trial + 3 * pose + axis);
            w.push(phi * w[pose - 1] + new);
        }
        w
    };
    let w = [axis(0), axis(1), axis(2)];
    DVector::from_fn(linearisation.len(), |at, _| {
        let o = linearisation.observations[at];
        if o.component > 2 {
            return NOISE.orientation(f64::NAN) * normal(5000 * trial + at);
        }
        let shared = normal(1_000_000 + 5000 * trial + 3 * o.visit + o.component);
        NOISE.position(2e-5) * normal(5000 * trial + at)
            + NOISE.visit_sd * shared
            + sd * w[o.component][o.visit]
    })
}

#[test]
fn the_filter_has_the_likelihood_of_the_whole_covariance() {
    let (data, fit) = measured();
    let options = DiscoverOptions::default();
    let mut linearisation = Linearisation::new(&fit, &data, &options).unwrap();
    linearisation.noise = NOISE.into();
    linearisation.y = wandering(&linearisation, 1, 5e-5, 0.6);
    let whitener = linearisation.whitener(NOISE);
    let sequence = Sequence::of(&linearisation, &whitener).unwrap();
    let (m, r) = linearisation.base.shape();
    let mut all = linearisation.base.clone().resize_horizontally(r + 1, 0.0);
    all.column_mut(r).copy_from(&linearisation.y);
    let ordered = Ordered::new(&sequence, &whitener.of(&all), r, linearisation.prior.as_ref());
    let o = &linearisation.observations;
    let prior = linearisation.prior.clone().unwrap();
    let dense = |of: Process| {
        let covariance = DMatrix::from_fn(m, m, |i, j| {
            let mut value = 0.0;
            if i == j {
                value += if o[i].component < 3 { NOISE.position(2e-5) } else { NOISE.orientation(f64::NAN) }
                    .powi(2);
            }
            if o[i].component == o[j].component && o[i].component < 3 {
                let apart = o[i].visit.abs_diff(o[j].visit) as f64;
                value += of.wander * sequence.typical * (-apart / of.time).exp();
                if apart == 0.0 {
                    // What of v is white, on top of what differs within the pose.
                    let rows = if o[i].visit.is_multiple_of(4) { 3.0 } else { 1.0 };
                    let within = NOISE.position(2e-5).powi(2) / rows;
                    value += of.white * (NOISE.visit_sd.powi(2) + within) - within;
                }
            }
            value
        });
        let factor = covariance.clone().cholesky().unwrap();
        let white = |x: &DMatrix<f64>| factor.l().solve_lower_triangular(x).unwrap();
        let (a, y) = (white(&linearisation.base), white(&all.columns(r, 1).into_owned()));
        let normal = a.transpose() * &a + prior.transpose() * &prior;
        let along = a.transpose() * &y;
        let squares = y.norm_squared() - along.dot(&normal.clone().cholesky().unwrap().solve(&along));
        let log = 2.0 * factor.l().diagonal().iter().map(|d| d.ln()).sum::<f64>();
        log + 2.0 * normal.cholesky().unwrap().l().diagonal().iter().map(|d| d.ln()).sum::<f64>() + squares
    };
    let some = [
        Process { white: 1.0, wander: 0.0, time: 1.0 },
        Process { white: 0.7, wander: 1.3, time: 2.0 },
        Process { white: 0.9, wander: 0.4, time: 20.0 },
    ];
    let differ = |f: &dyn Fn(Process) -> f64| [f(some[1]) - f(some[0]), f(some[2]) - f(some[0])];
    let (filter, whole) = (differ(&|p| ordered.deviance(p)), differ(&dense));
    assert!((filter[0] - whole[0]).abs() < 1e-5 * whole[0].abs(), "{filter:?} {whole:?}");
    assert!((filter[1] - whole[1]).abs() < 1e-5 * whole[1].abs(), "{filter:?} {whole:?}");
}

#[test]
fn cosines_and_what_is_left_white_make_the_covariance_of_the_process() {
    let (data, fit) = measured();
    let options = DiscoverOptions::default();
    let linearisation = Linearisation::new(&fit, &data, &options).unwrap();
    let r = linearisation.base.ncols();
    let sequence = Sequence::of(&linearisation, &linearisation.whitener(NOISE)).unwrap();
    for time in [2.0, 12.0] {
        let process = Process { white: 0.2, wander: 4.0, time };
        let typical = sequence.typical;
        let joined = Wander { sequence: sequence.clone(), process }
            .joined(Linearisation::new(&fit, &data, &options).unwrap());
        let columns = joined.base.columns(r, joined.base.ncols() - r);
        let prior = joined.prior.as_ref().unwrap();
        assert_eq!(prior.shape(), (joined.base.ncols(), joined.base.ncols()));
        let at = |visit: usize| {
            joined.observations.iter().position(|o| o.visit == visit && o.component == 1).unwrap()
        };
        for (first, second) in [(40, 41), (40, 44), (3, 7), (60, 90), (0, 119)] {
            let made = columns.row(at(first)).dot(&columns.row(at(second))) / typical;
            let exact = process.wander * (-(second as f64 - first as f64) / time).exp();
            assert!((made - exact).abs() < 0.04 * process.wander, "{time} {first} {second}: {made} {exact}");
        }
        // Axes wander by themselves.
        let other = joined.observations.iter().position(|o| o.visit == 40 && o.component == 2).unwrap();
        assert!(columns.row(at(40)).dot(&columns.row(other)).abs() < 1e-20);
    }
}

#[test]
fn p_of_independent_poses_is_uniform_and_such_data_has_no_wander() {
    let (data, fit) = measured();
    let options = DiscoverOptions::default();
    let (trials, mut below) = (60, [0; 2]);
    for trial in 0..trials {
        let mut linearisation = Linearisation::new(&fit, &data, &options).unwrap();
        linearisation.noise = NOISE.into();
        linearisation.y = wandering(&linearisation, trial, 0.0, 0.0);
        let found = dependence(&linearisation, options.seed).unwrap();
        below[0] += usize::from(found.p_value < 0.05);
        below[1] += usize::from(found.p_value < 0.01);
        assert!(found.autocorrelation.abs() < 0.25 && found.autocorrelation.is_finite());
        if found.p_value > 0.01 {
            assert_eq!((found.wander, found.time_constant), (None, None));
            let columns = linearisation.base.ncols();
            assert_eq!(linearisation.beside_wander(options.seed).base.ncols(), columns);
        }
    }
    // 60 draws: more than nine below 0.05, or more than three below 0.01, has a chance of 1e-3.
    assert!(below[0] <= 9 && below[1] <= 3, "{below:?}");
}

#[test]
fn a_wander_is_found_with_its_size_and_no_slow_function_is_significant_beside_it() {
    let (data, fit) = measured();
    let options = DiscoverOptions::default();
    let (trials, mut found, mut squares, mut plain) = (12, 0, 0.0, 0.0);
    let slow = |linearisation: &Linearisation<'_>, k: usize| {
        DMatrix::from_fn(linearisation.len(), 1, |at, _| {
            let o = linearisation.observations[at];
            f64::from(u8::from(o.component == k % 3)) * (0.1 * (k + 1) as f64 * o.visit as f64).sin()
        })
    };
    let mut sizes = Vec::new();
    for trial in 0..trials {
        let mut linearisation = Linearisation::new(&fit, &data, &options).unwrap();
        linearisation.noise = NOISE.into();
        linearisation.y = wandering(&linearisation, trial, 8e-5, 0.8);
        let says = dependence(&linearisation, options.seed).unwrap();
        let Some(size) = says.wander else { continue };
        found += 1;
        sizes.push(size);
        let score = |linearisation: &Linearisation<'_>| -> f64 {
            let projection = crate::problem::projection::Projection::new(linearisation);
            let one = |k: usize| {
                // A function that the wander takes up whole explains nothing more.
                projection.with(&slow(linearisation, k)).map_or(0.0, |larger| projection.rss - larger.rss)
            };
            (0..6).map(one).sum::<f64>() / 6.0
        };
        plain += score(&linearisation);
        squares += score(&linearisation.beside_wander(options.seed));
    }
    assert!(found >= 11, "{found}");
    sizes.sort_by(f64::total_cmp);
    let (median, truth) = (sizes[sizes.len() / 2], 3f64.sqrt() * 8e-5);
    assert!((median / truth - 1.0).abs() < 0.35, "{median} {truth}");
    // One unknown each: χ²_1 on average, where independent poses would be many times surprised.
    let (with, without) = (squares / f64::from(found), plain / f64::from(found));
    assert!(with < 1.6 && without > 3.0, "{with} {without}");
}

#[test]
fn a_drift_is_significant_beside_a_wander_and_what_only_follows_a_wander_is_not() {
    let (data, fit) = measured();
    let options = DiscoverOptions::default();
    let (mut drifts, mut false_ones, mut dependent) = (0, 0, 0);
    for trial in 0..8 {
        let mut linearisation = Linearisation::new(&fit, &data, &options).unwrap();
        linearisation.noise = NOISE.into();
        let drift = DMatrix::from_fn(linearisation.len(), 1, |at, _| {
            let o = linearisation.observations[at];
            f64::from(u8::from(o.component == 2)) * (o.visit as f64 / POSES as f64 - 0.5)
        });
        linearisation.y = wandering(&linearisation, trial, 0.0, 0.0) + 4e-4 * drift.column(0);
        let p = BesideWander::of(&linearisation, 0)
            .p_value(&drift, 1)
            .expect("a drift makes poses depend on each other");
        drifts += usize::from(p <= options.alpha);
        linearisation.y = wandering(&linearisation, trial, 8e-5, 0.8);
        // The steps of a sweep: slow in the order of the poses, and chosen to follow the wander.
        let follows = DMatrix::from_fn(linearisation.len(), 1, |at, _| {
            let o = linearisation.observations[at];
            f64::from(u8::from(o.component == 0)) * (0.15 * o.visit as f64 + trial as f64).sin()
        });
        if let Some(p) = BesideWander::of(&linearisation, 0).p_value(&follows, 1) {
            dependent += 1;
            false_ones += usize::from(p <= options.alpha);
        }
    }
    assert!(drifts >= 7 && dependent >= 7 && false_ones == 0, "{drifts} {dependent} {false_ones}");
}
