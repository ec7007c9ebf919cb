//! Every export is read back and predicted with.

use crate::fits::{Draw, elastic, fitted, of};
use std::cell::OnceCell;
use truepose_compensate::{
    AxisConvention, AxisLink, AxisTableOptions, CompensateError, ExportOptions, axis_table, corrected_chain,
    error_tables, joint_origins,
};
use truepose_errormodel::effects::{Basis, Expansion, Factor, Geometric, Input, Place};
use truepose_errormodel::{FittedModel, GeneralizedErrors, Schema};
use truepose_kinematics::nalgebra::{Matrix3, Vector3};
use truepose_kinematics::{
    Axis, Chain, Conditions, FrameId, Joint, JointId, JointKind, Placement, Pose, Site, TargetId,
    rotation_vector, samples,
};

fn options(chain: &Chain) -> ExportOptions {
    let target = (!chain.targets().is_empty()).then_some(TargetId(1));
    ExportOptions { target, ..ExportOptions::default() }
}

#[test]
fn corrected_origins_predict_as_the_model_does() {
    for chain in samples::all() {
        let fit = of(&chain, vec![Box::new(Geometric::default())], 3);
        let exported = corrected_chain(&fit, &options(&chain)).expect("an export");
        assert!(exported.left_out.is_empty());
        assert!(exported.remaining_error.max < 1e-13, "{}: {:e}", chain.name(), exported.remaining_error.max);
        let mut predictor = fit.bind(&Schema::default()).expect("bound");
        let mut draw = Draw(6);
        for _ in 0..50 {
            let q = draw.joints(&chain, 1.0);
            let real = predictor.predict(&Conditions::at(&chain, &q), None);
            let ours = exported.value.forward(&q);
            assert!((real.rotation - ours.rotation).amax() < 1e-13, "{}", chain.name());
        }
        assert_eq!(exported.value.joints().len(), chain.joints().len());
    }
}

#[test]
fn what_is_left_out_is_named_and_measured() {
    let chain = samples::heavy();
    let fit = elastic(&chain, 3);
    let exported = corrected_chain(&fit, &options(&chain)).expect("an export");
    assert_eq!(exported.left_out, ["joint_compliance"]);
    assert!((1e-4..2e-2).contains(&exported.remaining_error.rms), "{:?}", exported.remaining_error);
    assert!(exported.remaining_error.max >= exported.remaining_error.rms);
}

#[test]
fn tables_of_axes_predict_as_the_model_does() {
    for chain in samples::all() {
        let fit = of(&chain, vec![Box::new(Geometric::default())], 3);
        let table = axis_table(&fit, &options(&chain), &AxisTableOptions::default()).expect("a table");
        assert!(table.remaining_error.max < 1e-12, "{}: {:e}", chain.name(), table.remaining_error.max);
        let size = chain.characteristic_length();
        let hayati =
            table.value.rows.iter().filter(|r| matches!(r.link, Some(AxisLink::Hayati { .. }))).count();
        for row in &table.value.rows {
            if let Some(AxisLink::Common { d, a, .. }) = row.link {
                assert!(d.abs() < 3.0 * size && a.abs() < 3.0 * size);
            }
        }
        match chain.name() {
            // Shoulder, elbow and first wrist joint are parallel.
            "ur10" => assert_eq!(hayati, 2),
            "heavy" => assert_eq!(hayati, 1),
            _ => {}
        }
    }
}

#[test]
fn absurd_tables_are_refused_with_the_reason() {
    let chain = samples::ur10();
    let fit = of(&chain, vec![Box::new(Geometric::default())], 3);
    let plain = AxisTableOptions { hayati: false, ..AxisTableOptions::default() };
    let error = axis_table(&fit, &options(&chain), &plain).expect_err("parallel axes");
    assert!(matches!(error, CompensateError::ParallelAxes { .. }), "{error}");
    assert!(error.to_string().contains("`j2`") || error.to_string().contains("`j3`"), "{error}");
}

#[test]
fn joint_dependent_errors_come_back_from_their_tables() {
    // A gear's error in every joint that turns: a sum over the joints, which tables carry whole.
    for chain in [samples::ur10(), samples::scara()] {
        let fit = fitted(&chain, 3);
        let exported = error_tables(&fit, &options(&chain), 721).expect("tables");
        assert_eq!(
            exported.value.tables.len(),
            chain.movable().iter().filter(|&&j| chain.joint(j).unit() == "rad").count()
        );
        // Linear pieces of half a degree leave 1e-5 of half a milliradian.
        assert!(exported.remaining_error.max < 1e-7, "{}: {:?}", chain.name(), exported.remaining_error);
    }
    let heavy = samples::heavy();
    let exported = error_tables(&elastic(&heavy, 3), &options(&heavy), 41).expect("tables");
    let plain = corrected_chain(&elastic(&heavy, 3), &options(&heavy)).expect("an export");
    // Gravity turns with several joints at once: the tables carry most of it, not all.
    assert!(exported.remaining_error.rms < plain.remaining_error.rms && exported.remaining_error.rms > 1e-6);
    assert!(error_tables(&elastic(&heavy, 3), &options(&heavy), 1).is_err());
}

