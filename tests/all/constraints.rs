//! Bounds of physical unknowns, and effects that enter or stay out as a whole, on plants that know nothing of the model.

use truepose_errormodel::effects::{
    Backlash, Coupling, Geometric, JointCompliance, LoadNonlinearity, Side, Transmission,
};
use truepose_errormodel::{AnyEffect, Dataset, ErrorModel, Term};
use truepose_identify::{
    FitOptions, Folds, Method, NoiseSource, PriorStrength, Split, Warning, cross_validate, fit,
};
use truepose_kinematics::{Chain, JointId, samples};
use truepose_simulate::physics::temperature::Shop;
use truepose_simulate::{Campaign, Flaws, Plant, flaws};
use truepose_solvers::{PivotedQr, Solver, SolverSpec};

/// A heavy arm of which one joint yields, beside constant errors: measured with 60 µm, empty and loaded.
fn heavy(visits: usize) -> (Chain, Dataset) {
    let chain = samples::heavy();
    let flaws = Flaws {
        geometric: Some(flaws::Geometric {
            position_mm: 0.3,
            angle_mrad: 0.3,
            ..flaws::Geometric::default()
        }),
        joint_compliance: vec![flaws::JointCompliance {
            joint: "a3".into(),
            stiffness: Some(6e5),
            ..flaws::JointCompliance::default()
        }],
        ..Flaws::default()
    };
    let shop = Shop::steady(20.0).unwrap();
    let (truth, _) = flaws.on(&chain, &shop, 11).unwrap();
    let mut plant = Plant::new(&chain, truth).unwrap();
    plant.instrument.sd = 6e-5;
    let campaign =
        Campaign::random(&chain, visits, 5).unwrap().with_each_payload(&[0.0, 60.0], [0.02, -0.03, 0.15]);
    (chain, plant.measure(&campaign, 5).unwrap())
}

fn solver(text: &str) -> Box<dyn Solver> {
    text.parse::<SolverSpec>().unwrap().build()
}

/// Plain least squares; what is compared are the solvers.
fn plain() -> FitOptions {
    FitOptions { prior: PriorStrength::None, ..FitOptions::default() }
}

#[test]
fn compliances_are_held_to_what_physics_allows() {
    let (chain, data) = heavy(40);
    let effects: Vec<Box<dyn AnyEffect>> =
        vec![Box::new(Geometric::default()), Box::new(JointCompliance::default())];
    let model = ErrorModel::new(chain, effects).unwrap();
    let compliances = |c: &[f64]| c[model.columns_of(1)].to_vec();
    let free = fit(&model, &data, &PivotedQr::default(), &plain()).unwrap();
    let negative = compliances(free.fitted.coefficients()).iter().filter(|c| **c < 0.0).count();
    assert!(negative > 0, "noise makes some of them negative: the test needs that");
    let held = fit(&model, &data, &*solver("bounded(qr)"), &plain()).unwrap();
    let found = compliances(held.fitted.coefficients());
    assert!(found.iter().all(|c| *c >= 0.0) && found.contains(&0.0), "{found:?}");
    assert!((found[2] * 6e5 - 1.0).abs() < 0.1, "{found:?}");
    assert!(held.converged, "{:?}", held.warnings);
    // Under one and the same noise; an estimated one makes both sums the degrees of freedom.
    let fixed = FitOptions { noise: NoiseSource::Fixed(free.noise), ..plain() };
    let (free_sum, held_sum) = (
        fit(&model, &data, &PivotedQr::default(), &fixed).unwrap().chi_square,
        fit(&model, &data, &*solver("bounded(qr)"), &fixed).unwrap().chi_square,
    );
    assert!(held_sum > free_sum, "{held_sum} {free_sum}");

    // Held out as well: every fold is solved within the bounds.
    let folds = Folds::new(&data, &Split::Random { folds: 4, seed: 1 }).unwrap();
    let seen = cross_validate(&held, &data, &folds, &*solver("bounded(qr)"), Method::Auto).unwrap();
    assert_eq!(seen.refitted, 4);
}

#[test]
fn a_tolerance_of_the_users_own_is_held_or_its_violation_told() {
    let (chain, data) = heavy(40);
    let tolerance = [-1e-4, 1e-4];
    let effects: Vec<Box<dyn AnyEffect>> = vec![
        Box::new(Term::new(Box::new(Geometric::default())).bounded(tolerance).unwrap()),
        Box::new(JointCompliance::of(JointId(3))),
    ];
    let model = ErrorModel::new(chain, effects).unwrap();
    let free = fit(&model, &data, &PivotedQr::default(), &plain()).unwrap();
    let told = |w: &Warning| matches!(w, Warning::OutOfBounds { .. });
    assert!(free.warnings.iter().any(told), "the errors are three times the tolerance");
    let held = fit(&model, &data, &*solver("bounded(qr)"), &plain()).unwrap();
    assert!(!held.warnings.iter().any(told));
    for group in &held.reduction.groups {
        // A group may be as large as its members together.
        let room: f64 = 1e-4 * (1.0 + group.members.iter().map(|m| m.1.abs()).sum::<f64>());
        assert!(held.fitted.coefficients()[group.column].abs() <= room * (1.0 + 1e-12));
    }
}

#[test]
fn whole_effects_enter_or_stay_out() {
    let (chain, data) = heavy(120);
    let joint = |k: usize| JointId(k);
    let mut effects: Vec<Box<dyn AnyEffect>> = vec![
        Box::new(Geometric::default()),
        Box::new(JointCompliance::of(joint(3))),
        Box::new(Transmission::of(joint(2), 0.21)),
        Box::new(Transmission::of(joint(5), 0.33)),
        Box::new(Backlash::of(joint(4), Side::Approach)),
        Box::new(LoadNonlinearity::of(joint(6))),
    ];
    let coupling = serde_json::json!({ "joint": 5, "driver": 2, "degree": 2 });
    let coupling: Coupling = serde_json::from_value(coupling).unwrap();
    effects.push(Box::new(coupling));
    let model = ErrorModel::new(chain, effects).unwrap();
    let found = fit(&model, &data, &*solver("group_lasso(cv, one_se)"), &plain()).unwrap();
    let coefficients = found.fitted.coefficients();
    let mut out = Vec::new();
    for effect in 0..model.effects().len() {
        let mine = found.reduction.kept.iter().filter(|&&c| model.effect_of(c) == effect);
        let values: Vec<f64> = mine.map(|&c| coefficients[c]).collect();
        let zeros = values.iter().filter(|v| **v == 0.0).count();
        assert!(zeros == 0 || zeros == values.len(), "effect {effect} is cut in two: {values:?}");
        out.push(zeros > 0);
    }
    assert!(!out[0] && !out[1], "what is there enters: {out:?}");
    assert!(out[2..].iter().filter(|o| **o).count() >= 4, "what is not stays out: {out:?}");
    let told = found.warnings.iter().filter(|w| matches!(w, Warning::LeftOut { .. })).count();
    assert_eq!(told, out.iter().filter(|o| **o).count());
}
