//! What a person reads and signs, held against simulated truth: names, specifications, the installation of a URDF, logs, bands, zero offsets.

use crate::folder::Folder;
use serde_json::Value;
use std::fmt::Write as _;

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap_or_else(|| panic!("no number: {value}"))
}

/// An eccentric gear of 0.4 mrad imitates a compliance of the same joint: the more probable name is the first, the simpler one beside it.
#[test]
fn the_first_name_is_the_most_probable_one() {
    let folder = Folder::empty();
    folder.run("init irb120 --out robot.toml").ended(0);
    folder.write(
        "plant.toml",
        "robot = \"robot.toml\"\nseed = 1\n[errors.geometric]\nposition_mm = 0.3\nangle_mrad = 0.3\n\
         [[errors.transmission]]\njoint = \"j2\"\namplitude_mrad = 0.4\n[shop]\nstart_c = 20\nrise_k = 3\nhours = 3\n\
         [instrument]\nsd_um = 15\n[repeatability]\nsd_um = 20\n\
         [campaign]\npostures = \"random\"\nvisits = 70\nrepeats = 1\nvisit_s = 60\n",
    );
    folder.run("simulate --plant plant.toml --out data.csv").ended(0);
    let run =
        ["discover", "--robot", "robot.toml", "--data", "data.csv", "--report", "page", "--rivals", "rivals"];
    let out = folder.run(&run).ended(0).out;
    let found = folder.json("page/discovery.json");
    let effect = &found["effects"][0];
    assert_eq!((&effect["family"], &effect["joint"]), (&"transmission".into(), &"j2".into()), "{effect}");
    let coefficient = |k: usize| {
        number(&effect["parameters"][k + effect["parameters"].as_array().unwrap().len() - 2]["value"])
    };
    let amplitude = coefficient(0).hypot(coefficient(1));
    assert!((amplitude - 4e-4).abs() < 3e-5, "{amplitude}");
    let own = number(&effect["name_probability"]);
    let others = effect["alternatives"].as_array().unwrap();
    for other in others {
        assert!(number(&other["probability"]) <= own + 0.005, "{other}");
        assert!((&other["family"], &other["joint"]) != (&effect["family"], &effect["joint"]), "{other}");
    }
    let simplest: Vec<&Value> = others.iter().filter(|other| other["simplest"] == true).collect();
    assert_eq!(simplest.len(), 1);
    assert_eq!(simplest[0]["family"], "joint_compliance");
    let words = "simplest that is not distinguishable: joint_compliance j2";
    assert!(out.contains(words) && folder.read("page/index.html").contains(words), "{out}");
    assert!(folder.file("rivals/1-joint_compliance-j2.json").exists(), "{out}");
    assert!(!folder.file("rivals/1-transmission-j2.json").exists());
}

#[test]
fn a_specification_is_judged_for_what_will_be_done() {
    let folder = Folder::with_data();
    let run = |correction: &[&str], code: i32| {
        let words =
            ["identify", "--robot", "robot.toml", "--data", "data.csv", "--spec", "0.3mm", "--report", "r"];
        let out = folder.run(&[&words[..], correction].concat()).ended(code).out;
        (out, folder.json("r/identification.json")["specification"].clone(), folder.read("r/summary.html"))
    };
    let (out, of, sheet) = run(&[], 1);
    // The plant errs by 0.4 mm and 0.5 mrad in each frame: nothing that is left of it once it is corrected.
    assert_eq!((of["correction"].as_str(), of["verdict"].as_str()), (Some("none"), Some("fail")));
    let cases = of["cases"].as_array().unwrap();
    let rms: Vec<f64> = cases.iter().map(|case| number(&case["rms_mm"])).collect();
    assert!(rms.len() == 3 && rms[0] > 0.3 && rms[1] < 0.15 && rms[2] <= rms[1], "{rms:?}");
    for name in ["as it is (arm", "with constants (", "if compensated ("] {
        let short = name.split(" (").next().unwrap();
        assert!(out.contains(name) && sheet.contains(short), "{name}\n{out}");
    }
    assert!(out.contains("Specification 0.300 mm (as it is): fail."), "{out}");
    assert!(cases.iter().all(|case| case.get("verdict").is_none()));
    let (out, of, _) = run(&["--correction", "constants"], 0);
    assert!(out.contains("Specification 0.300 mm (with constants): "), "{out}");
    assert_eq!(of["correction"], "constants");
    assert_ne!(of["verdict"], "fail");
}