/// Cells of a CSV file without its comments, header first.
fn cells(text: &str) -> Vec<Vec<String>> {
    let lines = text.lines().filter(|line| !line.starts_with('#'));
    lines.map(|line| line.split(',').map(str::to_string).collect()).collect()
}

fn number(cell: &str) -> f64 {
    if cell.is_empty() { 0.0 } else { cell.parse().expect("a number") }
}

/// Roll, pitch, yaw and a translation, by their definition.
fn placed([x, y, z, roll, pitch, yaw]: [f64; 6]) -> Pose {
    let turned = Pose::rot(2, yaw) * Pose::rot(1, pitch) * Pose::rot(0, roll);
    Pose::new(turned.rotation, Vector3::new(x, y, z))
}

/// A fit whose only errors are constant, and where it says that the robot is.
fn geometric_alone(chain: &Chain, check: impl Fn(&FittedModel, &[f64], &Pose)) {
    let fit = of(chain, vec![Box::new(Geometric::default())], 3);
    let mut predictor = fit.bind(&Schema::default()).expect("bound");
    let mut draw = Draw(6);
    for _ in 0..25 {
        let q = draw.joints(chain, 1.0);
        let real = predictor.predict(&Conditions::at(chain, &q), None);
        check(&fit, &q, &real);
    }
}

#[track_caller]
fn agree(chain: &Chain, a: &Pose, b: &Pose) {
    let (p, r) = ((a.translation - b.translation).norm(), (a.rotation - b.rotation).amax());
    assert!(p < 1e-9 && r < 1e-9, "{}: {p:e} m, {r:e}", chain.name());
}

#[test]
fn files_of_axes_predict_as_the_model_does() {
    for chain in samples::all() {
        for convention in [AxisConvention::Dh, AxisConvention::Mdh] {
            let once = OnceCell::new();
            geometric_alone(&chain, |fit, q, real| {
                let text = once.get_or_init(|| {
                    let table =
                        axis_table(fit, &options(&chain), &AxisTableOptions::default()).expect("a table");
                    table.value.to_csv(convention, &chain, &table.statement())
                });
                assert!(text.starts_with("# carries every effect of the fit\n"), "{text}");
                let mut at = Pose::IDENTITY;
                let mut q = q.iter();
                for row in &cells(text)[1..] {
                    let [theta, d, a, alpha, beta] = std::array::from_fn(|k| number(&row[2 + k]));
                    if row[1].is_empty() {
                        at = at * placed(std::array::from_fn(|k| number(&row[7 + k])));
                        continue;
                    }
                    let moved = *q.next().expect("a value");
                    let (turn, slide) = if row[1] == "revolute" { (moved, 0.0) } else { (0.0, moved) };
                    let screw = Pose::rot(2, theta + turn) * Pose::trans(2, d + slide);
                    let (across, tilt) = (Pose::trans(0, a) * Pose::rot(0, alpha), Pose::rot(1, beta));
                    at = at
                        * match convention {
                            AxisConvention::Dh => screw * across * tilt,
                            AxisConvention::Mdh => across * tilt * screw,
                        };
                }
                agree(&chain, &at, real);
            });
        }
    }
}

#[test]
fn kinematics_files_predict_as_the_model_does() {
    for chain in samples::all() {
        let once = OnceCell::new();
        geometric_alone(&chain, |fit, q, real| {
            let text = once.get_or_init(|| {
                let origins = joint_origins(fit, &options(&chain)).expect("origins");
                origins.value.to_ros_yaml(&origins.statement())
            });
            // Two levels of keys; the third one has the numbers.
            let (mut keys, mut values) = ([String::new(), String::new()], Vec::new());
            let mut axes: Vec<Vector3<f64>> = Vec::new();
            for line in text.lines().filter(|line| !line.starts_with('#')) {
                let depth = line.chars().take_while(|c| *c == ' ').count() / 2;
                let (key, value) = line.trim().split_once(':').expect("a key");
                let key = key.trim_matches('"').to_string();
                match (depth, value.trim()) {
                    (0 | 1, "") => keys[depth] = key,
                    (2, value) if keys[1] == "axes" => {
                        let list: Vec<f64> = value.trim_matches(['[', ']']).split(", ").map(number).collect();
                        axes.push(Vector3::new(list[0], list[1], list[2]));
                    }
                    (2, value) => values.push((keys.clone(), key, number(value))),
                    _ => panic!("{line}"),
                }
            }
            let pose = |top: &str, name: &str| {
                placed(["x", "y", "z", "roll", "pitch", "yaw"].map(|word| {
                    let found =
                        values.iter().find(|(keys, key, _)| keys[0] == top && keys[1] == name && key == word);
                    found.unwrap_or_else(|| panic!("no {name}: {word}")).2
                }))
            };
            let mut at = pose("truepose", "base");
            let mut q = q.iter();
            for (k, joint) in chain.joints().iter().enumerate() {
                at = at * pose("kinematics", &joint.name);
                let axis = axes.get(k).copied().unwrap_or(Vector3::z());
                match joint.kind {
                    JointKind::Fixed => {}
                    JointKind::Revolute => {
                        let turn = rotation_vector(&(axis * *q.next().expect("a value")));
                        at = at * Pose::new(turn, Vector3::zeros());
                    }
                    JointKind::Prismatic => {
                        let slide = axis * *q.next().expect("a value");
                        at = at * Pose::new(Matrix3::identity(), slide);
                    }
                }
            }
            agree(&chain, &(at * pose("truepose", "tool")), real);
        });
    }
}

