//! Each mistake is told, and a robot without one is left in peace.

use super::*;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use truepose_errormodel::{Dataset, DatasetBuilder, Measurement};
use truepose_kinematics::nalgebra::Vector3;
use truepose_kinematics::{Chain, JointKind, Placed, Pose, Target, TargetId, samples};

/// A robot with two targets, measured with errors of some millimetres: as a robot before its calibration.
fn measured(chain: &Chain, seed: u64) -> (Chain, Dataset) {
    measured_within(chain, seed, 5e-4)
}

/// The same with errors of this share of its length.
fn measured_within(chain: &Chain, seed: u64, share: f64) -> (Chain, Dataset) {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let target = |name: &str, at: [f64; 3]| Target {
        name: name.into(),
        position: Vector3::from(at),
        known: true,
        tool: truepose_kinematics::ToolId::FIRST,
    };
    let chain = chain
        .clone()
        .with_targets(vec![target("T1", [0.05, 0.0, 0.03]), target("T2", [-0.02, 0.16, 0.0])])
        .and_then(|c| {
            c.with_base(Placed { pose: Pose::from_xyz_rpy([0.3, 0.1, 0.2], [0.1, 0.0, 0.2]), known: true })
        })
        .unwrap();
    let mut builder = DatasetBuilder::new(&chain);
    let length = chain.characteristic_length();
    for row in 0..80 {
        let joints: Vec<f64> = chain
            .movable()
            .iter()
            .map(|&j| {
                let widest = if chain.joint(j).kind == JointKind::Revolute { 1.4 } else { 0.4 };
                rng.random_range(-widest..widest)
            })
            .collect();
        let tool = chain.forward(&joints);
        let target = row % 2;
        let off = Vector3::from_fn(|_, _| rng.random_range(-1.0..1.0)) * share * length;
        let at = tool.apply(&chain.targets()[target].position) + off;
        builder
            .push(Measurement::at(joints).position(at).target(TargetId(target)).visit(row as u64))
            .unwrap();
    }
    (chain, builder.finish())
}

#[test]
fn a_good_table_is_left_in_peace() {
    for (seed, chain) in (0..).zip(samples::all()) {
        let (chain, data) = measured(&chain, seed);
        assert_eq!(suspicion(&chain, &data), None, "{}", chain.name());
    }
}

#[test]
fn every_mistake_is_told() {
    let (chain, good) = measured(&samples::ur10(), 3);
    type Spoil = fn(&mut Dataset);
    let mistakes: [(Cause, Spoil); 14] = [
        (Cause::SwappedAxes { a: 0, b: 1 }, |d| d.position.iter_mut().for_each(|p| p.swap(0, 1))),
        (Cause::SwappedAxes { a: 1, b: 2 }, |d| d.position.iter_mut().for_each(|p| p.swap(1, 2))),
        (Cause::MirroredAxis { axis: 2 }, |d| d.position.iter_mut().for_each(|p| p[2] = -p[2])),
        (Cause::PositionUnit { factor: 1e3 }, |d| d.position.iter_mut().flatten().for_each(|v| *v *= 1e-3)),
        (Cause::PositionUnit { factor: 1.0 / 25.4 }, |d| {
            d.position.iter_mut().flatten().for_each(|v| *v *= 25.4)
        }),
        (Cause::JointUnit { kind: JointKind::Revolute, factor: 180.0 / std::f64::consts::PI }, |d| {
            d.joints.iter_mut().flatten().for_each(|q| *q = q.to_radians());
        }),
        (Cause::ShiftedJoints { by: 1 }, |d| d.joints.rotate_right(1)),
        (Cause::ShiftedJoints { by: 5 }, |d| d.joints.rotate_left(1)),
        (Cause::ReversedJoints, |d| d.joints.reverse()),
        (Cause::SwappedJoints { a: 1, b: 2 }, |d| d.joints.swap(1, 2)),
        (Cause::NegatedJoint { joint: 2 }, |d| d.joints[2].iter_mut().for_each(|q| *q = -*q)),
        (Cause::OffsetJoint { joint: 1, by: std::f64::consts::FRAC_PI_2 }, |d| {
            d.joints[1].iter_mut().for_each(|q| *q -= std::f64::consts::FRAC_PI_2);
        }),
        (Cause::StaleJoints { late: true }, |d| d.joints.iter_mut().for_each(|c| c.rotate_right(1))),
        (Cause::SwappedTargets { a: 0, b: 1 }, |d| {
            d.target.iter_mut().flatten().for_each(|t| t.0 = 1 - t.0);
        }),
    ];
    for (cause, spoil) in mistakes {
        let mut data = good.clone();
        spoil(&mut data);
        let told = suspicion(&chain, &data).unwrap_or_else(|| panic!("nothing was said about {cause:?}"));
        assert_eq!(told.cause, cause, "{told:?}");
        assert!(told.after < 2e-3 && told.before > 5.0 * told.after, "{told:?}");
    }
}

