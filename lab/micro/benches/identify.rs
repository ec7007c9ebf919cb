//! `cargo xtask micro identify`: the normal equations, the triangle, residuals, and a whole linear fit.

use divan::counter::ItemsCount;
use divan::{Bencher, black_box};
use truepose_errormodel::effects::{Geometric, JointCompliance, Polynomial, WrenchComponent};
use truepose_errormodel::{AnyEffect, Dataset, ErrorModel, Visits};
use truepose_identify::engine::{gram, left_over, triangular};
use truepose_identify::{FitOptions, NoiseModel, PriorStrength, fit};
use truepose_kinematics::samples;
use truepose_micro::points;
use truepose_solvers::PivotedQr;

fn main() {
    divan::main();
}

const MODELS: [&str; 2] = ["elastic", "polynomial"];
const ROWS: usize = 1200;

/// The paper's robot at so many places, off by a smooth error.
fn problem(name: &str) -> (ErrorModel, Dataset) {
    let chain = samples::pps();
    let effects: Vec<Box<dyn AnyEffect>> = match name {
        "elastic" => vec![Box::new(Geometric::default()), Box::new(JointCompliance::default())],
        _ => vec![Box::new(Polynomial::of(2, vec![WrenchComponent::Fy]))],
    };
    let model = ErrorModel::new(chain.clone(), effects).expect("effects fit the robot");
    let data = points(&chain, 0, ROWS);
    (model, data)
}

#[divan::bench(args = MODELS)]
fn normal_equations(bencher: Bencher<'_, '_>, name: &str) {
    let (model, data) = problem(name);
    let (visits, zero) = (Visits::of(&data), vec![0.0; model.columns().len()]);
    let work = || gram(&model, black_box(&data), &visits, NoiseModel::default(), &zero, None);
    bencher.counter(ItemsCount::new(ROWS)).bench_local(work);
}

#[divan::bench(args = MODELS)]
fn triangle(bencher: Bencher<'_, '_>, name: &str) {
    let (model, data) = problem(name);
    let (visits, zero) = (Visits::of(&data), vec![0.0; model.columns().len()]);
    let work = || triangular(&model, black_box(&data), &visits, NoiseModel::default(), &zero, None);
    bencher.counter(ItemsCount::new(ROWS)).bench_local(work);
}

#[divan::bench(args = MODELS)]
fn residuals(bencher: Bencher<'_, '_>, name: &str) {
    let (model, data) = problem(name);
    let some: Vec<f64> = model.columns().iter().map(|column| 0.1 * column.scale).collect();
    let zero = vec![0.0; some.len()];
    bencher.counter(ItemsCount::new(ROWS)).bench_local(|| left_over(&model, black_box(&data), &some, &zero));
}

#[divan::bench(args = MODELS)]
fn linear_fit(bencher: Bencher<'_, '_>, name: &str) {
    let (model, data) = problem(name);
    let options = FitOptions { refine: false, prior: PriorStrength::None, ..FitOptions::default() };
    bencher.bench_local(|| fit(&model, black_box(&data), &PivotedQr::default(), &options));
}
