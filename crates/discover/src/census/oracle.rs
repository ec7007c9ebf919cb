//! What passes in blocks say of all rows, against whole matrices of them.

use crate::census::all_rows::AllRows;
use crate::census::blocks::Blocks;
use crate::census::details::Detail;
use crate::census::scores::screened;
use crate::census::sums::sums;
use crate::hypotheses::candidate::Candidate;
use crate::hypotheses::change::Change;
use crate::options::DiscoverOptions;
use crate::problem::dense::Dense;
use crate::problem::linearisation::Linearisation;
use crate::problem::noise::{JointNoise, Noise};
use crate::problem::synthetic::{data, fitted, wave};
use crate::screen::candidates::Screen;
use nalgebra::DMatrix;
use truepose_errormodel::Dataset;
use truepose_identify::{Fit, NoiseModel};
use truepose_kinematics::Chain;

/// Noise of a search in which the joints scatter.
const SCATTER: Noise = Noise {
    rows: NoiseModel { position_sd: 4e-5, visit_sd: 2e-5, orientation_sd: 2e-4 },
    joints: JointNoise { turning: 5e-5, sliding: 0.0 },
};

/// A gear error of the third joint, and noise; poses of one row and of three.
fn measured() -> (Chain, Dataset, Fit) {
    let error = |pose: usize, joints: &[f64], row: usize| {
        let wobble = 2e-4 * (9.0 * joints[2]).sin();
        std::array::from_fn(|axis| wobble + 6e-5 * wave(7 * pose + axis) + 4e-5 * wave(900 + 5 * row + axis))
    };
    let (chain, data) = data(90, 5, &error);
    let fit = fitted(&chain, &data);
    (chain, data, fit)
}

/// The fit with its coefficients moved by some of their standard deviations, as if it were that of other rows.
fn of_others(fit: &Fit) -> Fit {
    let mut coefficients = fit.fitted.coefficients().to_vec();
    let covariance = fit.fitted.covariance().clone();
    for (k, coefficient) in coefficients.iter_mut().enumerate() {
        *coefficient += 2.0 * wave(70 + k) * covariance[(k, k)].max(0.0).sqrt();
    }
    Fit { fitted: fit.fitted.with_coefficients(coefficients, covariance).unwrap(), ..fit.clone() }
}

#[test]
fn coefficients_of_all_rows_are_those_of_whole_matrices_wherever_they_begin() {
    let (_, data, fit) = measured();
    let options = DiscoverOptions::default();
    for noise in [None, Some(SCATTER)] {
        let blocks = Blocks::new(data.clone()).under(noise);
        let all = AllRows::of(&of_others(&fit), &blocks, &options).unwrap();
        let linearisation = blocks.linearised(&all.fit, &data, &options).unwrap();
        assert_eq!(linearisation.noise.joints.is_some(), noise.is_some());
        coefficients_are_those_of_whole_matrices(&all, &linearisation, &options);
    }
}

fn coefficients_are_those_of_whole_matrices(
    all: &AllRows,
    linearisation: &Linearisation<'_>,
    options: &DiscoverOptions,
) {
    let dense = Dense::new(linearisation, linearisation.noise);
    let nothing = DMatrix::zeros(linearisation.len(), 0);
    let used = vec![true; linearisation.len()];
    let (solution, covariance, _) = dense.solve(&nothing, &used, options.policy.wide);
    let own = linearisation.coefficients();
    for k in 0..own.len() {
        let deviation = covariance[(k, k)].sqrt();
        // What is left of a step that would win 1e-4.
        assert!((own[k] - solution[k]).abs() < 1e-2 * deviation, "{k}: {} {}", own[k], solution[k]);
        // That of the step before: a fit of others is two of its standard deviations away.
        assert!((all.inverse[(k, k)].sqrt() / deviation - 1.0).abs() < 1e-3);
    }
    assert_eq!((all.count, all.fit.observations), (linearisation.len(), linearisation.len()));
}

