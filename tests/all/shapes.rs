//! Parameters in which an effect is not linear are found from wrong starts, on plants that know nothing of the model.

use nalgebra::Vector3;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use truepose_errormodel::effects::{Geometric, Shift, Spot, Thermal, Transmission};
use truepose_errormodel::{AnyEffect, Dataset, ErrorModel};
use truepose_identify::{
    FitOptions, FittedNonlinear, Folds, Identification, IdentificationOptions, Method, NonlinearSearch,
    Split, Warning, cross_validate, fit, identify,
};
use truepose_kinematics::{Chain, FrameId, JointId, Placed, Pose, samples};
use truepose_simulate::physics::temperature::Shop;
use truepose_simulate::{Campaign, ChannelPlan, Flaws, Plant, flaws};
use truepose_solvers::{PivotedQr, SolverSpec};

/// A UR10 with a tool, so that every joint shows.
fn chain() -> Chain {
    let tool = Pose::new(nalgebra::Matrix3::identity(), Vector3::new(0.05, 0.03, 0.1));
    samples::ur10().with_tool(Placed { pose: tool, known: true }).unwrap()
}

/// Constant errors, and what a test adds; a tracker of 20 µm.
fn plant(add: impl FnOnce(&mut Flaws), shop: Shop) -> Plant {
    let geometric = flaws::Geometric { position_mm: 0.3, angle_mrad: 0.4, ..flaws::Geometric::default() };
    let mut flaws = Flaws { geometric: Some(geometric), ..Flaws::default() };
    add(&mut flaws);
    let (truth, blunders) = flaws.on(&chain(), &shop, 7).unwrap();
    let mut plant = Plant::new(&chain(), truth).unwrap();
    plant.instrument.sd = 2e-5;
    (plant.shop, plant.blunders) = (shop, blunders);
    plant
}

fn measure(plant: &Plant, visits: usize, channels: Vec<ChannelPlan>) -> Dataset {
    let campaign = Campaign::random(plant.chain(), visits, 3).unwrap().with_channels(channels);
    plant.measure(&campaign, 3).unwrap()
}

fn identified(data: &Dataset, effect: Box<dyn AnyEffect>, shapes: NonlinearSearch) -> Identification {
    let effects: Vec<Box<dyn AnyEffect>> = vec![Box::new(Geometric::default()), effect];
    let options = IdentificationOptions {
        fit: FitOptions { shapes, ..FitOptions::default() },
        ..IdentificationOptions::default()
    };
    identify(&chain(), &effects, data, &PivotedQr::default(), &options, &|_| ()).unwrap()
}

#[track_caller]
fn only(found: &Identification) -> &FittedNonlinear {
    assert_eq!(found.fit.shapes.len(), 1);
    let shape = &found.fit.shapes[0];
    let stored = found.fit.fitted.model().effects()[shape.effect].shape();
    assert_eq!(stored[0].value.to_bits(), shape.value.to_bits(), "the model holds the value that was found");
    shape
}

/// Sixty-one waves a turn: over the visited range there are a hundred valleys, and the start is in a wrong one.
fn mesh() -> Dataset {
    let gear = flaws::Transmission {
        joint: "j2".into(),
        wheel: flaws::Wheel::Mesh,
        amplitude_mrad: 0.15,
        cycles: Some(61.0),
        ..flaws::Transmission::default()
    };
    measure(&plant(|f| f.transmission.push(gear), Shop::steady(20.0).unwrap()), 250, Vec::new())
}

fn wave(period: f64, range: [f64; 2]) -> Transmission {
    Transmission { period_range: Some(range), ..Transmission::of(JointId(2), period) }
}

