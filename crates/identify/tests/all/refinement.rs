//! A 6R geometric calibration with 1 000 poses ends where an independent program ends: numpy and scipy with a forward model
//! of their own (`refinement/make.py`, which also made the poses).

use truepose_errormodel::effects::Geometric;
use truepose_errormodel::{AnyEffect, Dataset, ErrorModel, Visits};
use truepose_identify::engine::left_over;
use truepose_identify::{FitOptions, NoiseModel, NoiseSource, PriorStrength, Way, fit, plain};
use truepose_kinematics::nalgebra::{Matrix3, UnitQuaternion, Vector3};
use truepose_kinematics::{Chain, Load, Placed, Pose, samples};
use truepose_solvers::{NormalEquations, PivotedQr, RankRule, Solver, Svd};

const POSES: &str = include_str!("refinement/poses.csv");
const KEPT: &str = include_str!("refinement/kept.csv");
const DIGITS: &str = include_str!("refinement/digits.csv");

fn chain() -> Chain {
    let tool = Pose::new(Matrix3::identity(), Vector3::new(0.05, 0.03, 0.1));
    samples::ur10().with_tool(Placed { pose: tool, known: true }).expect("a tool")
}

fn data() -> Dataset {
    let rows: Vec<Vec<f64>> = POSES
        .lines()
        .skip(1)
        .map(|line| line.split(',').map(|cell| cell.parse().expect("a number")).collect())
        .collect();
    let n = rows.len();
    let quaternion = |r: &[f64]| {
        let q = UnitQuaternion::from_scaled_axis(Vector3::new(r[9], r[10], r[11]));
        Some([q.w, q.i, q.j, q.k])
    };
    Dataset {
        joints: (0..6).map(|j| rows.iter().map(|r| r[j]).collect()).collect(),
        position: rows.iter().map(|r| [r[6], r[7], r[8]]).collect(),
        position_sd: vec![[f64::NAN; 3]; n],
        orientation: rows.iter().map(|r| quaternion(r)).collect(),
        orientation_sd: vec![[f64::NAN; 3]; n],
        target: vec![None; n],
        visit: (0..n).collect(),
        load: vec![Load::None; n],
        time: vec![0.0; n],
        approach: vec![vec![0.0; n]; 6],
        ..Dataset::default()
    }
}

#[test]
fn the_minimum_is_that_of_another_program() {
    let data = data();
    assert_eq!(Visits::of(&data).len(), 1000);
    let effects: Vec<Box<dyn AnyEffect>> = vec![Box::new(Geometric::default())];
    let model = ErrorModel::new(chain(), effects).expect("a model");
    let noise = NoiseModel { position_sd: 5e-5, visit_sd: 0.0, orientation_sd: 1e-4 };
    let options =
        FitOptions { prior: PriorStrength::None, noise: NoiseSource::Fixed(noise), ..FitOptions::default() };
    let mut digits = DIGITS.lines().map(|line| {
        let (name, value) = line.split_once(',').expect("two cells");
        (name, value.parse::<f64>().expect("a number"))
    });
    let (_, chi_square) = digits.next().expect("the sum of squares");
    let digits: Vec<(&str, f64)> = digits.collect();
    let solvers: [&dyn Solver; 3] = [&PivotedQr::default(), &Svd::default(), &NormalEquations::default()];
    for solver in solvers {
        let fit = fit(&model, &data, solver, &options).expect("a fit");
        let kept: Vec<&str> = fit.reduction.kept.iter().map(|&c| model.columns()[c].name.as_str()).collect();
        assert_eq!(kept, KEPT.lines().collect::<Vec<_>>(), "what make.py fits");
        assert!((fit.chi_square / chi_square - 1.0).abs() < 1e-9, "{} {chi_square}", fit.chi_square);
        // Errors of half a millimetre and half a milliradian: 1e-9 of them is less than a picometre.
        let size = digits.iter().fold(0.0_f64, |size, d| size.max(d.1.abs()));
        for (&column, (name, value)) in fit.reduction.kept.iter().zip(&digits) {
            let found = fit.fitted.coefficients()[column];
            assert!((found - value).abs() < 1e-9 * size, "{}: {name} {found} {value}", solver.name());
        }
    }
}

#[test]
fn the_short_way_ends_there_as_well() {
    let data = data();
    let effects: Vec<Box<dyn AnyEffect>> = vec![Box::new(Geometric::default())];
    let model = ErrorModel::new(chain(), effects).expect("a model");
    let noise = NoiseModel { position_sd: 5e-5, visit_sd: 0.0, orientation_sd: 1e-4 };
    let want: f64 =
        DIGITS.lines().next().and_then(|l| l.split_once(',')?.1.parse().ok()).expect("the sum of squares");
    for way in [Way::default(), Way::Stable(RankRule::Relative(1e-9))] {
        let found = plain(&model, &data, noise, None, way, 20).expect("an answer");
        assert!(found.converged && found.guarded == matches!(way, Way::Guarded(_)), "{way:?}");
        let left = found.residuals(&model, &data, true).expect("residuals");
        let square = |v: &Vector3<f64>, sd: f64| v.norm_squared() / (sd * sd);
        let positions: f64 = left.position.iter().map(|v| square(v, noise.position_sd)).sum();
        let turns: f64 = left.orientation.iter().flatten().map(|v| square(v, noise.orientation_sd)).sum();
        assert!(
            ((positions + turns) / want - 1.0).abs() < 1e-8,
            "{way:?}: {} against {want}",
            positions + turns
        );
        // The linear picture at the solution says the same as one more step.
        let zero = vec![0.0; found.coefficients.len()];
        let again = left_over(&model, &data, &found.coefficients, &zero).expect("residuals");
        assert_eq!(again, left);
    }
}
