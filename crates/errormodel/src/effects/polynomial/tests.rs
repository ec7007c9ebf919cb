use super::*;
use crate::testkit::{check_effect, emitted};
use truepose_kinematics::nalgebra::vector;
use truepose_kinematics::{Conditions, Load, Payload, samples};

fn paper() -> Polynomial {
    Polynomial { small: vec![JointId(5), JointId(6)], ..Polynomial::of(3, vec![WrenchComponent::Fy]) }
}

#[test]
fn conforms() {
    for chain in samples::all() {
        check_effect(&Polynomial::of(2, vec![]), &chain);
        let wrench = vec![WrenchComponent::Fz, WrenchComponent::Mx];
        for wrench_of in [WrenchOf::Tool, WrenchOf::Frame] {
            let components = Some(vec![Axis::Tz, Axis::Rx]);
            let of = Polynomial::of(2, wrench.clone());
            check_effect(&Polynomial { wrench_of, components, wrench_degree: 2, ..of }, &chain);
        }
    }
}

#[test]
fn the_papers_robot_has_318_terms() {
    // Six components × (16 + 13 + 10 + 7 + 4 + 3): per joint a constant, its own powers, the load, and the load
    // times the powers of the joints beyond; cubic but for roll and pitch.
    let chain = samples::pps();
    let columns = Effect::columns(&paper(), &chain);
    assert_eq!(columns.len(), 318);
    let per_site = |word: &str| columns.iter().filter(|c| c.name.starts_with(word)).count();
    let counts: Vec<usize> =
        chain.joints().iter().map(|joint| per_site(&format!("rx@{}", joint.name))).collect();
    assert_eq!(counts, [16, 13, 10, 7, 4, 3]);
    let of_roll: Vec<&str> =
        columns.iter().filter(|c| c.name.starts_with("z@roll")).map(|c| c.name.as_str()).collect();
    assert_eq!(of_roll, ["z@roll", "z@roll · roll", "z@roll · fy", "z@roll · pitch·fy"]);
    let degrees = Some(vec![3, 3, 3, 3, 1, 1]);
    let same = Polynomial { degrees, small: Vec::new(), ..paper() };
    assert_eq!(Effect::columns(&same, &chain), columns);
}

#[test]
fn with_standard_dh_a_joint_acts_on_the_frame_in_front_of_it() {
    let chain = samples::ur10();
    let columns = Effect::columns(&Polynomial::of(1, vec![WrenchComponent::Fz]), &chain);
    let at = |word: &str| -> Vec<&str> {
        columns.iter().map(|c| c.name.as_str()).filter(|name| name.starts_with(word)).collect()
    };
    assert_eq!(at("rz@j5"), ["rz@j5", "rz@j5 · j6", "rz@j5 · fz", "rz@j5 · j6·fz"]);
    assert_eq!(at("rz@base")[..2], ["rz@base", "rz@base · j1"]);
    assert!(at("rz@j6").is_empty());
}

#[test]
fn names_and_values_belong_together() {
    let chain = samples::pps();
    let effect = Polynomial { wrench_degree: 2, ..paper() };
    let columns = Effect::columns(&effect, &chain);
    let q = [0.3, 0.1, -0.4, 0.6, 0.02, -0.03];
    let load = Load::Payload(Payload { mass: 70.0, com: vector![0.1, 0.05, -0.8] });
    let conditions = Conditions::at(&chain, &q).with_load(load);
    let tool = chain.forward(&q);
    let fy = (tool.rotation.transpose() * vector![0.0, -9.81 * 70.0, 0.0]).y;
    let entries = emitted(&effect, &chain, &conditions);
    assert_eq!(entries.len(), columns.len());
    let value = |name: &str| {
        let k = columns.iter().position(|c| c.name == name).unwrap();
        entries.iter().find(|e| e.column == k).unwrap().value
    };
    let checks = [
        ("x@d1 · d1^3", 0.3_f64.powi(3)),
        ("ry@d2 · fy", fy),
        ("ry@d2 · theta^2·fy^2", 0.36 * fy * fy),
        ("z@theta · pitch·fy", -0.03 * fy),
    ];
    for (name, expected) in checks {
        assert!((value(name) - expected).abs() < 1e-9 * expected.abs(), "{name}");
    }
}

#[test]
fn a_grouped_error_has_the_union_of_its_members_terms() {
    let chain = samples::pps();
    let group = |frame: usize, component, of: &[usize]| GroupedError {
        frame: FrameId(frame),
        component,
        of: of.iter().map(|&f| FrameId(f)).collect(),
    };
    let grouped = Polynomial {
        order: Order::ReduceFirst,
        groups: Some(vec![group(1, Axis::Tx, &[1]), group(4, Axis::Ty, &[4, 2, 3])]),
        ..paper()
    };
    check_effect(&grouped, &chain);
    let columns = Effect::columns(&grouped, &chain);
    // d1: 1, d1³, fy × (1 + 3·3 + 2·1); theta with d2 and d3: 1, 3 × 3 powers, fy × (1 + 2·3 + 2·1), d2's reach.
    let of = |word: &str| columns.iter().filter(|c| c.name.starts_with(word)).count();
    assert_eq!((of("x@d1"), of("y@theta"), columns.len()), (16, 10 + 9, 35));
    let own = Effect::columns(&Polynomial { groups: None, ..grouped.clone() }, &chain);
    assert_eq!(own, Effect::columns(&paper(), &chain), "each its own, until the groups are known");
    let text = serde_json::to_string(&grouped).unwrap();
    assert_eq!(serde_json::from_str::<Polynomial>(&text).unwrap(), grouped);
    let frames = Polynomial { wrench_of: WrenchOf::Frame, ..grouped };
    check_effect(&frames, &chain);
    let names: Vec<String> = Effect::columns(&frames, &chain).into_iter().map(|c| c.name).collect();
    assert!(
        names.contains(&"y@theta · fy(d2)".to_string()) && names.contains(&"y@theta · fy".to_string()),
        "{names:?}"
    );
}
