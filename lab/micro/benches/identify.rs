//! `cargo xtask micro identify`: the normal equations, the triangle, residuals, and a whole linear fit.

use divan::counter::ItemsCount;
use divan::{Bencher, black_box};
use nalgebra::Vector3;
use truepose_errormodel::effects::{Geometric, JointCompliance, Polynomial, WrenchComponent};
use truepose_errormodel::{AnyEffect, Dataset, ErrorModel, Schema, Visits};
use truepose_identify::engine::{gram, left_over, triangular};
use truepose_identify::{FitOptions, NoiseModel, PriorStrength, fit};
use truepose_kinematics::{Load, TargetId, Wrench, samples};
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
    let mut data = Dataset {
        schema: Schema { load: true, ..Schema::default() },
        joints: vec![Vec::new(); 6],
        approach: vec![vec![0.0; ROWS]; 6],
        position_sd: vec![[f64::NAN; 3]; ROWS],
        orientation: vec![None; ROWS],
        orientation_sd: vec![[f64::NAN; 3]; ROWS],
        visit: (0..ROWS).collect(),
        time: vec![0.0; ROWS],
        ..Dataset::default()
    };
    for row in 0..ROWS {
        let share =
            |k: usize| ((row + 1) as f64 * [2.0_f64, 3.0, 5.0, 7.0, 11.0, 13.0, 17.0][k].sqrt()).fract();
        let q: Vec<f64> = chain
            .movable()
            .iter()
            .enumerate()
            .map(|(k, &joint)| {
                let (lower, upper) = chain.joint(joint).limits.unwrap_or((-1.0, 1.0));
                lower + (upper - lower) * share(k)
            })
            .collect();
        let target = TargetId(row % 3);
        let place = chain.forward(&q).apply(&chain.targets()[target.0].position);
        data.position.push([
            place.x + 1e-3 * q[3].sin(),
            place.y - 1e-3 * q[0],
            place.z + 1e-3 * q[1] * q[2],
        ]);
        data.target.push(Some(target));
        let force = Vector3::new(0.0, 600.0 * (share(6) - 0.5), -300.0);
        data.load.push(Load::Wrench(Wrench { force, moment: Vector3::new(40.0, 0.0, 0.0) }));
        data.joints.iter_mut().zip(&q).for_each(|(column, q)| column.push(*q));
    }
    (model, data)
}

#[divan::bench(args = MODELS)]
fn normal_equations(bencher: Bencher<'_, '_>, name: &str) {
    let (model, data) = problem(name);
    let (visits, zero) = (Visits::of(&data), vec![0.0; model.columns().len()]);
    bencher
        .counter(ItemsCount::new(ROWS))
        .bench_local(|| gram(&model, black_box(&data), &visits, NoiseModel::default(), &zero, None));
}

#[divan::bench(args = MODELS)]
fn triangle(bencher: Bencher<'_, '_>, name: &str) {
    let (model, data) = problem(name);
    let (visits, zero) = (Visits::of(&data), vec![0.0; model.columns().len()]);
    bencher
        .counter(ItemsCount::new(ROWS))
        .bench_local(|| triangular(&model, black_box(&data), &visits, NoiseModel::default(), &zero, None));
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
