//! The fitted robot in the numbers of its own description, read back and predicted with.

use crate::fits::{Draw, elastic, of};
use truepose_compensate::{
    AxisConvention, ExportOptions, ParameterPart, ParameterTable, PartKind, parameter_table,
};
use truepose_errormodel::effects::Geometric;
use truepose_errormodel::{FittedModel, Schema};
use truepose_kinematics::nalgebra::{DMatrix, DVector, Vector3};
use truepose_kinematics::{Chain, Conditions, Joint, JointId, JointKind, Placement, Pose, samples};

/// The robot that a table describes, multiplied out from its numbers alone.
fn forward(table: &ParameterTable, nominal: &Chain, q: &[f64]) -> Pose {
    let mut at = Pose::IDENTITY;
    let mut q = q.iter();
    let mut parts = table.parts.iter();
    at = at * parts.next().and_then(|base| base.pose()).expect("a base");
    for joint in nominal.joints() {
        if !joint.moves() {
            at = at * joint.transform(0.0);
            continue;
        }
        let part = parts.next().expect("a joint");
        assert_eq!(part.name, joint.name);
        let moved = *q.next().expect("a value");
        let (turn, slide) = if joint.kind == JointKind::Revolute { (moved, 0.0) } else { (0.0, moved) };
        let mut n: Vec<f64> = part.parameters.iter().map(|p| p.calibrated).collect();
        match (part.kind, joint.placement) {
            (PartKind::Origin(_), described) => {
                let axis = match described {
                    Placement::Origin { axis, .. } => axis,
                    _ => Vector3::z_axis(),
                };
                let placement = Placement::Origin { pose: part.pose().expect("a pose"), axis };
                at = at * Joint { placement, ..joint.clone() }.transform(moved);
            }
            (kind, _) => {
                n.resize(5, 0.0);
                let screw = Pose::rot(2, n[0] + turn) * Pose::trans(2, n[1] + slide);
                let (across, tilt) = (Pose::trans(0, n[2]) * Pose::rot(0, n[3]), Pose::rot(1, n[4]));
                at = at
                    * if matches!(kind, PartKind::Dh(_)) {
                        screw * across * tilt
                    } else {
                        across * tilt * screw
                    };
            }
        }
    }
    at * parts.next().and_then(|tool| tool.pose()).expect("a tool")
}

fn of_geometry(chain: &Chain) -> FittedModel {
    of(chain, vec![Box::new(Geometric::default())], 3)
}

#[test]
fn the_table_predicts_as_the_model_does() {
    for chain in samples::all() {
        let fit = of_geometry(&chain);
        // "skewed" by origins: between an origin and a row of dh behind it there is no number for the angle of the two axes.
        let table = parameter_table(&fit, &ExportOptions::default()).expect("a table").value;
        let by_origin = |part: &ParameterPart| !matches!(part.kind, PartKind::Dh(_) | PartKind::Mdh(_));
        assert!(chain.name() != "skewed" || table.parts.iter().all(by_origin));
        let mut predictor = fit.bind(&Schema::default()).expect("bound");
        let mut draw = Draw(6);
        for _ in 0..25 {
            let q = draw.joints(&chain, 1.0);
            let real = predictor.predict(&Conditions::at(&chain, &q), None);
            let ours = forward(&table, &chain, &q);
            let off = (real.translation - ours.translation).norm();
            assert!(off < 1e-8, "{}: {off:e} m", chain.name());
            assert!((real.rotation - ours.rotation).amax() < 1e-8, "{}", chain.name());
        }
    }
}

#[test]
fn rows_stay_on_their_branch() {
    // The maker's a = −612 mm, which a common normal alone makes +612 mm with θ = π.
    let chain = samples::ur10();
    let table = parameter_table(&of_geometry(&chain), &ExportOptions::default()).expect("a table").value;
    for part in &table.parts[1..7] {
        for p in &part.parameters {
            let moved = p.calibrated - p.nominal.expect("described");
            assert!(moved.abs() < 0.01, "{} {}: {moved}", part.name, p.name);
        }
    }
    let a = |part: usize| table.parts[part].parameters[2].calibrated;
    assert!((a(2) + 0.612).abs() < 0.005 && (a(3) + 0.5723).abs() < 0.005);
    // Joints 2, 3 and 4 are parallel: their tilts are Hayati's, and one d stands for all three.
    let hayati: Vec<usize> = (1..7).filter(|&k| table.parts[k].parameters.len() == 5).collect();
    assert_eq!(hayati, [2, 3]);
    let estimated = |part: usize| table.parts[part].parameters[1].standard_uncertainty > 0.0;
    assert_eq!([2, 3, 4].map(estimated).iter().filter(|e| **e).count(), 1);
    let csv = table.to_axes_csv(AxisConvention::Dh, &["a line".into()]).expect("rows of dh");
    assert!(csv.starts_with("# a line\n") && csv.lines().count() == 4 + 8, "{csv}");
    assert!(table.to_axes_csv(AxisConvention::Mdh, &[]).is_none());
}

