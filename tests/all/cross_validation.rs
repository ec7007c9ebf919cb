//! Three ways of leaving a fold out, and deleting its rows by hand, give the same held-out residuals; folds never cut
//! what belongs together.

use crate::plants::{elastic, heavy_observation};
use nalgebra::{DMatrix, DVector, Vector3};
use truepose_errormodel::effects::Geometric;
use truepose_errormodel::{Dataset, ErrorModel, Visits, configurations};
use truepose_identify::engine::collect;
use truepose_identify::{
    CrossValidation, Fit, FitOptions, Folds, Method, NoiseSource, PriorStrength, Split, cross_validate, fit,
    hold_out,
};
use truepose_kinematics::{Axis, Chain};
use truepose_simulate::robots::heavy_plant;
use truepose_solvers::{Solver, SolverSpec};

fn qr() -> Box<dyn Solver> {
    "qr".parse::<SolverSpec>().unwrap().build()
}

fn heavy(postures: usize) -> (Chain, Dataset) {
    let plant = heavy_plant(9).unwrap();
    let data = heavy_observation(&plant, postures, 9).data;
    (plant.chain().clone(), data)
}

/// Translations alone: the position is exactly linear in them, so that re-linearising changes nothing and a refit is
/// the same linear problem without the fold's rows.
fn translations(chain: &Chain) -> ErrorModel {
    let effect = Geometric { frames: None, components: Some(Axis::TRANSLATIONS.to_vec()) };
    ErrorModel::new(chain.clone(), vec![Box::new(effect)]).unwrap()
}

fn plain(model: &ErrorModel, data: &Dataset) -> Fit {
    let options = FitOptions { prior: PriorStrength::None, ..FitOptions::default() };
    fit(model, data, &*qr(), &options).unwrap()
}

fn held_out(fit: &Fit, data: &Dataset, folds: &Folds, method: Method) -> CrossValidation {
    cross_validate(fit, data, folds, &*qr(), method).unwrap()
}

/// Largest difference of two sets of residuals, over the RMS of the first.
fn apart(a: &[Vector3<f64>], b: &[Vector3<f64>]) -> f64 {
    let rms = (a.iter().map(|v| v.norm_squared()).sum::<f64>() / a.len() as f64).sqrt();
    a.iter().zip(b).map(|(x, y)| (x - y).norm()).fold(0.0, f64::max) / rms
}

/// Held-out residuals by deleting rows from the whole whitened matrix and solving what is left by an SVD.
fn by_hand(fit: &Fit, data: &Dataset, folds: &Folds) -> Vec<Vector3<f64>> {
    let (model, at) = (fit.fitted.model(), fit.fitted.coefficients());
    let visits = Visits::of(data);
    let whole = collect(model, data, &visits, fit.noise, at).unwrap();
    let unit = truepose_identify::NoiseModel { position_sd: 1.0, visit_sd: 0.0, orientation_sd: 1.0 };
    let bare = Dataset { position_sd: vec![[f64::NAN; 3]; data.len()], ..data.clone() };
    let metres = collect(model, &bare, &visits, unit, at).unwrap();
    // Rows stand visit by visit, three for each of the data's rows.
    let order: Vec<usize> = visits.rows.concat();
    let scale: Vec<f64> = fit.reduction.kept.iter().map(|&c| model.columns()[c].scale).collect();
    let mut residuals = vec![Vector3::zeros(); data.len()];
    for fold in 0..folds.count {
        let stay: Vec<usize> =
            (0..whole.visit.len()).filter(|&k| folds.of_visit[whole.visit[k]] != fold).collect();
        let mut a: DMatrix<f64> = fit.reduction.select(&whole.a).select_rows(&stay);
        a.column_iter_mut().zip(&scale).for_each(|(mut column, s)| column.scale_mut(*s));
        let y = DVector::from_iterator(stay.len(), stay.iter().map(|&k| whole.residual[k]));
        let mut change = a.svd(true, true).solve(&y, 1e-14).unwrap();
        change.iter_mut().zip(&scale).for_each(|(c, s)| *c *= s);
        let moved = fit.reduction.select(&metres.a) * change;
        for (k, &row) in order.iter().enumerate() {
            if folds.of_visit[data.visit[row]] == fold {
                residuals[row] =
                    Vector3::from_fn(|axis, _| metres.residual[3 * k + axis] - moved[3 * k + axis]);
            }
        }
    }
    residuals
}

