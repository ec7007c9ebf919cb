//! `cargo xtask micro errormodel`: a robot at rest row by row, a block of rows, error Jacobians.

use divan::counter::ItemsCount;
use divan::{Bencher, black_box};
use truepose_errormodel::batch::Lanes;
use truepose_errormodel::effects::{Geometric, JointCompliance, LinkCompliance, Polynomial, WrenchComponent};
use truepose_errormodel::lanes::{LANES, error_jacobians};
use truepose_errormodel::{AnyEffect, Equilibrium, ErrorModel};
use truepose_kinematics::{Conditions, samples};
use truepose_micro::points;

fn main() {
    divan::main();
}

const MODELS: [&str; 4] = ["constant", "joints yield", "links yield", "polynomial"];

fn model(name: &str) -> ErrorModel {
    let effects: Vec<Box<dyn AnyEffect>> = match name {
        "constant" => vec![Box::new(Geometric::default())],
        "joints yield" => vec![Box::new(Geometric::default()), Box::new(JointCompliance::default())],
        "links yield" => vec![Box::new(Geometric::default()), Box::new(LinkCompliance::default())],
        _ => vec![Box::new(Polynomial::of(3, vec![WrenchComponent::Fy]))],
    };
    ErrorModel::new(samples::pps(), effects).expect("effects fit the robot")
}

fn some(model: &ErrorModel) -> Vec<f64> {
    model.columns().iter().map(|column| 0.1 * column.scale).collect()
}

#[divan::bench(args = MODELS)]
fn at_rest_one_row(bencher: Bencher<'_, '_>, name: &str) {
    let model = model(name);
    let (data, coefficients) = (points(model.chain(), 0, LANES), some(&model));
    let bound = model.bind(&data.schema).expect("nothing is missing");
    let mut rest = Equilibrium::new(&model);
    let conditions: Conditions = data.conditions(7);
    bencher.bench_local(|| rest.settle(&bound, black_box(&conditions), &coefficients));
}

#[divan::bench(args = MODELS)]
fn columns_of_a_block(bencher: Bencher<'_, '_>, name: &str) {
    let model = model(name);
    let (data, coefficients) = (points(model.chain(), 0, LANES), some(&model));
    let mut lanes = Lanes::new(model.bind(&data.schema).expect("nothing is missing"));
    let rows: Vec<usize> = (0..LANES).collect();
    let places: Vec<Option<usize>> = (0..coefficients.len()).map(Some).collect();
    bencher.counter(ItemsCount::new(LANES)).bench_local(|| {
        lanes.gather(&data, black_box(&rows));
        lanes.settle(&data, &coefficients);
        lanes.columns(&data, &[1.0; 6 * LANES], &places);
    });
}

#[divan::bench]
fn error_jacobians_of_a_block(bencher: Bencher<'_, '_>) {
    let chain = samples::ur10();
    let joints: Vec<Vec<f64>> =
        (0..6).map(|k| (0..LANES).map(|row| ((row * (k + 3)) as f64).sin()).collect()).collect();
    let columns: Vec<&[f64]> = joints.iter().map(Vec::as_slice).collect();
    let mut into = vec![0.0; 36 * 6 * LANES];
    bencher
        .counter(ItemsCount::new(LANES))
        .bench_local(|| error_jacobians(&chain, black_box(&columns), &mut into));
}
