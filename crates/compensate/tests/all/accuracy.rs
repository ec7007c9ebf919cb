//! Bands hold what they promise, maps show it.

use crate::fits::{Draw, elastic};
use truepose_compensate::{MapGrid, MapOptions, Status, accuracy_map, predicted_error};
use truepose_errormodel::{FittedModel, Schema};
use truepose_kinematics::nalgebra::Vector3;
use truepose_kinematics::{Conditions, samples};

/// Coefficients drawn from the fit's own covariance: the truth lies within the band as often as it says.
#[test]
fn bands_hold_95_percent() {
    let chain = samples::heavy();
    let mut fit = elastic(&chain, 5);
    fit.noise.position_sd = 3e-5;
    let schema = Schema { load: true, ..Schema::default() };
    let mut draw = Draw(4);
    let mut normal = move || (0..12).map(|_| draw.next()).sum::<f64>() / 2.0;
    let mut places = Draw(17);
    let (mut model, mut measured, mut count) = (0, 0, 0);
    for _ in 0..1500 {
        let deviations = fit.covariance().diagonal().map(f64::sqrt);
        let drawn: Vec<f64> =
            fit.coefficients().iter().zip(&deviations).map(|(c, sd)| c + sd * normal()).collect();
        let truth = FittedModel::new(fit.model().clone(), drawn, fit.covariance().clone()).expect("a truth");
        let (mut real, mut predictor) =
            (truth.bind(&schema).expect("bound"), fit.bind(&schema).expect("bound"));
        for _ in 0..2 {
            let conditions =
                Conditions::at(&chain, &places.joints(&chain, 0.9)).with_load(crate::fits::load(&chain));
            let said = predicted_error(&fit, &mut predictor, &conditions, None);
            let off = real.predict(&conditions, None).translation
                - predictor.predict(&conditions, None).translation;
            let noise = Vector3::from_fn(|_, _| fit.noise.position_sd * normal());
            model += usize::from(off.norm() <= said.model_95);
            measured += usize::from((off + noise).norm() <= said.measured_95);
            count += 1;
        }
    }
    for inside in [model, measured] {
        let share = f64::from(inside as u32) / f64::from(count);
        assert!((0.93..=0.97).contains(&share), "{share}");
    }
}

#[test]
fn a_map_shows_the_accuracy_before_and_after_compensation() {
    let chain = samples::ur10();
    let mut fit = elastic(&chain, 5);
    fit.noise.position_sd = 2e-5;
    let joints =
        accuracy_map(&fit, &MapOptions { grid: MapGrid::Joints { points: 3 }, ..Default::default() });
    let joints = joints.expect("a map");
    assert_eq!(joints.nodes.len(), 729);
    assert!(joints.before_rms() > 1e-4 && joints.before_max() >= joints.before_rms());
    assert!(
        joints.after_95_max() < 0.5 * joints.before_max(),
        "{} {}",
        joints.after_95_max(),
        joints.before_max()
    );
    let lower = Vector3::new(-1.6, 0.3, 0.1);
    let upper = Vector3::new(0.6, 0.9, 0.6);
    let grid = MapGrid::Positions { lower, upper, points: [6, 4, 3], orientation: None };
    let box_map = accuracy_map(&fit, &MapOptions { grid, ..Default::default() }).expect("a map");
    assert_eq!(box_map.nodes.len(), 72);
    assert!((0.4..0.95).contains(&box_map.reachable()), "{}", box_map.reachable());
    for node in &box_map.nodes {
        let inside = node.status == Status::Ok;
        assert_eq!(inside, node.before.is_finite() && node.after_95.is_finite());
        // Two radii of the arm around its shoulder.
        assert!(!inside || (node.position - Vector3::new(0.0, 0.0, 0.1273)).norm() < 1.4);
    }
    let empty = MapOptions { grid: MapGrid::Joints { points: 0 }, ..Default::default() };
    assert!(accuracy_map(&fit, &empty).is_err());
}
