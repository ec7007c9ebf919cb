//! The fit elsewhere and later: `transfer` and `monitor`.

use crate::folder::{Folder, ROBOT};
use serde_json::Value;

/// A robot that was identified from forty poses, with further measurements of the same robot.
fn identified() -> Folder {
    let folder = Folder::with_data();
    folder.run("identify --robot robot.toml --data data.csv --out fit.json").ended(0);
    let again = "simulate --plant plant.toml --campaign-seed 9 --out today.csv";
    folder.run(again).ended(0);
    folder
}

/// Measurements of the plant with something else in its file.
fn simulated(folder: &Folder, name: &str, from: &str, to: &str) {
    let plant = folder.read("plant.toml");
    assert!(plant.contains(from), "{from}");
    folder.write("other.toml", &plant.replace(from, to));
    folder.run(&["simulate", "--plant", "other.toml", "--campaign-seed", "11", "--out", name]).ended(0);
}

#[test]
fn looks_at_a_robot_share_one_error_rate_and_a_change_has_its_exit_code() {
    let folder = identified();
    let look = ["monitor", "--fit", "fit.json", "--data", "today.csv", "--history", "looks.json"];
    let first = folder.run(&look).ended(0);
    assert!(
        first.out.contains("No change: p = ") && first.out.contains("level of this look 0.0050"),
        "{}",
        first.out
    );
    // The same file is no second look.
    let same = folder.run(&look).ended(2).log;
    assert!(same.contains("check 1 of the history (`today.csv`) is of these measurements"), "{same}");
    simulated(&folder, "tomorrow.csv", "seed = 3", "seed = 3");
    let later = "monitor --fit fit.json --data tomorrow.csv --history looks.json";
    let second = folder.run(later).ended(0);
    assert!(second.out.contains("level of this look 0.0017 (look 2"), "{}", second.out);
    // Another robot of the same type.
    simulated(&folder, "other.csv", "seed = 3", "seed = 4");
    let run = ["monitor", "--fit", "fit.json", "--data", "other.csv", "--history", "looks.json", "--json"];
    let changed = folder.run(&[&run[..], &["--page", "looks.html"]].concat()).ended(3);
    let page = folder.read("looks.html");
    assert!(
        page.contains(
            "3 looks since the calibration; 1 found a change, for the first time look 3 (other.csv"
        )
    );
    assert!(page.contains("<td>today.csv</td>") && page.contains("The robot has changed: p"), "{page}");
    // A page without the history would be one of a single look.
    let alone = "monitor --fit fit.json --data today.csv --page looks.html";
    folder.run(alone).ended(2);
    let json = changed.json();
    assert_eq!((&json["changed"], &json["look"]), (&true.into(), &3.into()));
    assert!(json["changes"][0]["coefficients"][0]["ci95"].is_array(), "{json}");
    let looks = folder.json("looks.json");
    assert_eq!(looks["looks"].as_array().unwrap().len(), 3);
    assert_eq!(looks["looks"][2]["changed"], true);
    // The history of one fit is not that of another.
    folder.run("identify --robot robot.toml --data today.csv --out fit2.json").ended(0);
    let other = folder.run("monitor --fit fit2.json --data data.csv --history looks.json").ended(2);
    assert!(other.log.contains("looks.json: these looks were held against another fit"), "{}", other.log);
    let over = folder.run("monitor --fit fit.json --data today.csv --history fit.json").ended(2);
    assert!(over.log.contains("is what --fit reads"), "{}", over.log);
}