#[test]
fn every_method_leaves_out_the_same_on_a_linear_fit() {
    let (chain, data) = heavy(25);
    let found = plain(&translations(&chain), &data);
    assert!(found.converged);
    for split in [
        Split::Random { folds: 5, seed: 3 },
        Split::Random { folds: 23, seed: 3 },
        Split::JointBlocks { folds: 4, coordinate: None },
    ] {
        let folds = Folds::new(&data, &split).unwrap();
        let deleted = by_hand(&found, &data, &folds);
        for method in [Method::Block, Method::Merge, Method::Refit, Method::Auto] {
            let by = held_out(&found, &data, &folds, method);
            let relative = apart(&deleted, &by.residuals.position);
            println!("{split:?} {method:?}: {relative:.1e}");
            // Conditioning of the reduced problem is some hundreds, of its solution by a factor below 1e-12.
            assert!(relative < 1e-8, "{split:?}, {method:?}: {relative}");
            let expected = if method == Method::Refit { folds.count } else { 0 };
            assert_eq!(by.refitted, expected, "{split:?}, {method:?}");
        }
    }
}

#[test]
fn block_and_merge_agree_with_rotations_compliance_and_a_prior() {
    let (chain, data) = heavy(25);
    // With estimated noise the last weights are newer than the last step: both ways have to say the same all the same.
    let noise = NoiseSource::Estimate;
    let with = |prior| {
        let options = FitOptions { prior, noise, ..FitOptions::default() };
        fit(&elastic(&chain), &data, &*qr(), &options).unwrap()
    };
    let (with_prior, without) = (with(PriorStrength::Fixed(5.0)), with(PriorStrength::None));
    let folds = Folds::new(&data, &Split::Random { folds: 10, seed: 4 }).unwrap();
    for found in [&with_prior, &without] {
        let block = held_out(found, &data, &folds, Method::Block);
        let merge = held_out(found, &data, &folds, Method::Merge);
        let relative = apart(&block.residuals.position, &merge.residuals.position);
        println!("block against merge: {relative:.1e}");
        assert!(relative < 1e-8, "{relative}");
        assert!(apart(&found.residuals.position, &block.residuals.position) > 1e-3, "nothing was left out");
        // A refit moves to another point of linearisation. What that changes is of second order in the change of
        // the coefficients, some per cent of 0.5 mrad: far less than a thousandth of the residual.
        let refit = held_out(found, &data, &folds, Method::Refit);
        let relative = apart(&block.residuals.position, &refit.residuals.position);
        println!("refit against block: {relative:.1e}");
        assert!(relative < 1e-3, "{relative}");
    }
    let deleted = by_hand(&without, &data, &folds);
    let block = held_out(&without, &data, &folds, Method::Block);
    // By hand the residuals of a fold are those of the linear problem; the program predicts the fold exactly. They differ in second order, as above.
    let relative = apart(&deleted, &block.residuals.position);
    assert!(relative < 1e-3, "{relative}");
}

#[test]
fn leaving_out_costs_something() {
    let (chain, data) = heavy(25);
    let found = plain(&elastic(&chain), &data);
    let folds = Folds::new(&data, &Split::LeaveOneOut).unwrap();
    assert_eq!(folds.count, 50, "25 postures, empty and loaded; repeats are one configuration");
    let loo = held_out(&found, &data, &folds, Method::Auto);
    assert!(loo.residuals.positions().rms > found.residuals.positions().rms);
    assert_eq!(loo.fold_rms.len(), 50);
}