#[test]
fn a_period_is_found_from_a_wrong_start() {
    let data = mesh();
    let truth = std::f64::consts::TAU / 61.0;
    let free: Box<dyn AnyEffect> = Box::new(wave(0.31, [0.06, 0.5]));
    let found = identified(&data, free.clone(), NonlinearSearch::Profiled);
    let shape = only(&found);
    assert!((shape.value / truth - 1.0).abs() < 2e-4, "{shape:?}, true {truth}");
    assert!(shape.interval[0] < truth && truth < shape.interval[1], "{shape:?}, true {truth}");
    assert!(found.fit.converged && !shape.at_bound());

    // Taken as it stands it explains nothing.
    let fixed = identified(&data, free.clone(), NonlinearSearch::Fixed);
    assert!(fixed.fit.shapes.is_empty());
    assert!(found.fit.positions().rms < 0.6 * fixed.fit.positions().rms);
    let held = |i: &Identification| i.declared.held_out.as_ref().unwrap().residuals.positions().rms;
    assert!(held(&found) < 0.6 * held(&fixed), "{} {}", held(&found), held(&fixed));

    // Side by side with the coefficients, the same optimum.
    let joint = identified(&data, free, NonlinearSearch::Joint);
    let sd = (shape.interval[1] - shape.interval[0]) / 4.0;
    assert!((only(&joint).value - shape.value).abs() < 1e-3 * sd);
}

#[test]
fn at_the_optimum_no_neighbouring_period_fits_better() {
    let data = mesh();
    let found = identified(&data, Box::new(wave(0.31, [0.06, 0.5])), NonlinearSearch::Profiled);
    let shape = only(&found);
    let sd = (shape.interval[1] - shape.interval[0]) / 4.0;
    let options = FitOptions {
        shapes: NonlinearSearch::Fixed,
        noise: truepose_identify::NoiseSource::Fixed(found.fit.noise),
        // As loose as a kind of few unknowns is held: the four of a wave hardly feel it.
        prior: truepose_identify::PriorStrength::Fixed(found.fit.prior.kappa.max(10.0)),
        ..FitOptions::default()
    };
    let left = |period: f64| {
        let effects: Vec<Box<dyn AnyEffect>> =
            vec![Box::new(Geometric::default()), Box::new(Transmission::of(JointId(2), period))];
        let model = ErrorModel::new(chain(), effects).unwrap();
        let fit = fit(&model, &data, &PivotedQr::default(), &options).unwrap();
        fit.chi_square + fit.prior.penalty(&fit.reduction.grouped(fit.fitted.coefficients()))
    };
    let (below, here, above) = (left(shape.value - sd), left(shape.value), left(shape.value + sd));
    // One standard deviation away costs one: the interval is what it says.
    for worse in [below - here, above - here] {
        assert!((0.6..1.6).contains(&worse), "{worse}");
    }
}

#[test]
fn the_instant_of_a_shift_is_found_between_two_visits() {
    let bump = flaws::Shift { at: "base".into(), when_s: 4321.0, size_mm: 0.25, size_mrad: 0.1 };
    let data = measure(&plant(|f| f.shift.push(bump), Shop::steady(20.0).unwrap()), 250, Vec::new());
    let shift = Shift { at_range: Some([300.0, 7000.0]), ..Shift::of(Spot::Frame(FrameId::BASE), 600.0) };
    let found = identified(&data, Box::new(shift), NonlinearSearch::Profiled);
    let shape = only(&found);
    assert!(shape.interval[0] <= 4321.0 && 4321.0 <= shape.interval[1], "{shape:?}");
    assert!(shape.interval[1] - shape.interval[0] < 100.0, "a visit takes half a minute: {shape:?}");
    assert!(found.fit.positions().rms < 4.5e-5, "{}", found.fit.positions().rms);
}