#[test]
fn an_arm_is_carried_into_another_installation() {
    let folder = identified();
    folder.write("there.toml", &format!("{ROBOT}\n[base]\nxyz = [1500, -400, 100]\nrpy = [0, 0, 120]\n"));
    simulated(&folder, "fresh.csv", "robot = \"robot.toml\"", "robot = \"there.toml\"");
    let all = folder.read("fresh.csv");
    // Six poses of two targets.
    let few: Vec<&str> = all.lines().take(13).collect();
    folder.write("few.csv", &(few.join("\n") + "\n"));
    let made = folder.run("transfer --fit fit.json --data few.csv --out moved.json").ended(0);
    // A mirrored instrument: the file contains that the arm does not fit, and verbs refuse it.
    let mirrored: Vec<String> = few
        .iter()
        .enumerate()
        .map(|(k, line)| {
            let y = few[0].split(',').position(|name| name.starts_with("y[")).unwrap();
            let turned = |(j, cell): (usize, &str)| match j == y && k > 0 {
                true => (-cell.parse::<f64>().unwrap()).to_string(),
                false => cell.to_owned(),
            };
            line.split(',').enumerate().map(turned).collect::<Vec<_>>().join(",")
        })
        .collect();
    folder.write("mirrored.csv", &(mirrored.join("\n") + "\n"));
    let wrong = ["transfer", "--fit", "fit.json", "--data", "mirrored.csv", "--out", "wrong.json"];
    folder.run(&wrong).ended(1);
    let predict = ["predict", "--fit", "wrong.json", "--data", "few.csv", "--out", "p.csv"];
    let refused = folder.run(&predict).ended(2).log;
    assert!(refused.contains("wrong.json: this fit is not to be relied on"), "{refused}");
    let marked = folder.run(&[&predict[..], &["--accept"]].concat()).ended(0).log;
    assert!(marked.contains("warning: wrong.json: this fit is not to be relied on"), "{marked}");
    assert!(made.out.contains("The arm as identified fits in this installation"), "{}", made.out);
    assert!(made.out.contains("Found: base.") && made.out.contains("Measure next: j1 "), "{}", made.out);
    let error = |fit: &str| {
        let ran = folder
            .run(&["predict", "--fit", fit, "--data", "fresh.csv", "--out", "p.csv", "--json"])
            .ended(0);
        let json = ran.json();
        json["position"]["rms_mm"].as_f64().unwrap_or_else(|| panic!("{json}"))
    };
    let (there, before) = (error("moved.json"), error("fit.json"));
    assert!(there < 0.1 && before > 100.0, "{there} {before}");
    // One pose of one target determines nothing, and leaves no file behind.
    folder.write("one.csv", &(few[..2].join("\n") + "\n"));
    let none = folder.run("transfer --fit fit.json --data one.csv --out none.json").ended(2);
    assert!(none.log.contains("one.csv: the data does not determine"), "{}", none.log);
    assert!(!folder.file("none.json").exists());
    // The fit of another installation is a fit like any other.
    folder.run("monitor --fit moved.json --data fresh.csv").ended(0);
}

#[test]
fn poses_for_looks_are_planned_and_read_by_check() {
    let folder = Folder::with_data();
    folder.run("identify --robot robot.toml --data data.csv --out fit.json").ended(0);
    let plan = "plan --for monitor --fit fit.json --out look.csv --count 5";
    let told = folder.run(plan).ended(0).out;
    assert!(told.contains("5 poses of the fit") && told.contains("9 cases of 10"), "{told}");
    folder.run("check --robot robot.toml --data look.csv").ended(0);
    assert_eq!(folder.read("look.csv").lines().filter(|line| !line.starts_with('#')).count(), 6);
}

#[test]
fn poses_for_a_transfer_are_planned_and_too_few_are_told() {
    let folder = identified();
    let plan = ["plan", "--for", "transfer", "--fit", "fit.json", "--out", "poses.csv"];
    let told = folder.run(&plan).ended(0).out;
    assert!(told.contains("8 poses of the fit for truepose transfer, 6 unknowns"), "{told}");
    folder.run("check --robot robot.toml --data poses.csv").ended(0);
    let band = |more: &[&str]| {
        let made = folder.run(&[&plan[..], &["--json"], more].concat()).ended(0);
        let json = made.json();
        (json["band_mm"].as_f64().unwrap(), json["unknowns"].as_u64().unwrap())
    };
    let (few, many) = (band(&["--count", "4"]), band(&["--count", "16"]));
    assert!(few.0 > many.0 && few.1 == 6, "{few:?} {many:?}");
    assert!(band(&["--targets"]).1 > 6);
    let none = folder.run(&[&plan[..], &["--count", "0"]].concat()).ended(2);
    assert!(none.log.contains("do not determine an installation of 6 unknowns"), "{}", none.log);
    for test in [&["--for", "monitor"][..], &[]] {
        let asked = ["plan", "--fit", "fit.json", "--out", "other.csv", "--tool"];
        let told = folder.run(&[&asked[..], test].concat()).ended(2).log;
        assert!(told.contains("--tool"), "{told}");
    }
}