#[test]
fn zero_offsets_are_found() {
    // A robot whose second and third encoders are off by a known angle, and nothing else.
    let chain = samples::ur10();
    let fit = of_geometry(&chain);
    let n = fit.coefficients().len();
    // With rows of dh joint k turns about z of the frame in front of it.
    let mut wanted = vec![0.0; n];
    for (site, value) in [("j1", 2e-3), ("j2", -1e-3)] {
        let name = format!("rz@{site}");
        let column = fit.model().columns().iter().position(|c| c.name == name).expect("a column");
        wanted[column] = value;
    }
    let columns = fit.model().columns().len();
    let fit = FittedModel::new(fit.model().clone(), wanted, DMatrix::identity(columns, columns) * 1e-10)
        .expect("a fit");
    let table = parameter_table(&fit, &ExportOptions::default()).expect("a table").value;
    let found: Vec<f64> = table.offsets.iter().map(|o| o.offset).collect();
    for (k, expected) in [0.0, 2e-3, -1e-3, 0.0, 0.0, 0.0].into_iter().enumerate() {
        assert!((found[k] - expected).abs() < 1e-9, "{found:?}");
    }
    assert_eq!(table.offsets[0].part_of, Some("base"));
    assert_eq!(table.offsets[5].part_of, Some("tool"));
    assert!(table.offsets[1].standard_uncertainty > 0.0 && table.offsets[0].standard_uncertainty <= 0.0);
}

#[test]
fn zero_offsets_of_coupled_joints_are_those_of_the_readings() {
    // The controller counts joint 3 from the horizontal: q3 = u3 + u2. Joint 2 reads 2 mrad too little, joint 3 itself is right.
    let coupling = truepose_kinematics::Coupling { joint: JointId(3), driver: JointId(2), factor: 1.0 };
    let chain = samples::ur10().with_couplings(vec![coupling]).expect("a coupled robot");
    let fit = of_geometry(&chain);
    let columns = fit.model().columns().len();
    let column = fit.model().columns().iter().position(|c| c.name == "rz@j1").expect("a column");
    let mut wanted = vec![0.0; columns];
    wanted[column] = 2e-3;
    let covariance = DMatrix::identity(columns, columns) * 1e-10;
    let fit = FittedModel::new(fit.model().clone(), wanted, covariance).expect("a fit");
    let table = parameter_table(&fit, &ExportOptions::default()).expect("a table").value;
    let (second, third) = (&table.offsets[1], &table.offsets[2]);
    assert!((second.offset - 2e-3).abs() < 1e-9 && second.of_variable.is_none(), "{second:?}");
    // What has to be added to the readings: with both the variable of joint 3 is what it was.
    assert!((third.offset + 2e-3).abs() < 1e-9, "{third:?}");
    assert!(third.of_variable.is_some_and(|own| own.abs() < 1e-9), "{third:?}");
    let mut readings = vec![0.1, 0.2, 0.3, 0.4, 0.5, 0.6];
    let mut corrected: Vec<f64> = readings.iter().zip(&table.offsets).map(|(u, o)| u + o.offset).collect();
    chain.joints_from_controller(&mut readings);
    chain.joints_from_controller(&mut corrected);
    assert!((corrected[1] - readings[1] - 2e-3).abs() < 1e-9 && (corrected[2] - readings[2]).abs() < 1e-9);
    // Both contribute to the uncertainty.
    assert!(third.standard_uncertainty > second.standard_uncertainty, "{third:?} {second:?}");
}

/// Other coefficients of the same fit, moved by some standard deviations.
fn moved(fit: &FittedModel, by: &DVector<f64>) -> FittedModel {
    let coefficients = fit.coefficients().iter().zip(by.iter()).map(|(c, by)| c + by).collect();
    FittedModel::new(fit.model().clone(), coefficients, fit.covariance().clone()).expect("a fit")
}