/// A link that follows the air ten minutes late, with a thermometer in the air.
#[test]
fn a_lag_is_found_from_a_wrong_start() {
    let mut rng = ChaCha8Rng::seed_from_u64(4);
    let shop = Shop::day((18.0, 8.0, 3.0), 9000.0, &mut rng).unwrap();
    let late =
        flaws::Thermal { at: "j2".into(), per_kelvin: 23.0, lag_s: 600.0, ..flaws::Thermal::default() };
    let plant = plant(|f| f.thermal.push(late), shop);
    let air = ChannelPlan::Air { name: "temperature".into(), sd: 0.01 };
    let data = measure(&plant, 300, vec![air]);
    let growth = Thermal {
        lag: Some(60.0),
        lag_range: Some([30.0, 6000.0]),
        ..Thermal::of(Spot::Joint(JointId(2)), "temperature")
    };
    let found = identified(&data, Box::new(growth), NonlinearSearch::Profiled);
    let shape = only(&found);
    // A thermometer, a link of 0.6 m and 20 µm of noise tell it to a fifth or so.
    assert!(shape.interval[0] < 600.0 && 600.0 < shape.interval[1], "{shape:?}");
    assert!(shape.interval[1] - shape.interval[0] < 400.0, "{shape:?}");

    // Whoever uses the fit needs the thermometer and the time, and nothing else.
    let folds = Folds::new(&data, &Split::TimeBlocks { folds: 4 }).unwrap();
    cross_validate(&found.fit, &data, &folds, &PivotedQr::default(), Method::Auto).unwrap();
    let seen = truepose_identify::Residuals::of(&found.fit.fitted, &data).unwrap();
    assert!(seen.positions().rms < 5e-5);
}

#[cfg(feature = "slow")]
#[test]
fn two_at_once_from_wrong_starts_with_wrong_rows() {
    let mut plant = plant(
        |f| {
            for (joint, cycles) in [("j2", 61.0), ("j3", 36.0)] {
                f.transmission.push(flaws::Transmission {
                    joint: joint.into(),
                    wheel: flaws::Wheel::Mesh,
                    amplitude_mrad: 0.15,
                    cycles: Some(cycles),
                    ..flaws::Transmission::default()
                });
            }
        },
        Shop::steady(20.0).unwrap(),
    );
    (plant.blunders.outlier_share, plant.blunders.outlier_size) = (0.05, 2e-3);
    let data = measure(&plant, 300, Vec::new());
    let free = |joint: usize, start: f64| {
        let wave =
            Transmission { period_range: Some([0.08, 0.3]), ..Transmission::of(JointId(joint), start) };
        Box::new(wave) as Box<dyn AnyEffect>
    };
    let effects = vec![Box::new(Geometric::default()) as Box<dyn AnyEffect>, free(2, 0.2), free(3, 0.09)];
    let model = ErrorModel::new(chain(), effects).unwrap();
    let solver = "tukey(qr)".parse::<SolverSpec>().unwrap().build();
    let found = fit(&model, &data, &*solver, &FitOptions::default()).unwrap();
    for (shape, cycles) in found.shapes.iter().zip([61.0, 36.0]) {
        let truth = std::f64::consts::TAU / cycles;
        assert!((shape.value / truth - 1.0).abs() < 1e-3, "{shape:?}, true {truth}");
    }
}

#[test]
fn of_an_effect_that_was_left_out_nothing_is_known() {
    // A gear without waves, under a penalty that leaves the effect out as a whole.
    let data = measure(&plant(|_| (), Shop::steady(20.0).unwrap()), 80, Vec::new());
    let effects: Vec<Box<dyn AnyEffect>> =
        vec![Box::new(Geometric::default()), Box::new(wave(0.31, [0.2, 0.5]))];
    let model = ErrorModel::new(chain(), effects).unwrap();
    let solver = "group_lasso(ratio=0.2)".parse::<SolverSpec>().unwrap().build();
    let found = fit(&model, &data, &*solver, &FitOptions::default()).unwrap();
    assert!(found.warnings.iter().any(|w| matches!(w, Warning::LeftOut { .. })), "{:?}", found.warnings);
    let [lower, upper] = found.shapes[0].interval;
    assert!((lower - 0.2).abs() < 1e-15 && (upper - 0.5).abs() < 1e-15, "{:?}", found.shapes);
}

#[test]
fn a_range_without_the_truth_in_it_says_so() {
    let data = mesh();
    let truth = std::f64::consts::TAU / 61.0;
    // The best value lies just below the range: its valley is cut in half.
    let found =
        identified(&data, Box::new(wave(0.2, [1.0008 * truth, 1.01 * truth])), NonlinearSearch::Profiled);
    let told = |w: &Warning| matches!(w, Warning::NonlinearAtBound { name, .. } if name == "period");
    assert!(found.fit.warnings.iter().any(told), "{:?} {:?}", found.fit.shapes, found.fit.warnings);
}
