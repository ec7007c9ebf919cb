//! The screen's accelerated paths against the dense reference: functions of the pose at all sites together, and periods.

use crate::hypotheses::library::Library;
use truepose_errormodel::effects::Transmission;

use crate::options::DiscoverOptions;
use crate::problem::dense::Dense;
use crate::problem::emitted::{Block, Emitted};
use crate::problem::linearisation::Linearisation;
use crate::problem::projection::Projection;
use crate::problem::synthetic::{data, fitted, wave};
use crate::problem::tables::Tables;
use crate::screen::functions::Functions;
use crate::screen::periodogram::{grid, scan};
use nalgebra::DMatrix;

/// Xᵀr̃ of every function (rows) at every site (columns), in blocks of rows.
fn through(functions: &Functions, linearisation: &Linearisation<'_>, tables: &Tables) -> DMatrix<f64> {
    let rows: Vec<usize> = tables.stations.iter().map(|&at| linearisation.stations()[at].row).collect();
    let parts = Emitted::all(linearisation.fit, functions.effects(), std::slice::from_ref).unwrap();
    let width = parts.iter().map(|(_, asked)| asked.width()).sum();
    let mut scores = DMatrix::zeros(width, linearisation.site_count());
    let mut first = 0;
    for (_, asked) in parts {
        let mut add = |said: Block<'_>| {
            for one in &said.beside {
                for site in 0..linearisation.site_count() {
                    let values = said.visits.clone().zip(one.values);
                    scores[(first + one.column, site)] += values
                        .map(|(visit, value)| one.factor * value * tables.score(visit, site))
                        .sum::<f64>();
                }
            }
        };
        asked.each(linearisation.data, &rows, &mut add).unwrap();
        first += asked.width();
    }
    scores
}

#[test]
fn functions_and_periods_score_as_whole_matrices_do() {
    let error = |pose: usize, joints: &[f64], row: usize| {
        let wobble = 2e-4 * (9.0 * joints[2]).sin();
        std::array::from_fn(|axis| wobble + 6e-5 * wave(7 * pose + axis) + 4e-5 * wave(900 + 5 * row + axis))
    };
    let (chain, data) = data(48, 2, &error);
    let fit = fitted(&chain, &data);
    let options = DiscoverOptions::default();
    let linearisation = Linearisation::new(&fit, &data, &options).unwrap();
    let projection = Projection::new(&linearisation);
    let dense = Dense::new(&linearisation, linearisation.noise);
    let absorbed = options.policy.absorbed;
    let close = |a: f64, b: f64| (a - b).abs() <= 1e-6 * (1.0 + b.abs());

    let candidates = Library::standard().candidates(&chain, &data);
    let functions = Functions::new(&linearisation, &projection, &candidates).unwrap();
    let scores = through(&functions, &linearisation, projection.tables(&linearisation));
    let mut compared = 0;
    for candidate in candidates.iter().step_by(5) {
        let Some(fast) = functions.score(&linearisation, candidate) else { continue };
        let x = linearisation.columns_of(candidate).unwrap();
        let expected = dense.score(&x, absorbed);
        let freedom = [fast.as_ref().map(|s| s.freedom), expected.as_ref().map(|s| s.freedom)];
        assert_eq!(freedom[0], freedom[1], "{}", candidate.words());
        if let (Some(fast), Some(expected)) = (fast, expected) {
            let gain = [fast.gain, expected.statistic];
            assert!(close(gain[0], gain[1]), "{}: {gain:?}", candidate.words());
            // The basis is that of the functions: with what they give at each site it is the gain.
            let score = functions.scores_at(&linearisation, candidate, &scores).unwrap();
            let squares = fast.basis.map(f64::from).tr_mul(&score).norm_squared();
            let again = crate::problem::basis::gain(projection.len(), squares, projection.rss);
            assert!(
                (again - gain[0]).abs() < 1e-4 * (1.0 + gain[0]),
                "{}: {again} {gain:?}",
                candidate.words()
            );
            compared += 1;
        }
    }
    assert!(compared > 200, "{compared}");

    let joint = chain.movable()[2];
    let periods: Vec<f64> = grid(&linearisation, joint).into_iter().step_by(29).collect();
    let periodogram = scan(&linearisation, &projection, joint, &periods).expect("a joint that moves");
    assert!(periods.len() > 10);
    for (&period, &fast) in periods.iter().zip(&periodogram.gains) {
        let x = linearisation.columns(&[Box::new(Transmission::of(joint, period))]).unwrap();
        let expected = dense.score(&x, absorbed).expect("two directions");
        assert!(close(fast, expected.statistic), "{period}: {fast} {}", expected.statistic);
    }
}