#[test]
fn a_reversed_joint_of_a_servo_arm_is_told_beside_its_own_errors() {
    for joint in [1, 2] {
        let (chain, mut data) = measured_within(&samples::ur10(), 3, 0.025);
        assert_eq!(suspicion(&chain, &data), None);
        data.joints[joint].iter_mut().for_each(|q| *q = -*q);
        let told = suspicion(&chain, &data).unwrap();
        assert_eq!(told.cause, Cause::NegatedJoint { joint }, "{told:?}");
        assert!(told.after > 0.02 * chain.characteristic_length(), "{told:?}");
    }
}

#[test]
fn rows_that_stray_are_named() {
    let (chain, mut data) = measured(&samples::heavy(), 9);
    data.position[17][1] += 0.4;
    data.position[41][2] = 1e20;
    let told = suspicion(&chain, &data).unwrap();
    assert_eq!(told.cause, Cause::StrayRows { rows: vec![41, 17] }, "{told:?}");
    assert!(told.after < 5e-3 && told.before > 1e19, "{told:?}");
}

#[test]
fn a_base_that_stands_elsewhere_is_told_and_one_that_is_unknown_is_not() {
    let (chain, data) = measured(&samples::ur10(), 5);
    let elsewhere = Placed { pose: Pose::from_xyz_rpy([2.0, 0.0, 0.0], [0.0, 0.0, 2.0]), known: true };
    let moved = chain.clone().with_base(elsewhere).unwrap();
    assert_eq!(suspicion(&moved, &data).map(|s| s.cause), Some(Cause::BaseElsewhere));
    let unknown = chain.with_base(Placed { known: false, ..elsewhere }).unwrap();
    assert_eq!(suspicion(&unknown, &data), None);
}

#[test]
fn a_handful_of_rows_says_nothing() {
    let (chain, mut data) = measured(&samples::ur10(), 7);
    data = data.select(&[0, 1, 2, 3]);
    data.position.iter_mut().for_each(|p| p.swap(0, 1));
    assert_eq!(suspicion(&chain, &data), None);
}

#[test]
fn an_outlier_of_millimetres_is_named_and_so_are_several_that_hide_each_other() {
    // Rows are off by up to 2.5 mm and more before the calibration, and by half a millimetre after it.
    let (chain, good) = measured(&samples::ur10(), 21);
    let off = |data: &mut Dataset, row: usize, mm: f64| data.position[row][row % 3] += 1e-3 * mm;
    let mut one = good.clone();
    off(&mut one, 30, 12.0);
    let told = suspicions(&chain, &one);
    assert_eq!(told.len(), 1, "{told:?}");
    assert_eq!(told[0].cause, Cause::StrayRows { rows: vec![30] });
    assert!((told[0].before - 12e-3).abs() < 2e-3 && told[0].after < 2e-3, "{told:?}");
    let mut several = good;
    let rows = [4, 17, 23, 36, 44, 51, 63, 70];
    rows.iter().for_each(|&row| off(&mut several, row, 12.0 + row as f64));
    let told = suspicions(&chain, &several);
    assert_eq!(told.len(), 1, "{told:?}");
    let Cause::StrayRows { rows: named } = &told[0].cause else { panic!("{told:?}") };
    let mut named = named.clone();
    named.sort_unstable();
    assert_eq!(named, rows);
}

#[test]
fn names_that_were_swapped_in_some_rows_are_told_whether_or_not_targets_are_known() {
    for known in [true, false] {
        let (chain, mut data) = measured(&samples::ur10(), 33);
        let targets = chain.targets().iter().map(|t| Target { known, ..t.clone() }).collect();
        let chain = chain.with_targets(targets).unwrap();
        for row in [7, 18, 40, 61] {
            data.target[row] = data.target[row].map(|t| TargetId(1 - t.0));
        }
        data.position[50][2] -= 0.02;
        let told = suspicions(&chain, &data);
        let causes: Vec<Cause> = told.iter().map(|t| t.cause.clone()).collect();
        let swapped = Cause::SwappedLabels { a: 0, b: 1, rows: vec![7, 18, 40, 61] };
        assert_eq!(causes, [swapped, Cause::StrayRows { rows: vec![50] }], "known {known}: {told:?}");
    }
}

/// Rows 20 to 31 are mistaken, and no others.
#[test]
fn a_mistake_in_some_rows_is_named_with_its_rows() {
    let (chain, good) = measured(&samples::ur10(), 5);
    type Spoil = fn(&mut Dataset, usize);
    let mistakes: [(Cause, Spoil); 3] = [
        (Cause::PositionUnit { factor: 25.4 }, |d, row| d.position[row].iter_mut().for_each(|v| *v /= 25.4)),
        (Cause::SwappedAxes { a: 0, b: 2 }, |d, row| d.position[row].swap(0, 2)),
        (Cause::MirroredAxis { axis: 1 }, |d, row| d.position[row][1] *= -1.0),
    ];
    for (mistake, spoil) in mistakes {
        let mut data = good.clone();
        (20..32).for_each(|row| spoil(&mut data, row));
        let told = suspicions(&chain, &data);
        let rows = told.iter().flat_map(|found| match &found.cause {
            Cause::InSomeRows { rows, mistake: of } if **of == mistake => rows.clone(),
            _ => Vec::new(),
        });
        assert!(rows.eq(20..32), "{mistake:?}: {told:?}");
    }
}
