//! From measurements to a fit to predictions, through files.

use crate::folder::Folder;

const IDENTIFY: &[&str] = &["identify", "--robot", "robot.toml", "--data", "data.csv", "--out", "fit.json"];
const PREDICT: &[&str] = &["predict", "--fit", "fit.json", "--data", "data.csv", "--out", "predicted.csv"];

fn rows(text: &str) -> (Vec<String>, Vec<Vec<String>>) {
    let mut lines = text.lines().map(|line| line.split(',').map(str::to_string).collect::<Vec<_>>());
    (lines.next().unwrap(), lines.collect())
}

fn column(header: &[String], name: &str) -> usize {
    header.iter().position(|h| h == name).unwrap_or_else(|| panic!("no {name} in {header:?}"))
}

/// RMS distance between the predictions and the measured positions, µm.
fn rms_um(folder: &Folder) -> f64 {
    let (measured_header, measured) = rows(&folder.read("data.csv"));
    let (predicted_header, predicted) = rows(&folder.read("predicted.csv"));
    assert_eq!(measured.len(), predicted.len());
    let at = |row: &[String], k: usize| row[k].parse::<f64>().unwrap();
    let mut sum = 0.0;
    for (m, p) in measured.iter().zip(&predicted) {
        for axis in ["x", "y", "z"] {
            let measured = at(m, column(&measured_header, &format!("{axis}[mm]"))) * 1e3;
            let predicted = at(p, column(&predicted_header, &format!("{axis}[m]"))) * 1e6;
            sum += (measured - predicted).powi(2);
        }
    }
    (sum / measured.len() as f64).sqrt()
}

#[test]
fn predictions_come_back_row_by_row() {
    let folder = Folder::with_data();
    folder.run(IDENTIFY).ended(0);
    let said = folder.run(PREDICT).ended(0).out;
    let rms = rms_um(&folder);
    // 20 µm an axis of noise are 34.6 µm in space; 80 rows and some 25 unknowns take some of it into the fit.
    assert!((20.0..40.0).contains(&rms), "{rms} µm");
    assert!(said.contains("80 rows predicted, written to predicted.csv"), "{said}");

    // What `predict` says, what stands in its file, and what `identify` said are the same.
    let json = |arguments: &[&str]| -> serde_json::Value {
        let out = folder.run(&[arguments, &["--json"]].concat()).ended(0).out;
        serde_json::from_str(&out).unwrap()
    };
    let predict = json(PREDICT)["position"]["rms_mm"].as_f64().unwrap() * 1e3;
    assert!((predict - rms).abs() < 1e-6, "{predict} and {rms} µm");
    let stages = json(IDENTIFY)["stages"].as_array().unwrap().clone();
    let trained = stages.last().unwrap()["train"]["rms_mm"].as_f64().unwrap() * 1e3;
    assert!((trained - rms).abs() < 1e-6, "{trained} and {rms} µm");

    // Quaternions are of unit length.
    let (header, predicted) = rows(&folder.read("predicted.csv"));
    for row in &predicted {
        let q = ["qw", "qx", "qy", "qz"].map(|name| row[column(&header, name)].parse::<f64>().unwrap());
        assert!((q.iter().map(|v| v * v).sum::<f64>() - 1.0).abs() < 1e-12);
    }
}

#[test]
fn predictions_need_no_measured_columns() {
    let folder = Folder::with_data();
    folder.run(IDENTIFY).ended(0);
    folder.run(PREDICT).ended(0);
    let whole = folder.read("predicted.csv");
    let text = folder.read("data.csv");
    let (header, table) = rows(&text);
    let measured: Vec<usize> = ["x[mm]", "y[mm]", "z[mm]"].iter().map(|n| column(&header, n)).collect();
    let without = |keep: bool| -> String {
        let line = |row: &[String], is_header: bool| {
            let cells = row.iter().enumerate().filter(|(k, _)| keep || !measured.contains(k));
            let cells = cells.map(|(k, c)| if !is_header && measured.contains(&k) { "" } else { c.as_str() });
            cells.collect::<Vec<_>>().join(",") + "\n"
        };
        std::iter::once(line(&header, true)).chain(table.iter().map(|row| line(row, false))).collect()
    };
    for keep in [true, false] {
        folder.write("data.csv", &without(keep));
        let said = folder.run(PREDICT).ended(0).out;
        assert!(!said.contains("error against the measured"), "{said}");
        assert_eq!(folder.read("predicted.csv"), whole, "columns {}", if keep { "empty" } else { "absent" });
    }
}

#[test]
fn a_fit_file_names_no_folder_of_this_machine() {
    let folder = Folder::with_data();
    folder.run(IDENTIFY).ended(0);
    assert!(!folder.read("fit.json").contains(folder.path().to_str().unwrap()));
}

#[test]
fn every_solver_predicts_the_same() {
    let folder = Folder::with_data();
    let mut of = Vec::new();
    for solver in ["qr", "svd", "normal"] {
        folder.run(&[IDENTIFY, &["--solver", solver]].concat()).ended(0);
        folder.run(PREDICT).ended(0);
        of.push(rms_um(&folder));
    }
    for other in &of[1..] {
        assert!((other / of[0] - 1.0).abs() < 1e-9, "{of:?} µm");
    }
}

#[test]
fn a_fit_needs_no_other_file() {
    let folder = Folder::with_data();
    folder.run(IDENTIFY).ended(0);
    std::fs::remove_file(folder.file("robot.toml")).unwrap();
    folder.run(PREDICT).ended(0);
}

#[test]
fn results_go_to_stdout_and_the_log_to_stderr() {
    let folder = Folder::with_data();
    let run = folder.run(IDENTIFY).ended(0);
    assert_eq!(run.log, "wrote fit.json\n");
    assert!(run.out.starts_with("small: "), "{}", run.out);
    // Nothing but JSON on stdout, whatever is warned about.
    let run = folder.run(&[IDENTIFY, &["--json", "--folds", "1000"]].concat()).ended(0);
    assert!(run.log.contains("warning: 40 configurations make at most 40 folds"), "{}", run.log);
    serde_json::from_str::<serde_json::Value>(&run.out).unwrap();
}

#[test]
fn a_held_out_test_set_is_evaluated_and_then_used() {
    let folder = Folder::with_data();
    let run = folder.run(&[IDENTIFY, &["--holdout", "0.25", "--seed", "4"]].concat()).ended(0);
    assert!(run.out.contains(" test set: "), "{}", run.out);
    let fit = folder.json("fit.json");
    assert_eq!(fit["provenance"]["structure_frozen_then_all_rows"], true);
    assert_eq!(fit["provenance"]["rows"], 80);
}

#[test]
fn simulate_draws_other_visits_of_the_same_robot() {
    let folder = Folder::with_data();
    folder.run(IDENTIFY).ended(0);
    let first = folder.read("data.csv");
    let simulate = ["simulate", "--plant", "plant.toml", "--out", "data.csv", "--campaign-seed", "77"];
    folder.run(&simulate).ended(0);
    assert_ne!(folder.read("data.csv"), first);
    folder.run(PREDICT).ended(0);
    // The same robot elsewhere: noise (34.6 µm) and what 80 rows leave uncertain.
    let rms = rms_um(&folder);
    assert!((25.0..70.0).contains(&rms), "{rms} µm");
    // Another robot is not predicted: its errors are others.
    folder.run(&["simulate", "--plant", "plant.toml", "--out", "data.csv", "--seed", "78"]).ended(0);
    folder.run(PREDICT).ended(0);
    assert!(rms_um(&folder) > 200.0);
}