#[test]
fn folds_never_part_repeats_nor_cut_visits() {
    let (_, data) = heavy(20);
    let configuration = configurations(&data);
    assert_eq!(configuration.len(), 80, "20 postures, two loads, twice");
    let count = configuration.iter().max().unwrap() + 1;
    assert_eq!(count, 40);
    for split in [
        Split::Random { folds: 7, seed: 1 },
        Split::Random { folds: 7, seed: 2 },
        Split::LeaveOneOut,
        Split::TimeBlocks { folds: 6 },
        Split::JointBlocks { folds: 5, coordinate: None },
        Split::JointBlocks { folds: 5, coordinate: Some(2) },
    ] {
        let folds = Folds::new(&data, &split).unwrap();
        assert_eq!(folds.of_visit.len(), configuration.len());
        let mut fold_of = vec![None; count];
        for (visit, &fold) in folds.of_visit.iter().enumerate() {
            let first = *fold_of[configuration[visit]].get_or_insert(fold);
            assert_eq!(first, fold, "{split:?} parts the repeats of visit {visit}");
        }
        let mut sizes = vec![0; folds.count];
        fold_of.iter().flatten().for_each(|&fold: &usize| sizes[fold] += 1);
        let (least, most) = (sizes.iter().min().unwrap(), sizes.iter().max().unwrap());
        assert!(*least > 0 && most - least <= 1, "{split:?}: {sizes:?}");
        let listed: usize = (0..folds.count).map(|fold| folds.members(fold).len()).sum();
        assert_eq!(listed, folds.of_visit.len());
    }
    let shuffled = |seed| Folds::new(&data, &Split::Random { folds: 7, seed }).unwrap().of_visit;
    assert_eq!(shuffled(1), shuffled(1));
    assert_ne!(shuffled(1), shuffled(2));
    assert!(Folds::new(&data, &Split::Random { folds: 41, seed: 1 }).is_err());
}

#[test]
fn time_blocks_are_contiguous() {
    let (_, mut data) = heavy(20);
    let configuration = configurations(&data);
    let blocks = |data: &Dataset| {
        let folds = Folds::new(data, &Split::TimeBlocks { folds: 6 }).unwrap();
        let visits = Visits::of(data);
        // Configurations by the time at which they were first seen.
        let mut first: Vec<(f64, usize)> = Vec::new();
        for (visit, rows) in visits.rows.iter().enumerate() {
            if !configuration[..visit].contains(&configuration[visit]) {
                first.push((data.time[rows[0]], folds.of_visit[visit]));
            }
        }
        first.sort_by(|a, b| a.0.total_cmp(&b.0));
        first.into_iter().map(|(_, fold)| fold).collect::<Vec<usize>>()
    };
    let forward = blocks(&data);
    assert!(forward.is_sorted() && forward[0] == 0 && forward[39] == 5, "{forward:?}");
    // The clock and not the order of the rows decides: with the clock running backwards, so do the folds.
    data.time.iter_mut().for_each(|t| *t = 1e6 - *t);
    let backward = blocks(&data);
    assert!(backward.is_sorted(), "{backward:?}");
    assert_ne!(
        Folds::new(&data, &Split::TimeBlocks { folds: 6 }).unwrap().of_visit[0],
        0,
        "the first visit is now the last in time"
    );
    data.schema.time = false;
    assert_eq!(Folds::new(&data, &Split::TimeBlocks { folds: 6 }).unwrap().of_visit[0], 0);
}

#[test]
fn what_is_held_out_shares_no_configuration_with_the_rest() {
    let (_, data) = heavy(20);
    let configuration = configurations(&data);
    for seed in 0..5 {
        let (train, held) = hold_out(&data, 0.3, seed).unwrap();
        assert_eq!(train.len() + held.len(), data.len());
        let of = |rows: &[usize]| -> std::collections::BTreeSet<usize> {
            rows.iter().map(|&row| configuration[data.visit[row]]).collect()
        };
        assert!(of(&train).is_disjoint(&of(&held)), "seed {seed}");
        assert_eq!(of(&held).len(), 12, "30 % of 40 configurations");
    }
}
