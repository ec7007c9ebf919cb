//! What does not matter changes nothing: the order of rows, and rows that were not measured.

use rand::SeedableRng;
use rand::seq::SliceRandom;
use rand_chacha::ChaCha8Rng;
use truepose_errormodel::effects::{Geometric, JointCompliance};
use truepose_errormodel::{AnyEffect, Dataset, ErrorModel};
use truepose_identify::{FitOptions, fit};
use truepose_kinematics::{Chain, samples};
use truepose_simulate::{Campaign, Plant, PlantDescription, PlantOptions};
use truepose_solvers::PivotedQr;

fn measured(chain: &Chain) -> Dataset {
    let text = "[errors.geometric]\nposition_mm = 0.4\nangle_mrad = 0.4\n[instrument]\nsd_um = 20\n";
    let PlantDescription { errors, shop, instrument, repeatability, .. } =
        PlantDescription::from_toml(text).unwrap();
    let plant = Plant::random(chain, &PlantOptions { errors, shop, instrument, repeatability }, 3).unwrap();
    let campaign = Campaign::random(chain, 60, 11).unwrap().with_each_payload(&[0.0, 5.0], [0.0, 0.0, 0.1]);
    plant.measure(&campaign, 7).unwrap()
}

/// Coefficients with their standard deviations.
fn coefficients(chain: &Chain, data: &Dataset) -> Vec<(f64, f64)> {
    let effects: Vec<Box<dyn AnyEffect>> =
        vec![Box::new(Geometric::default()), Box::new(JointCompliance::default())];
    let model = ErrorModel::new(chain.clone(), effects).unwrap();
    let found = fit(&model, data, &PivotedQr::default(), &FitOptions::default()).unwrap().fitted;
    let sd = |k: usize| found.covariance()[(k, k)].sqrt();
    found.coefficients().iter().enumerate().map(|(k, &c)| (c, sd(k))).collect()
}

/// The same to a thousandth of what is known at all.
#[track_caller]
fn same(a: &[(f64, f64)], b: &[(f64, f64)], what: &str) {
    for (k, ((a, sd), (b, other))) in a.iter().zip(b).enumerate() {
        assert!((a - b).abs() <= 1e-3 * sd + 1e-12, "{what}: coefficient {k} is {a:e} and {b:e}, ± {sd:e}");
        assert!(
            (sd - other).abs() <= 1e-3 * sd + 1e-15,
            "{what}: ± {sd:e} and ± {other:e} of coefficient {k}"
        );
    }
}

#[test]
fn the_order_of_rows_changes_nothing() {
    for chain in [samples::heavy(), samples::ur10(), samples::scara()] {
        let data = measured(&chain);
        let one = coefficients(&chain, &data);
        for seed in 0..4 {
            let mut order: Vec<usize> = (0..data.len()).collect();
            order.shuffle(&mut ChaCha8Rng::seed_from_u64(seed));
            same(
                &one,
                &coefficients(&chain, &data.select(&order)),
                &format!("{}, seed {seed}", chain.name()),
            );
        }
    }
}

#[test]
fn rows_without_a_measurement_change_nothing() {
    let chain = samples::heavy();
    let data = measured(&chain);
    let one = coefficients(&chain, &data);
    let mut more: Vec<usize> = (0..data.len()).collect();
    more.extend([3, 8, 30]);
    let mut with_empty = data.select(&more);
    for row in data.len()..with_empty.len() {
        with_empty.position[row] = [f64::NAN; 3];
        with_empty.orientation[row] = None;
    }
    same(&one, &coefficients(&chain, &with_empty), "with empty rows");
}