const URDF: &str = r#"<robot name="small">
  <link name="base"/><link name="l1"/><link name="l2"/><link name="l3"/><link name="l4"/><link name="l5"/><link name="l6"/><link name="tip"/>
  <joint name="j1" type="revolute"><origin xyz="0 0 .3"/><parent link="base"/><child link="l1"/><axis xyz="0 0 1"/>
    <limit lower="-2.9" upper="2.9" effort="1" velocity="1"/></joint>
  <joint name="j2" type="revolute"><origin xyz="0 0 0"/><parent link="l1"/><child link="l2"/><axis xyz="0 1 0"/>
    <limit lower="-1.9" upper="1.9" effort="1" velocity="1"/></joint>
  <joint name="j3" type="revolute"><origin xyz="0 0 0.4"/><parent link="l2"/><child link="l3"/><axis xyz="0 1 0"/>
    <limit lower="-2" upper="2" effort="1" velocity="1"/></joint>
  <joint name="j4" type="revolute"><origin xyz="0.3 0 0.07"/><parent link="l3"/><child link="l4"/><axis xyz="1 0 0"/>
    <limit lower="-2.8" upper="2.8" effort="1" velocity="1"/></joint>
  <joint name="j5" type="revolute"><origin xyz="0.1 0 0"/><parent link="l4"/><child link="l5"/><axis xyz="0 1 0"/>
    <limit lower="-2" upper="2" effort="1" velocity="1"/></joint>
  <joint name="j6" type="revolute"><origin xyz="0.08 0 0"/><parent link="l5"/><child link="l6"/><axis xyz="1 0 0"/>
    <limit lower="-3" upper="3" effort="1" velocity="1"/></joint>
  <joint name="flange" type="fixed"><origin xyz="0.02 0 0"/><parent link="l6"/><child link="tip"/></joint>
</robot>
"#;

/// A robot that a tracker four metres away measured, with a marker that the URDF does not know.
fn measured_from_afar() -> Folder {
    let folder = Folder::empty();
    folder.write("arm.urdf", URDF);
    folder.write(
        "arm.toml",
        "urdf = \"arm.urdf\"\n[units]\nlength = \"mm\"\nangle = \"deg\"\n[base]\nxyz = [3200, -1800, 400]\nrpy = [0, 0, 110]\n\
         [tool]\nxyz = [30, 50, 20]\nrpy = [20, 40, 30]\n",
    );
    folder.write(
        "plant.toml",
        "robot = \"arm.toml\"\nseed = 3\n[errors.geometric]\nposition_mm = 0.4\nangle_mrad = 0.5\n\
         [instrument]\nsd_um = 20\norientation_urad = 40\n[campaign]\npostures = \"random\"\nvisits = 80\n",
    );
    folder.run("simulate --plant plant.toml --out data.csv").ended(0);
    folder
}

const FROM_URDF: [&str; 5] = ["identify", "--robot", "arm.urdf", "--data", "data.csv"];

#[test]
fn base_and_tool_of_a_urdf_are_found_and_not_fitted_as_errors() {
    let folder = measured_from_afar();
    let result = folder.run(&[&FROM_URDF[..], &["--out", "fit.json", "--json"]].concat()).ended(0).json();
    assert_eq!(result["placement"]["found"], serde_json::json!(["base", "tool"]), "{}", result["placement"]);
    assert!(result["assumed"][0].as_str().unwrap().contains("base and tool are found from the data"));
    let export = "export --fit fit.json --format urdf --urdf arm.urdf --out new.urdf";
    folder.run(export).ended(0);
    let new = folder.read("new.urdf");
    // The joint on the base and the flange stay as they are; the tracker's frame and the marker are in the comment.
    for joint in ["j1", "flange"] {
        let of = |text: &str| {
            text.lines().find(|line| line.contains(&format!("name=\"{joint}\""))).map(str::to_owned)
        };
        assert_eq!(of(&new), of(URDF), "{new}");
    }
    let at = new.split_once("the base link is in the measurement frame at xyz ").unwrap().1;
    let at: Vec<f64> = at.split(' ').take(3).map(|word| word.parse().unwrap()).collect();
    // Within what the first joint's own error moves.
    for (found, truth) in at.iter().zip([3.2, -1.8, 0.4]) {
        assert!((found - truth).abs() < 2e-3, "{at:?}");
    }
    let known =
        folder.run(&[&FROM_URDF[..], &["--base-known", "--tool-known", "--json"]].concat()).ended(0).json();
    assert!(known.get("assumed").is_none() && number(&known["stages"][0]["train"]["rms_mm"]) > 1000.0);
    let refused = folder.run("identify --robot arm.toml --data data.csv --base-known").ended(2);
    assert!(
        refused
            .log
            .contains("--base-known: only a URDF leaves it open: arm.toml states in [base] what is known"),
        "{}",
        refused.log
    );
}