#[test]
fn sums_over_blocks_judge_a_candidate_as_whole_matrices_do() {
    let (chain, data, fit) = measured();
    let options = DiscoverOptions::default();
    for noise in [None, Some(SCATTER)] {
        let blocks = Blocks::new(data.clone()).under(noise);
        assert!(blocks.units() > 40);
        candidates_are_judged_as_by_whole_matrices((&chain, &data, &fit), &blocks, &options);
    }
}

fn candidates_are_judged_as_by_whole_matrices(
    (chain, data, fit): (&Chain, &Dataset, &Fit),
    blocks: &Blocks,
    options: &DiscoverOptions,
) {
    let all = AllRows::of(fit, blocks, options).unwrap();
    let linearisation = blocks.linearised(&all.at, data, options).unwrap();
    let dense = Dense::new(&linearisation, linearisation.noise).held();
    // A corrected payload is not screened on all rows.
    let screened = |candidate: &Candidate| matches!(candidate.change, Change::Add(_));
    let candidates: Vec<Candidate> =
        options.library.candidates(chain, data).into_iter().filter(screened).step_by(61).collect();
    let mut judged = 0;
    let each = sums(&candidates, (&all, blocks), 1, options).unwrap();
    for (candidate, sums) in candidates.iter().zip(each) {
        let (Some(sums), Ok(x)) = (sums, linearisation.columns_of(candidate)) else { continue };
        let detail = Detail::of(&sums, &all, 1, &options.policy);
        let expected = dense.score(&x, options.policy.absorbed).filter(|_| x.amax() > 1e-9);
        assert_eq!(
            detail.as_ref().map(Detail::freedom),
            expected.as_ref().map(|s| s.freedom),
            "{}",
            candidate.words()
        );
        if let (Some(detail), Some(expected)) = (detail, expected) {
            let squares = all.squares * (1.0 - (-detail.gain / all.count as f64).exp());
            assert!(
                (squares - expected.squares).abs() < 1e-5 * (1.0 + expected.squares),
                "{}: {squares} {}",
                candidate.words(),
                expected.squares
            );
            judged += 1;
        }
    }
    assert!(judged > 40, "{judged}");
}

#[test]
fn a_screen_of_all_rows_with_the_columns_of_the_same_rows_is_that_of_the_search() {
    let (_, data, fit) = measured();
    let options = DiscoverOptions::default();
    let blocks = Blocks::new(data.clone());
    let all = AllRows::of(&fit, &blocks, &options).unwrap();
    let linearisation = Linearisation::new(&all.fit, &data, &options).unwrap();
    let of_search = Screen::new(&linearisation, &options.library, &[]);
    let mut of_all = Screen::new(&linearisation, &options.library, &[]);
    screened(&mut of_all, &linearisation, (&all, &blocks), &options).unwrap();
    // The search lets the data alone estimate what the prior hardly holds: a little more or less of the residual is left.
    let close = |a: f64, b: f64| (a.sqrt() - b.sqrt()).abs() < 0.2 + 0.02 * b.sqrt();
    let mut compared = 0;
    for (a, b) in of_all.candidates.iter().zip(&of_search.candidates) {
        assert_eq!(a.score.is_some(), b.score.is_some());
        // Corrected loads are those of the search alone.
        if !matches!(a.candidate.change, Change::Add(_)) {
            continue;
        }
        if let (Some(a_score), Some(b_score)) = (&a.score, &b.score) {
            assert!(
                close(a_score.gain, b_score.gain),
                "{}: {} {}",
                a.candidate.words(),
                a_score.gain,
                b_score.gain
            );
            compared += 1;
        }
    }
    assert!(compared > 1000, "{compared}");
    for (a, b) in of_all.periods.iter().zip(&of_search.periods) {
        let largest = b.gains.iter().copied().fold(0.0, f64::max);
        for (k, (&fast, &exact)) in a.gains.iter().zip(&b.gains).enumerate() {
            // A wave between intervals is weakened by up to 1.3 % of its amplitude.
            assert!(
                (fast - exact).abs() < 0.06 * (2.0 + exact + 0.3 * largest.sqrt()),
                "{k}: {fast} {exact}"
            );
        }
    }
}
