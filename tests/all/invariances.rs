//! The relations of [`crate::metamorphic`] on small simulated robots; `cargo xtask metamorphic` has them on larger ones.

use crate::metamorphic::case::Case;
use crate::metamorphic::found::{Found, same_inputs};
use crate::metamorphic::relations::RELATIONS;
use rayon::prelude::*;
use truepose_discover::DiscoverOptions;
use truepose_io::{ExportUnits, RobotOptions, Unit, read_robot, write_measurements};
use truepose_simulate::PlantDescription;

const ARM: &str = r#"name = "small"
[units]
length = "mm"
angle = "deg"
[base]
xyz = [100.0, -50.0, 20.0]
rpy = [0.0, 0.0, 15.0]
[[joints]]
name = "j1"
limits = [-170, 170]
dh = { theta = 0, d = 300, a = 150, alpha = 90 }
mass = 20.0
com = [-60, 10, 0]
[[joints]]
name = "j2"
limits = [-120, 120]
dh = { theta = 0, d = 20, a = 400, alpha = 80 }
mass = 12.0
com = [-200, 0, 10]
[[joints]]
name = "d3"
type = "prismatic"
limits = [0, 250]
dh = { theta = 0, d = 100, a = 0, alpha = 0 }
mass = 4.0
com = [0, 0, -50]
[[targets]]
name = "T1"
xyz = [50, 0, 30]
[[targets]]
name = "T2"
xyz = [-20, 60, 0]
"#;

const MODEL: &str = "[[effects]]\nfamily = \"geometric\"\n";

/// What is wrong beside constant errors, and what is found of it.
const HIDDEN: [(&str, &str); 2] = [
    ("[[errors.backlash]]\njoint = \"j1\"\nwidth_mrad = 0.8\n", "backlash joint=j1"),
    ("[[errors.joint_compliance]]\njoint = \"j2\"\nstiffness = 2.0e5\n", "joint_compliance joint=j2"),
];

/// Sixty poses of two targets, each pose with its own temperature, twelve of them a second time.
fn simulated(hidden: &str) -> Case {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    std::fs::write(at("robot.toml"), ARM).unwrap();
    let (chain, _) = read_robot(at("robot.toml"), &RobotOptions::default()).unwrap();
    let plant = format!(
        "seed = 7\n[errors.geometric]\nposition_mm = 0.4\nangle_mrad = 0.5\n{hidden}[instrument]\nsd_um = 15\n\
         [repeatability]\nsd_um = 20\n[campaign]\npostures = \"random\"\nvisits = 36\npayloads_kg = [0, 8]\n\
         com_mm = [30, 0, 80]\nrepeats = 2\n"
    );
    let description = PlantDescription::from_toml(&plant).unwrap();
    let campaign = description.campaign.on(&chain, 7).unwrap();
    let data = description.plant(&chain).unwrap().measure(&campaign, 7).unwrap();
    let units = |word| *Unit::named(word).unwrap();
    let units = ExportUnits { length: units("mm"), angle: units("deg") };
    write_measurements(at("train.csv"), &chain, &data, &units).unwrap();
    Case::of(ARM, MODEL, &std::fs::read_to_string(at("train.csv")).unwrap())
}

fn holds_on(robot: usize) {
    let (hidden, expected) = HIDDEN[robot];
    let options = DiscoverOptions { rotations: 99, ..DiscoverOptions::default() };
    let plain = simulated(hidden);
    let reference = Found::of(&plain, &options).unwrap();
    let words: Vec<&str> = reference.effects.iter().map(|effect| effect.words.as_str()).collect();
    assert_eq!(words, [expected]);
    let broken: Vec<String> = RELATIONS
        .par_iter()
        .step_by(crate::of(1, 16))
        .filter_map(|relation| {
            let mut case = plain.clone();
            (relation.change)(&mut case);
            if same_inputs(&plain, &case) {
                return None;
            }
            let differs = match Found::of(&case, &options) {
                Ok(found) => reference.differs(&found, relation),
                Err(words) => Some(words),
            };
            differs.map(|words| format!("{}: {words}", relation.name))
        })
        .collect();
    assert!(broken.is_empty(), "{}", broken.join("\n"));
}

#[test]
fn twenty_relations_hold_for_a_robot_with_backlash() {
    holds_on(0);
}

#[cfg(feature = "slow")]
#[test]
fn twenty_relations_hold_for_a_robot_that_yields() {
    holds_on(1);
}

/// What is compared is beside its own: an outlier that a bad pose brought stands anywhere among the findings.
#[test]
fn coefficients_are_compared_with_those_of_the_same_finding() {
    use crate::metamorphic::found::Effect;
    use truepose_discover::Verdict;
    let effect = |words: &str, coefficients: &[(f64, f64)]| Effect {
        words: words.into(),
        coefficients: coefficients.to_vec(),
    };
    let found = |effects: Vec<Effect>| Found { effects, verdict: Verdict::Undecided, rms: [0.3, 0.05] };
    let plain =
        found(vec![effect("thermal joint=a2", &[(7.0, 0.1)]), effect("thermal joint=a4", &[(6.0, 0.4)])]);
    let beside = |last: f64| {
        found(vec![
            effect("outlier", &[]),
            effect("thermal joint=a2", &[(7.05, 0.1)]),
            effect("thermal joint=a4", &[(last, 0.4)]),
        ])
    };
    let relation = |name: &str| RELATIONS.iter().find(|relation| relation.name == name).unwrap();
    let bad = relation("one bad pose");
    assert_eq!(plain.differs(&beside(6.1), bad), None);
    assert!(plain.differs(&beside(6.5), bad).unwrap().starts_with("thermal joint=a4: 6.000e0"));
    assert!(plain.differs(&beside(6.1), relation("ids")).unwrap().contains("became"));
    let curve = |coefficients: &[(f64, f64)]| found(vec![effect("load_nonlinearity joint=a2", coefficients)]);
    assert_eq!(curve(&[(3.0, 0.4); 3]).differs(&curve(&[(0.8, 4.0); 4]), bad), None);
    assert!(curve(&[(3.0, 0.4); 3]).differs(&curve(&[(0.8, 4.0); 3]), bad).is_some());
    assert!(curve(&[(3.0, 0.4); 3]).differs(&curve(&[(0.8, 4.0); 4]), relation("ids")).is_some());
}
