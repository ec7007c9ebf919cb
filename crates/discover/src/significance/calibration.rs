//! The p-value of the rotation test where nothing is missing, and where something is.

use crate::hypotheses::library::Library;
use crate::options::DiscoverOptions;
use crate::problem::linearisation::Linearisation;
use crate::problem::projection::{Projection, Score};
use crate::problem::synthetic::{data, fitted, normal};
use crate::significance::rotation::{NullDistribution, Rotations};
use nalgebra::{DMatrix, DVector};
use truepose_identify::NoiseModel;

/// Random rotations of a test.
const ROTATIONS: usize = 199;

/// Distance of Kolmogorov of values from a uniform distribution on [0, 1].
fn distance(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    let count = values.len() as f64;
    let both = values
        .iter()
        .enumerate()
        .map(|(k, &value)| (value - k as f64 / count).abs().max((value - (k as f64 + 1.0) / count).abs()));
    both.fold(0.0, f64::max)
}

/// P(D > critical) is 1 % (Kolmogorov: P(D > x) ≤ 2 exp(−2 n x²)).
fn critical(count: usize) -> f64 {
    (200f64.ln() / (2.0 * count as f64)).sqrt()
}

#[test]
fn p_is_uniform_where_nothing_is_missing_and_small_where_something_is() {
    // Some fifty unknowns of the model, with many poses and with hardly more poses than unknowns.
    for (poses, trials) in [(100, 60), (36, 100)] {
        let (chain, data) = data(poses, 4, &|_, _, _| [0.0; 3]);
        let fit = fitted(&chain, &data);
        let options = DiscoverOptions::default();
        let mut linearisation = Linearisation::new(&fit, &data, &options).unwrap();
        linearisation.noise.rows = NoiseModel { position_sd: 3e-5, visit_sd: 5e-5, orientation_sd: 2e-4 };
        let noise = linearisation.noise.rows;
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
        // The distribution depends on the columns alone.
        let null = null(&linearisation, &candidates, 0);
        let p = |y: DVector<f64>, linearisation: &mut Linearisation<'_>| {
            linearisation.y = y;
            let projection = Projection::new(linearisation);
            let scores: Vec<Score> =
                candidates.iter().filter_map(|c| projection.judge(linearisation, c)).collect();
            assert!(scores.len() > 10);
            null.p_value(scores.iter().map(|score| score.surprisal).fold(0.0, f64::max))
        };
        let values: Vec<f64> = (0..trials).map(|trial| p(of(trial), &mut linearisation)).collect();
        let distance = distance(values);
        assert!(distance < critical(trials) + 1.0 / ROTATIONS as f64, "{poses}: {distance}");

        // Where a candidate's own columns are added at many standard deviations of the noise p is far below the resolution of the sample.
        let x: DMatrix<f64> = linearisation.columns_of(&candidates[8]).unwrap();
        let signal = x.column(0) * (2e-3 / x.column(0).amax());
        let small = p(of(0) + signal, &mut linearisation);
        assert!(small < 1e-6, "{poses}: {small}");
    }
}

fn null(
    linearisation: &Linearisation<'_>,
    candidates: &[crate::hypotheses::candidate::Candidate],
    seed: u64,
) -> NullDistribution {
    let projection = Projection::new(linearisation);
    let rotations = Rotations::new(&projection, ROTATIONS, seed);
    let mut largest = rotations.nothing();
    for candidate in candidates {
        if let Some(score) = projection.judge(linearisation, candidate) {
            let columns = projection.columns(linearisation, candidate).unwrap();
            rotations.add(&mut largest, &rotations.along(&[columns]), &score.basis);
        }
    }
    largest.distribution(projection.freedom)
}

#[test]
fn the_fraction_of_a_rotated_residual_has_a_beta_distribution() {
    use statrs::distribution::{Beta, ContinuousCDF};
    let (chain, data) = data(40, 2, &|_, _, _| [0.0; 3]);
    let fit = fitted(&chain, &data);
    let options = DiscoverOptions::default();
    let linearisation = Linearisation::new(&fit, &data, &options).unwrap();
    let projection = Projection::new(&linearisation);
    let rotations = Rotations::new(&projection, 999, 5);
    let all = Library::standard().candidates(&chain, &data);
    let mut compared = 0;
    for candidate in all.iter().step_by(397) {
        let Some(score) = projection.judge(&linearisation, candidate) else { continue };
        let columns = projection.columns(&linearisation, candidate).unwrap();
        let mut largest = rotations.nothing();
        rotations.add(&mut largest, &rotations.along(&[columns]), &score.basis);
        let (k, freedom) = (score.freedom as f64, projection.freedom as f64);
        let beta = Beta::new(0.5 * k, 0.5 * (freedom - k)).unwrap();
        let values: Vec<f64> =
            largest.fractions(score.freedom).iter().map(|&f| beta.cdf(f64::from(f))).collect();
        let distance = distance(values);
        assert!(distance < critical(999) + 1e-3, "{}: {distance}", candidate.words());
        compared += 1;
    }
    assert!(compared > 5, "{compared}");
}
