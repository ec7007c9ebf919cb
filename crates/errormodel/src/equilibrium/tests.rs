//! Where robots come to rest, by formulas of the test's own.

use super::*;
use crate::Schema;
use crate::effects::{Geometric, JointCompliance, LinkCompliance};
use truepose_kinematics::{JointId, Load, Payload, samples};

/// One turn about a horizontal axis with a mass at the end of an arm: `k δ = m g l cos(q + δ)`, solved by bisection.
#[test]
fn a_spring_holds_the_weight_where_it_comes_to_rest() {
    let chain = samples::ur10();
    let model = ErrorModel::new(chain.clone(), vec![Box::new(JointCompliance::of(JointId(2)))]).unwrap();
    let bound = model.bind(&Schema { load: true, ..Schema::default() }).unwrap();
    let load = Load::Payload(Payload { mass: 60.0, com: Vector3::new(0.0, 0.0, 0.1) });
    let q = [0.0, -0.4, 0.0, 0.0, 0.0, 0.0];
    let (conditions, compliance) = (Conditions::at(&chain, &q).with_load(load), 1e-5);
    let mut rest = Equilibrium::new(&model);
    rest.settle(&bound, &conditions, &[compliance]);
    let found = rest.real().after(FrameId(1)).rotation.column(0).angle(&Vector3::x());
    let torque = |delta: f64| {
        let mut bent = conditions.clone();
        bent.joints[1] += delta;
        PostureBuffer::new(&chain).update(&chain, &bent).joint_load(JointId(2))
    };
    let (mut low, mut high) = (0.0, 0.05_f64.copysign(torque(0.0)));
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if compliance * torque(middle) / middle > 1.0 { low = middle } else { high = middle }
    }
    // 7 mrad, of which the nominal posture's weights would miss 1 %; rad.
    assert!(low.abs() > 5e-3, "{low}");
    assert!((found - low.abs()).abs() < 1e-7, "{found} against {low}");
    let nominal = compliance * torque(0.0);
    assert!((nominal.abs() - low.abs()).abs() > 1e-5, "{nominal} against {low}");
}

#[test]
fn more_steps_change_nothing_that_matters() {
    let chain = samples::heavy();
    let effects: Vec<Box<dyn crate::AnyEffect>> = vec![
        Box::new(Geometric::default()),
        Box::new(JointCompliance::default()),
        Box::new(LinkCompliance::default()),
    ];
    let model = ErrorModel::new(chain.clone(), effects).unwrap();
    let bound = model.bind(&Schema { load: true, ..Schema::default() }).unwrap();
    let c: Vec<f64> = model.columns().iter().map(|column| 0.1 * column.scale).collect();
    let load = Load::Payload(Payload { mass: 150.0, com: Vector3::new(0.1, 0.0, 0.2) });
    let conditions = Conditions::at(&chain, &[0.3, -0.4, 0.5, 0.6, -0.7, 0.8]).with_load(load);
    let mut rest = Equilibrium::new(&model);
    rest.settle(&bound, &conditions, &c);
    let tool = *rest.real().tool();
    for _ in 0..5 {
        let mut real = rest.real.clone();
        std::mem::swap(&mut real, &mut rest.real);
        let posture =
            rest.posture.settle(&chain, &conditions, &chain.gravity_in_measurement_frame(), |frame| {
                *real.after(frame)
            });
        bound.emit(&posture, &mut rest.emission);
        rest.errors.weigh(&rest.emission, &c);
        rest.real.update(&posture, &rest.errors);
    }
    let moved = (rest.real().tool().translation - tool.translation).norm();
    let bent = (tool.translation - chain.forward(&conditions.joints).translation).norm();
    // The second power of a hundredth, and a factor for the lever.
    assert!(bent > 1e-3 && moved < 1e-3 * bent, "{moved} of {bent}");
}

/// Servo arms yield by degrees: where they come to rest is `δ = c τ(q + δ)`, and what a further compliance does is
/// `dδ/dc = τ/(1 − c ∂τ/∂q)`, by differences of that.
#[test]
fn a_soft_arm_comes_to_rest_and_its_slope_is_that_of_the_rest() {
    let chain = samples::ur10();
    let of = |joint: usize| Box::new(JointCompliance::of(JointId(joint))) as Box<dyn crate::AnyEffect>;
    let model = ErrorModel::new(chain.clone(), vec![of(2), of(3), Box::new(Geometric::default())]).unwrap();
    let bound = model.bind(&Schema { load: true, ..Schema::default() }).unwrap();
    let load = Load::Payload(Payload { mass: 10.0, com: Vector3::new(0.02, 0.01, 0.1) });
    let conditions = Conditions::at(&chain, &[0.3, -0.9, 0.7, 0.2, 0.4, 0.1]).with_load(load);
    let mut c = vec![0.0; model.columns().len()];
    (c[0], c[1]) = (8e-4, 6e-4);
    let mut rest = Equilibrium::new(&model).soft(true);
    let mut tip = |c: &[f64]| {
        rest.settle(&bound, &conditions, c);
        rest.real().tool().translation
    };
    let at = tip(&c);
    let mut by_hand = conditions.clone();
    for _ in 0..200 {
        let mut buffer = PostureBuffer::new(&chain);
        let posture = buffer.update(&chain, &by_hand);
        let turns = [2, 3].map(|joint| posture.joint_load(JointId(joint)));
        by_hand.joints[1] = conditions.joints[1] + c[0] * turns[0];
        by_hand.joints[2] = conditions.joints[2] + c[1] * turns[1];
    }
    let expected = chain.forward(&by_hand.joints).translation;
    let bent = (chain.forward(&conditions.joints).translation - expected).norm();
    assert!(bent > 0.05 && (at - expected).norm() < 1e-9, "{} of {bent}", (at - expected).norm());
    for column in (0..c.len()).filter(|&k| model.columns()[k].scale > 0.0) {
        let step = 1e-3 * if column < 2 { 1e-2 } else { 1.0 };
        let mut moved = |by: f64| {
            let mut c = c.clone();
            c[column] += by * step;
            tip(&c)
        };
        let difference = (8.0 * (moved(1.0) - moved(-1.0)) - moved(2.0) + moved(-2.0)) / (12.0 * step);
        let mut again = Equilibrium::new(&model).soft(true);
        again.settle(&bound, &conditions, &c);
        let slope = again.slope(&bound, &conditions, &c).expect("soft");
        let jacobian = crate::ErrorJacobian::new(&chain, again.real(), again.errors(), None).matrix(&chain);
        let followed = jacobian.fixed_rows::<3>(0).columns(0, slope.nrows()) * slope;
        let entries = again.emission().entries().iter().filter(|entry| entry.column == column);
        let found: Vector3<f64> = entries
            .map(|entry| {
                entry.value * followed.column(chain.site_index(entry.site).min(followed.ncols() - 1))
            })
            .sum();
        assert!(
            (found - difference).norm() < 1e-6 * (1.0 + difference.norm()),
            "{column}: {found} {difference}"
        );
    }
}
