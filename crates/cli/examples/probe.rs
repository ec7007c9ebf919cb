//! scratch
#![allow(clippy::all, clippy::unwrap_used, clippy::print_stdout)]
use std::time::Instant;
use truepose_errormodel::effects::*;
use truepose_errormodel::*;
use truepose_identify::*;
fn main() {
    let a: Vec<String> = std::env::args().collect();
    let t = Instant::now();
    let (chain, _) = truepose_io::read_robot(&a[1], &Default::default()).unwrap();
    let (data, _, w) = truepose_io::read_measurements(&a[2], &chain, &Default::default()).unwrap();
    println!("read {:?} {} rows {:?}", t.elapsed(), data.len(), w.len());
    let t = Instant::now();
    let p = place(&chain, &data).unwrap();
    println!("place {:?} rms {:.4} mm {:?} {:?}", t.elapsed(), p.rms * 1e3, p.found, p.undetermined);
    let chain = p.chain;
    let solver = truepose_solvers::PivotedQr::default();
    let frames = Geometric {
        frames: Some(vec![Where::Frame(truepose_kinematics::FrameId(0)), Where::Frame(chain.tool_frame())]),
        components: None,
    };
    let mut eff: Vec<(&str, Vec<Box<dyn AnyEffect>>)> =
        vec![("frames", vec![Box::new(frames)]), ("const", vec![Box::new(Geometric::default())])];
    if a.len() > 3 {
        eff.push(("jc", vec![Box::new(Geometric::default()), Box::new(JointCompliance::default())]));
    }
    for (name, e) in eff {
        let model = ErrorModel::new(chain.clone(), e).unwrap();
        let t = Instant::now();
        let f = fit(
            &model,
            &data,
            &solver,
            &FitOptions {
                prior: std::env::var("TP_K").ok().map_or(PriorStrength::Evidence, |v| {
                    v.parse().map_or(PriorStrength::None, PriorStrength::Fixed)
                }),
                ..FitOptions::default()
            },
        )
        .unwrap();
        let t1 = t.elapsed();
        let mut all = 0.0;
        for seed in 2..12 {
            let folds = Folds::new(&data, &Split::Random { folds: 5, seed }).unwrap();
            all +=
                cross_validate(&f, &data, &folds, &solver, Method::Auto).unwrap().residuals.positions().rms
                    * 1e2;
        }
        print!("10x5: {all:.4} ");
        let folds = Folds::new(&data, &Split::Random { folds: 5, seed: 1 }).unwrap();
        let cv = cross_validate(&f, &data, &folds, &solver, Method::Auto).unwrap();
        println!(
            "{name}: rank {} of {} fit {:?} rounds {} conv {} cv {:?} train {:.4} held {:.4} noise {:?} ori {:.4} mrad, kappa {} gap {:.1e} {:.1e} {:?}",
            f.reduction.rank(),
            model.columns().len(),
            t1,
            f.rounds,
            f.converged,
            t.elapsed() - t1,
            f.positions().rms * 1e3,
            cv.residuals.positions().rms * 1e3,
            f.noise,
            f.residuals.orientations().rms * 1e3,
            f.prior.kappa,
            f.reduction.structural.gap,
            f.reduction.practical.gap,
            f.warnings
        );
    }
}