#[test]
fn files_of_component_errors_predict_as_the_model_does() {
    for chain in [samples::ur10(), samples::scara(), samples::pps()] {
        let fit = fitted(&chain, 3);
        let exported = error_tables(&fit, &options(&chain), 721).expect("tables");
        let text = exported.value.to_csv(&chain, &exported.statement());
        let rows = cells(&text);
        let mut draw = Draw(8);
        for _ in 0..20 {
            let q = draw.joints(&chain, 0.99);
            let mut read = GeneralizedErrors::zero(&chain);
            // Constants, then of each joint the piece of every component that q falls into.
            let mut pieces: Vec<(&[String], &[String])> = Vec::new();
            for (k, row) in rows[1..].iter().enumerate() {
                let component = Axis::from_word(&row[4]).expect("a component");
                let site = match row[3].strip_prefix("target ") {
                    Some(name) => Site::Target(chain.target_named(name).expect("a target"), component),
                    None => {
                        let frame = match row[3].as_str() {
                            "base" => FrameId(0),
                            "tool" => chain.tool_frame(),
                            name => FrameId(chain.joint_named(name).expect("a joint").0),
                        };
                        Site::Frame(frame, component)
                    }
                };
                if row[0].is_empty() {
                    read.add(site, number(&row[5]));
                    continue;
                }
                let joint = chain.joint_named(&row[0]).expect("a joint");
                let value = q[chain.coordinate(joint).expect("a movable joint")];
                let same = |next: &&Vec<String>| [0, 2, 3, 4].iter().all(|&cell| next[cell] == row[cell]);
                let Some(next) = rows.get(k + 2).filter(same) else {
                    continue;
                };
                let (low, high) = (number(&row[1]), number(&next[1]));
                if low <= value && value < high {
                    pieces.push((row, next));
                    let share = (value - low) / (high - low);
                    read.add(site, number(&row[5]) * (1.0 - share) + number(&next[5]) * share);
                }
            }
            let ours = exported.value.errors(&chain, &q);
            for k in 0..chain.site_count() {
                let site = chain.site_at(k);
                assert!((ours.get(site) - read.get(site)).abs() < 1e-15, "{} {site:?}", chain.name());
            }
            assert!(!pieces.is_empty());
        }
    }
}

#[test]
fn slides_have_the_letters_of_the_standard() {
    // A slide along z of the base whose frame keeps the base's axes: positioning is EZZ, roll is ECZ.
    let place = Placement::Origin { pose: Pose::trans(0, 0.5), axis: Vector3::z_axis() };
    let slide = Joint::new("lift", JointKind::Prismatic, place).with_limits(0.0, 2.0);
    let chain = Chain::new("lift", vec![slide]).expect("a chain");
    let lift = JointId(1);
    let effect = Expansion {
        at: Place::Frame { frame: FrameId(1), components: Axis::ALL.to_vec() },
        factors: vec![Factor { of: Input::Joint(lift), basis: Basis::Powers(vec![1]) }],
    };
    let fit = of(&chain, vec![Box::new(effect)], 3);
    let tables = error_tables(&fit, &ExportOptions::default(), 3).expect("tables");
    let text = tables.value.to_csv(&chain, &[]);
    let named: Vec<(String, String)> =
        cells(&text)[1..].iter().filter(|r| r[0] == "lift").map(|r| (r[4].clone(), r[7].clone())).collect();
    for (component, iso) in
        [("x", "EXZ"), ("y", "EYZ"), ("z", "EZZ"), ("rx", "EAZ"), ("ry", "EBZ"), ("rz", "ECZ")]
    {
        assert!(named.contains(&(component.into(), iso.into())), "{component} {iso}: {text}");
    }
}