/// The poses of the data as a log at 200 Hz: stops of 1.5 s, moves of 2 s, the tracker 85 ms late.
fn log(folder: &Folder, timed: bool) -> usize {
    let text = folder.read("data.csv");
    let rows: Vec<Vec<f64>> = text
        .lines()
        .skip(1)
        .take(30)
        .map(|line| line.split(',').take(9).map(|cell| cell.parse().unwrap()).collect())
        .collect();
    let mut all: Vec<Vec<f64>> = Vec::new();
    for pair in rows.windows(2) {
        all.extend((0..300).map(|_| pair[0].clone()));
        all.extend((0..400).map(|k| {
            let s = f64::from(k) / 400.0;
            let w = s * s * (3.0 - 2.0 * s);
            pair[0].iter().zip(&pair[1]).map(|(a, b)| (1.0 - w) * a + w * b).collect()
        }));
    }
    let mut log = String::from("j1[deg],j2[deg],j3[deg],j4[deg],j5[deg],j6[deg],x[mm],y[mm],z[mm]");
    log += if timed { ",time[s]\n" } else { "\n" };
    for (k, row) in all.iter().enumerate() {
        let seen = &all[k.saturating_sub(17)];
        let flicker = |joint: usize| (((k * 7919 + 31 * joint) % 41) as f64 - 20.0) / 20.0 * 5e-4;
        let joints: Vec<String> = (0..6).map(|joint| format!("{:.6}", row[joint] + flicker(joint))).collect();
        let _ = write!(log, "{},{},{},{}", joints.join(","), seen[6], seen[7], seen[8]);
        if timed {
            let _ = write!(log, ",{:.3}", 0.005 * k as f64);
        }
        log.push('\n');
    }
    folder.write("log.csv", &log);
    all.len()
}

#[test]
fn a_log_of_a_moving_robot_is_named_and_its_standstills_are_found() {
    let folder = measured_from_afar();
    let rows = log(&folder, true);
    let check = folder.run("check --robot arm.urdf --data log.csv").ended(0).log;
    let advice = "`truepose dwell log.csv --robot ROBOT --out FILE` finds the dwells";
    assert!(
        check.contains("the robot moves at ")
            && check.contains(&format!("of {rows} rows, 200 rows per second")),
        "{check}"
    );
    assert!(check.contains(advice) && !check.contains("--dwell-tolerance"), "{check}");
    let out = folder.run("identify --robot arm.urdf --data log.csv --folds 0").ended(0).out;
    assert!(out.contains("Check the data first: log.csv: the robot moves at "), "{out}");
    let dwell = "dwell log.csv --robot arm.urdf --out m.csv --json";
    let found = folder.run(dwell).ended(0).json();
    assert_eq!((&found["dwells"], &found["rows"]), (&29.into(), &29.into()));
    assert!((number(&found["lag_s"]) - 0.085).abs() < 4e-3 && number(&found["correlation"]) > 0.9, "{found}");
    // Each is the pose that was measured: to the flicker of the joints and what the tracker had.
    let measured = folder.read("m.csv");
    let data = folder.read("data.csv");
    for (mean, pose) in measured.lines().skip(1).zip(data.lines().skip(1)) {
        for (a, b) in mean.split(',').zip(pose.split(',')).take(9) {
            assert!((a.parse::<f64>().unwrap() - b.parse::<f64>().unwrap()).abs() < 1e-3, "{mean}\n{pose}");
        }
    }
    folder.run("check --robot arm.urdf --data m.csv").ended(0);
    log(&folder, false);
    let check = folder.run("check --robot arm.urdf --data log.csv").ended(0).log;
    assert!(check.contains("log the time of each row (column `time[s]`)"), "{check}");
    let refused = folder.run(dwell).ended(2).log;
    assert!(refused.contains("log.csv: a log needs the time of each row: a column `time[s]`"), "{refused}");
    // Poses that were measured one by one are none.
    let check = folder.run("check --robot arm.urdf --data data.csv").ended(0).log;
    assert!(!check.contains("the robot moves"), "{check}");
}