#[test]
fn uncertainties_are_those_of_a_sample() {
    // Coefficients drawn from their covariance, and a table for each: the scatter of every number is what the table states.
    for (chain, elastic_too) in
        [(samples::ur10(), false), (samples::heavy(), false), (samples::heavy(), true)]
    {
        let fit = if elastic_too { elastic(&chain, 3) } else { of_geometry(&chain) };
        let options = ExportOptions { samples: 60, ..ExportOptions::default() };
        let stated = parameter_table(&fit, &options).expect("a table").value;
        let root: Vec<f64> = fit.covariance().diagonal().iter().map(|v| v.sqrt()).collect();
        let mut draw = Draw(5);
        let count = if elastic_too { 30 } else { 120 };
        let numbers = |table: &ParameterTable| -> Vec<f64> {
            table.parts.iter().flat_map(|p| p.parameters.iter().map(|p| p.calibrated)).collect()
        };
        let middle = numbers(&stated);
        let mut squares = vec![0.0; middle.len()];
        for _ in 0..count {
            // Uniform numbers of variance one.
            let by = DVector::from_fn(root.len(), |k, _| root[k] * draw.next() * 3f64.sqrt());
            let table = parameter_table(&moved(&fit, &by), &options).expect("a table").value;
            for ((s, v), m) in squares.iter_mut().zip(numbers(&table)).zip(&middle) {
                *s += (v - m).powi(2);
            }
        }
        let all = stated.parts.iter().flat_map(|part| part.parameters.iter().map(move |p| (&part.name, p)));
        for ((part, p), square) in all.zip(squares) {
            let scatter = (square / f64::from(count)).sqrt();
            let u = p.standard_uncertainty;
            if u <= 0.0 {
                // Not estimated: it follows the others by terms of second order, a hundredth of an expected error of 1 mrad or 1 mm/m.
                let expected = if p.unit == "m" { 1e-3 * chain.characteristic_length() } else { 1e-3 };
                assert!(scatter < 0.03 * expected, "{} {part} {}: {scatter:e}", chain.name(), p.name);
                continue;
            }
            // 120 draws: a standard deviation is good to 6.5 %, four of them 26 %; 30 draws: 52 %.
            let within = if elastic_too { 0.52 } else { 0.26 };
            assert!(
                (scatter - u).abs() <= within * u + 1e-9,
                "{} {part} {}: {scatter:e} in the sample, {u:e} stated",
                chain.name(),
                p.name
            );
        }
    }
}

/// A small arm with three parallel joints and slightly skewed origins, as people draw them, whose zeros are off by degrees: origins describe any
/// such robot, and what is off are the zeros.
#[test]
fn origins_describe_an_arm_whose_zeros_are_off_by_degrees() {
    let joint = |k: usize, xyz: [f64; 3], rpy: [f64; 3]| {
        let placement = Placement::Origin { pose: Pose::from_xyz_rpy(xyz, rpy), axis: Vector3::z_axis() };
        Joint::new(format!("j{k}"), JointKind::Revolute, placement)
    };
    // Rounded, as people write them.
    let (half, whole) = (15708e-4, 31416e-4);
    for lean in [0.0, 0.03, 0.3] {
        let joints = vec![
            joint(1, [0.041, 0.0, 0.055], [whole, 0.0, -whole]),
            joint(2, [-0.028, -0.02, -0.06], [-half, -half, 0.0]),
            joint(3, [-0.12, -0.031, 0.0], [0.0, 0.0, half]),
            joint(4, [-0.14, 0.004, 0.0], [0.0, 0.0, -half]),
            joint(5, [0.0, -0.055, 0.02], [half, lean, whole]),
        ];
        let chain = Chain::new("small arm", joints).expect("a robot");
        let offsets = [0.0, 0.05, -0.03, -0.11, 0.07];
        for seed in 1..6 {
            let mut fit = of(&chain, vec![Box::new(Geometric::default())], seed);
            let mut values = fit.coefficients().to_vec();
            for (k, offset) in offsets.iter().enumerate() {
                let name = format!("rz@j{}", k + 1);
                let column = fit.model().columns().iter().position(|c| c.name == name).expect("a column");
                values[column] += offset;
            }
            let covariance = fit.covariance().clone();
            fit = FittedModel::new(fit.model().clone(), values, covariance).expect("a fit");
            let table = parameter_table(&fit, &ExportOptions::default()).expect("a table").value;
            let mut predictor = fit.bind(&Schema::default()).expect("bound");
            let mut draw = Draw(6);
            for _ in 0..10 {
                let q = draw.joints(&chain, 1.0);
                let real = predictor.predict(&Conditions::at(&chain, &q), None);
                let off = (real.translation - forward(&table, &chain, &q).translation).norm();
                assert!(off < 1e-8, "lean {lean}, seed {seed}: {off:e} m");
            }
            let found: Vec<f64> = table.offsets.iter().map(|o| o.offset).collect();
            assert_eq!([table.offsets[0].part_of, table.offsets[4].part_of], [Some("base"), Some("tool")]);
            for k in 1..4 {
                // The arm's other errors, of a tenth of a millimetre and a milliradian, are zeros of its parallel joints in part.
                assert!((found[k] - offsets[k]).abs() < 2e-3, "lean {lean}, seed {seed}: {found:?}");
            }
        }
    }
}
