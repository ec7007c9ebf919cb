//! The p-value of the resampling test where nothing is missing, and where something is.

use crate::hypotheses::library::Library;
use crate::options::DiscoverOptions;
use crate::problem::linearisation::Linearisation;
use crate::problem::projection::{Projection, Score};
use crate::problem::synthetic::{data, fitted, normal};
use crate::significance::sign_flips::{Block, NullDistribution};
use crate::statistics::surprisal::Surprisal;
use nalgebra::{DMatrix, DVector};
use truepose_identify::NoiseModel;

/// Sign flips of a test.
const FLIPS: usize = 99;

/// p of the largest of some statistics, for observations with this noise and signal.
fn p_value(scores: &[Score], projection: &Projection, seed: u64) -> f64 {
    let block = |score: &Score| Block {
        by_unit: score.by_unit.clone(),
        each: vec![(score.freedom, score.distribution)],
    };
    let blocks: Vec<Block> = scores.iter().map(block).collect();
    let null = NullDistribution::new(projection, &blocks, FLIPS, seed);
    null.p_value(scores.iter().map(|score| score.surprisal).fold(Surprisal::NONE, Surprisal::max))
}

#[test]
fn p_is_uniform_where_nothing_is_missing_and_small_where_something_is() {
    // Many poses for the unknowns of the model: with 60 poses for some fifty unknowns p comes out somewhat too small (median 0.40).
    let (chain, data) = data(200, 4, &|_, _, _| [0.0; 3]);
    let fit = fitted(&chain, &data);
    let options = DiscoverOptions::default();
    let mut linearisation = Linearisation::new(&fit, &data, &options).unwrap();
    linearisation.noise = NoiseModel { position_sd: 3e-5, visit_sd: 5e-5, orientation_sd: 2e-4 };
    let noise = linearisation.noise;
    let all = Library::standard().candidates(&chain, &data);
    let candidates: Vec<_> = all.into_iter().step_by(211).collect();
    let observations = linearisation.observations.clone();
    let of = |trial: usize| {
        DVector::from_fn(observations.len(), |at, _| {
            let o = observations[at];
            match o.component {
                0..3 => {
                    let shared = normal(1_000_000 + 2000 * trial + 3 * o.visit + o.component);
                    noise.position(2e-5) * normal(2000 * trial + at) + noise.visit_sd * shared
                }
                _ => noise.orientation(f64::NAN) * normal(2000 * trial + at),
            }
        })
    };
    let mut p = |y: DVector<f64>, seed: u64| {
        linearisation.y = y;
        let projection = Projection::new(&linearisation);
        let scores: Vec<Score> =
            candidates.iter().filter_map(|c| projection.judge(&linearisation, c)).collect();
        assert!(scores.len() > 10);
        p_value(&scores, &projection, seed)
    };
    let trials = 100;
    let mut values: Vec<f64> = (0..trials).map(|trial| p(of(trial), trial as u64)).collect();
    values.sort_by(f64::total_cmp);
    let count = trials as f64;
    let distance = values
        .iter()
        .enumerate()
        .map(|(k, &value)| (value - k as f64 / count).abs().max((value - (k as f64 + 1.0) / count).abs()));
    // Kolmogorov: P(D > x) ≤ 2 exp(−2 n x²) is 1 % here; p has steps of 1/(B + 1).
    let critical = (200f64.ln() / (2.0 * count)).sqrt() + 1.0 / (FLIPS + 1) as f64;
    let distance = distance.fold(0.0, f64::max);
    assert!(distance < critical, "{distance} {critical}");

    // Where a candidate's own columns are added at ten standard deviations of the noise, no flip is as extreme.
    let x: DMatrix<f64> =
        Linearisation::new(&fit, &data, &options).unwrap().columns_of(&candidates[8]).unwrap();
    let signal = x.column(0) * (2e-3 / x.column(0).amax());
    assert!(p(of(0) + signal, 1) <= 2.0 / (FLIPS + 1) as f64);
}
