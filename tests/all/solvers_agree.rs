//! The same data and model give the same answer from every exact solver, and the same bits on any number of threads.

use crate::plants::{elastic, heavy_observation};
use truepose_errormodel::Dataset;
use truepose_identify::{
    CrossValidation, Fit, FitOptions, Folds, Method, PriorStrength, Split, cross_validate, fit,
};
use truepose_kinematics::Chain;
use truepose_simulate::robots::heavy_plant;
use truepose_solvers::SolverSpec;

fn data(postures: usize) -> (Chain, Dataset) {
    let plant = heavy_plant(5).unwrap();
    let data = heavy_observation(&plant, postures, 5).data;
    (plant.chain().clone(), data)
}

fn fitted(chain: &Chain, data: &Dataset, solver: &str, options: &FitOptions) -> Fit {
    let solver = solver.parse::<SolverSpec>().unwrap().build();
    fit(&elastic(chain), data, &*solver, options).unwrap()
}

#[test]
fn qr_svd_and_normal_equations_agree() {
    let (chain, data) = data(40);
    for prior in [PriorStrength::Evidence, PriorStrength::None] {
        let options = FitOptions { prior, ..FitOptions::default() };
        let by: Vec<Fit> =
            ["qr", "svd", "normal"].iter().map(|s| fitted(&chain, &data, s, &options)).collect();
        let rms: Vec<f64> = by.iter().map(|fit| fit.positions().rms).collect();
        println!("{prior:?}: RMS {:?} µm", rms.iter().map(|r| r * 1e6).collect::<Vec<_>>());
        for (other, name) in [(1, "svd"), (2, "normal")] {
            // The RMS is stationary at the solution: coefficients that differ by 1e-6 change it by 1e-12.
            assert!((rms[other] / rms[0] - 1.0).abs() < 1e-9, "{name}: {} and {} m", rms[other], rms[0]);
            assert_eq!(by[other].reduction, by[0].reduction, "{name}");
            // Coefficients themselves, in expected sizes: the normal equations lose half the digits, and a round
            // ends when nothing moves by more than 1e-8 standard deviations.
            for (k, column) in by[0].fitted.model().columns().iter().enumerate() {
                let apart = by[other].fitted.coefficients()[k] - by[0].fitted.coefficients()[k];
                assert!(apart.abs() < 1e-4 * column.scale, "{name}, {}: {apart}", column.name);
            }
        }
    }
}

fn bits(values: impl IntoIterator<Item = f64>) -> Vec<u64> {
    values.into_iter().map(f64::to_bits).collect()
}

fn on_threads<T: Send>(count: usize, work: impl FnOnce() -> T + Send) -> T {
    rayon::ThreadPoolBuilder::new().num_threads(count).build().unwrap().install(work)
}

#[test]
fn threads_change_no_bit() {
    // More visits than one block of work holds (1024), so that there is something to divide.
    let (chain, data) = data(280);
    assert!(data.visit.iter().max().unwrap() + 1 > 1024);
    let work = || -> (Fit, CrossValidation) {
        let solver = "qr".parse::<SolverSpec>().unwrap().build();
        let found = fitted(&chain, &data, "qr", &FitOptions::default());
        let folds = Folds::new(&data, &Split::Random { folds: 5, seed: 1 }).unwrap();
        let held_out = cross_validate(&found, &data, &folds, &*solver, Method::Auto).unwrap();
        (found, held_out)
    };
    let (one, held_one) = on_threads(1, work);
    for count in [2, 4] {
        let (more, held_more) = on_threads(count, work);
        let same = |a: &[f64], b: &[f64]| bits(a.iter().copied()) == bits(b.iter().copied());
        assert!(same(one.fitted.coefficients(), more.fitted.coefficients()), "{count} threads");
        assert!(same(one.fitted.covariance().as_slice(), more.fitted.covariance().as_slice()));
        assert_eq!(one.noise, more.noise);
        assert_eq!(one.reduction, more.reduction);
        assert_eq!(one.rounds, more.rounds);
        assert!(same(&held_one.fold_rms, &held_more.fold_rms), "{count} threads");
        let flat = |c: &CrossValidation| bits(c.residuals.position.iter().flat_map(|p| [p.x, p.y, p.z]));
        assert_eq!(flat(&held_one), flat(&held_more));
    }
}