#[test]
fn a_tracker_that_was_set_up_anew_is_not_a_changed_robot() {
    let folder = identified();
    // The same robot, in a frame of the instrument that is turned by half a degree and moved by some centimetres.
    folder.write("there.toml", &format!("{ROBOT}\n[base]\nxyz = [30, -20, 5]\nrpy = [0, 0, 0.5]\n"));
    simulated(&folder, "fresh.csv", "robot = \"robot.toml\"", "robot = \"there.toml\"");
    let look = "monitor --fit fit.json --data fresh.csv";
    let seen = folder.run(look).ended(3).out;
    assert!(seen.contains("Most likely the instrument or the robot was set up anew"), "{seen}");
    assert!(seen.contains("Repeat with --base."), "{seen}");
    let json = folder.run(&format!("{look} --json")).ended(3).out;
    let json: Value = serde_json::from_str(&json).unwrap();
    assert_eq!(json["set_up_anew"]["part"], "base");
    let again = folder.run(&format!("{look} --base")).ended(0).out;
    assert!(again.contains("No change") && !again.contains("Most likely"), "{again}");
    // Another robot is not explained by an installation.
    simulated(&folder, "other.csv", "seed = 3", "seed = 4");
    let other = folder.run("monitor --fit fit.json --data other.csv").ended(3).out;
    assert!(!other.contains("Most likely"), "{other}");
}

/// Student's t with 2.5 degrees of freedom, whose fourth moment does not exist: a variance that few numbers made is not that of the next ones.
#[test]
fn an_unchanged_robot_whose_noise_has_tails_is_not_called_changed() {
    let mut state = 3u64;
    let mut uniform = move || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1u64 << 53) as f64
    };
    let mut normal = move || (0..12).map(|_| uniform()).sum::<f64>() - 6.0;
    let mut changed = 0;
    for _ in 0..10 {
        let folder = Folder::with_data();
        for name in ["data.csv", "today.csv"] {
            let seed = if name == "data.csv" { "3" } else { "9" };
            let run = ["simulate", "--plant", "plant.toml", "--campaign-seed", seed, "--out", name];
            folder.run(&run).ended(0);
            let table = folder.read(name);
            let (head, rows) = table.split_once('\n').unwrap();
            let places: Vec<usize> = ["x[mm]", "y[mm]", "z[mm]"]
                .map(|name| head.split(',').position(|h| h == name).unwrap())
                .to_vec();
            let mut noisy = head.to_owned() + "\n";
            for row in rows.lines() {
                let mut cells: Vec<String> = row.split(',').map(str::to_owned).collect();
                for &place in &places {
                    let chi_square = normal().powi(2) + normal().powi(2) + 0.5 * normal().powi(2);
                    let t = normal() / (chi_square / 2.5).sqrt();
                    cells[place] = (cells[place].parse::<f64>().unwrap() + 0.05 * t).to_string();
                }
                noisy += &(cells.join(",") + "\n");
            }
            folder.write(name, &noisy);
        }
        folder.run("identify --robot robot.toml --data data.csv --out fit.json").ended(0);
        let look = folder.run("monitor --fit fit.json --data today.csv --json");
        changed += usize::from(serde_json::from_str::<Value>(&look.out).unwrap()["changed"] == true);
        // Another robot of the same type is another one all the same.
        simulated(&folder, "other.csv", "seed = 3", "seed = 4");
        folder.run("monitor --fit fit.json --data other.csv").ended(3);
    }
    // At the level of 0.005; of squares that are not bounded, a third.
    assert!(changed <= 1, "{changed}");
}