/// `within_95` of the commands that were found, mm; none where it is empty.
fn bands(folder: &Folder, file: &str) -> Vec<Option<f64>> {
    let text = folder.read(file);
    let header: Vec<&str> = text.lines().next().unwrap().split(',').collect();
    let at = |name: &str| header.iter().position(|cell| *cell == name).unwrap();
    let (status, within) = (at("status"), at("within_95[m]"));
    let rows = text.lines().skip(1).map(|line| line.split(',').collect::<Vec<_>>());
    rows.filter(|row| row[status] == "ok")
        .map(|row| row[within].parse::<f64>().ok().map(|v| 1e3 * v))
        .collect()
}

#[test]
fn the_band_of_a_command_is_that_of_its_tool_centre_point() {
    let folder = measured_from_afar();
    folder.run(&[&FROM_URDF[..], &["--out", "fit.json"]].concat()).ended(0);
    folder.run(&[&FROM_URDF[..], &["--positions-only", "--out", "points.json"]].concat()).ended(0);
    folder.run("predict --fit fit.json --data data.csv --out p.csv").ended(0);
    let commanded = |fit: &str, tcp: &str| {
        let run = ["compensate", "--fit", fit, "--poses", "p.csv", "--tcp", tcp, "--out", "q.csv"];
        let log = folder.run(&run).ended(0).log;
        (bands(&folder, "q.csv"), log)
    };
    let mean =
        |bands: &[Option<f64>]| bands.iter().map(|band| band.unwrap()).sum::<f64>() / bands.len() as f64;
    let near = mean(&commanded("fit.json", "30mm,50mm,20mm,0.349,0.698,0.524").0);
    let far = mean(&commanded("fit.json", "1030mm,50mm,20mm,0.349,0.698,0.524").0);
    // Orientations scatter by 40 µrad, and their mean by less: 95 % of that at a metre, and more than nothing.
    assert!(far > near + 0.02 && far < near + 0.3, "{near} {far}");
    let (unbounded, log) = commanded("points.json", "110mm,50mm,20mm,0.349,0.698,0.524");
    assert!(!unbounded.is_empty() && unbounded.iter().all(Option::is_none), "{unbounded:?}");
    assert!(log.contains("the 95 % band is unbounded in "), "{log}");
}

/// A joint that yields, with a zero that is right: the effective offset is its mean deflection, the zero itself is none.
#[test]
fn effective_zero_offsets_are_told_from_the_zeros_themselves() {
    let folder = Folder::empty();
    folder.run("init irb120 --out robot.toml").ended(0);
    folder.write(
        "plant.toml",
        "robot = \"robot.toml\"\nseed = 5\n[[errors.joint_compliance]]\njoint = \"j3\"\nstiffness = 2e4\n\
         [instrument]\nsd_um = 15\norientation_urad = 40\n[campaign]\npostures = \"random\"\nvisits = 120\n\
         payloads_kg = [0, 3, 6]\n",
    );
    folder.write("model.toml", "[[effects]]\nfamily = \"geometric\"\n[[effects]]\nfamily = \"joint_compliance\"\njoints = [\"j3\"]\n");
    folder.run("simulate --plant plant.toml --out data.csv").ended(0);
    let run = [
        "identify",
        "--robot",
        "robot.toml",
        "--data",
        "data.csv",
        "--model",
        "model.toml",
        "--report",
        "r",
        "--parameters",
        "p.csv",
    ];
    let out = folder.run(&run).ended(0).out;
    let parameters = &folder.json("r/identification.json")["parameters"];
    let apart = parameters["zero_offsets_apart"].as_array().unwrap();
    let of = apart.iter().find(|of| of["joint"] == "j3").unwrap_or_else(|| panic!("{parameters}"));
    let (effective, own, difference) =
        (number(&of["effective"]), number(&of["own"]), number(&of["difference"]));
    assert!((effective - own - difference).abs() < 1e-12, "{of}");
    // Degrees: the zero within its interval of nothing, and the deflection beyond it.
    let half = number(&of["own_half_width_95"]);
    assert!(own.abs() < 2.0 * half && half < 0.01, "{of}");
    assert!(effective.abs() > 3.0 * half && number(&of["difference_half_width_95"]) > 0.0, "{of}");
    for words in [
        "Effective zero offsets of the joints",
        "not for mastering",
        "zero itself",
        "They are no errors of the encoders",
    ] {
        assert!(out.contains(words) && folder.read("r/index.html").contains(words), "{words}\n{out}");
    }
}
