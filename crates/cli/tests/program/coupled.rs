//! A robot whose controller counts joint 2 relative to joint 1, against the same robot in the variables of its joints: the columns are
//! converted in this test.

use crate::folder::{Folder, ROBOT};

/// A table: header and rows of cells.
type Table = (Vec<String>, Vec<Vec<String>>);

fn table(text: &str) -> Table {
    let cells = |line: &str| line.split(',').map(str::to_string).collect::<Vec<_>>();
    let mut lines = text.lines().map(cells);
    (lines.next().unwrap(), lines.collect())
}

fn column(table: &Table, name: &str) -> usize {
    let of = |cell: &String| cell.split('[').next() == Some(name);
    table.0.iter().position(of).unwrap_or_else(|| panic!("no {name} in {:?}", table.0))
}

fn numbers(table: &Table, name: &str) -> Vec<f64> {
    let k = column(table, name);
    table.1.iter().map(|row| row[k].parse().unwrap()).collect()
}

/// The table with the values that the controller reports: j2 less 0.75 times j1.
fn of_the_controller(text: &str) -> String {
    let mut table = table(text);
    let (driver, joint) = (column(&table, "j1"), column(&table, "j2"));
    for row in &mut table.1 {
        let value = |k: usize| row[k].parse::<f64>().unwrap();
        row[joint] = (value(joint) - 0.75 * value(driver)).to_string();
    }
    let lines = std::iter::once(&table.0).chain(&table.1).map(|row| row.join(",") + "\n");
    lines.collect()
}

fn folder() -> Folder {
    let folder = Folder::with_data();
    let robot = ROBOT.replace("limits = [-120, 120]\n", "");
    assert_ne!(robot, ROBOT);
    folder.write("robot.toml", &robot);
    let coupling = "\n[[couplings]]\njoint = \"j2\"\ndriver = \"j1\"\nfactor = 0.75\n";
    folder.write("coupled.toml", &format!("{robot}{coupling}"));
    folder.write("coupled.csv", &of_the_controller(&folder.read("data.csv")));
    folder
}

#[test]
fn a_coupled_robot_is_the_same_robot() {
    let folder = folder();
    let identify = |robot: &str, data: &str, fit: &str| -> serde_json::Value {
        let out = folder.run(&["identify", "--robot", robot, "--data", data, "--out", fit, "--json"]);
        out.ended(0).json()
    };
    let rms = |found: &serde_json::Value| {
        found["stages"].as_array().unwrap().last().unwrap()["train"]["rms_mm"].as_f64().unwrap()
    };
    let plain = identify("robot.toml", "data.csv", "plain.json");
    let coupled = identify("coupled.toml", "coupled.csv", "coupled.json");
    // The columns were rounded to digits of a decimal number once more.
    assert!((rms(&plain) - rms(&coupled)).abs() < 1e-9, "{} {}", rms(&plain), rms(&coupled));
    // Without the coupling the same columns are another robot's.
    let wrong = identify("robot.toml", "coupled.csv", "wrong.json");
    assert!(rms(&wrong) > 10.0, "{}", rms(&wrong));

    // Predictions: the same places, and the columns of the joints as they came.
    folder.run("predict --fit plain.json --data data.csv --out p.csv").ended(0);
    folder.run("predict --fit coupled.json --data coupled.csv --out q.csv").ended(0);
    let (p, q) = (table(&folder.read("p.csv")), table(&folder.read("q.csv")));
    let close = |p: &[f64], q: &[f64], tolerance: f64| {
        assert_eq!(p.len(), q.len());
        p.iter().zip(q).for_each(|(p, q)| assert!((p - q).abs() < tolerance, "{p} {q}"));
    };
    for name in ["x", "y", "z", "j1", "d3"] {
        close(&numbers(&p, name), &numbers(&q, name), 1e-9);
    }
    let less = |table: &Table| -> Vec<f64> {
        let both = numbers(table, "j2").into_iter().zip(numbers(table, "j1"));
        both.map(|(joint, driver)| joint - 0.75 * driver).collect()
    };
    close(&less(&p), &numbers(&q, "j2"), 1e-12);

    // Commands for the places that were predicted, from the joints there: in the controller's values.
    let poses = |from: &Table| -> String {
        let (x, names) = (["x", "y", "z"], ["j1", "j2", "d3"]);
        let columns: Vec<usize> = x.iter().chain(&names).map(|name| column(from, name)).collect();
        let target = column(from, "target");
        let mut text = String::from("x[m],y[m],z[m],j1[rad],j2[rad],d3[m],target\n");
        for row in &from.1 {
            let cells: Vec<&str> = columns.iter().map(|&k| row[k].as_str()).collect();
            text += &format!("{},{}\n", cells.join(","), row[target]);
        }
        text
    };
    folder.write("tp.csv", &poses(&p));
    folder.write("tq.csv", &poses(&q));
    folder.run("compensate --fit plain.json --poses tp.csv --out cp.csv").ended(0);
    folder.run("compensate --fit coupled.json --poses tq.csv --out cq.csv").ended(0);
    let (cp, cq) = (table(&folder.read("cp.csv")), table(&folder.read("cq.csv")));
    assert!(cp.1.iter().chain(&cq.1).all(|row| row[column(&cp, "status")] == "ok"));
    close(&less(&cp), &numbers(&cq, "j2"), 1e-6);
    close(&numbers(&cp, "d3"), &numbers(&cq, "d3"), 1e-6);

    // What a file of another program cannot hold is written above it.
    folder.run("export --fit coupled.json --format dh --out dh.csv").ended(0);
    let words = "the variable of j2 contains 0.75 times the controller's value of j1, besides its own";
    assert!(folder.read("dh.csv").contains(words), "{}", folder.read("dh.csv"));
    let checked = folder.run("check --robot coupled.toml").ended(0).out;
    assert!(checked.contains("j2 is coupled to j1: variable = value + 0.75 × value of j1"), "{checked}");
}

#[test]
fn limits_are_those_of_the_controllers_values() {
    let folder = folder();
    // As measured, the controller's j2 goes beyond ±30°, where the variable may be anything up to ±157.5°.
    let robot =
        folder.read("coupled.toml").replacen("name = \"j2\"\n", "name = \"j2\"\nlimits = [-30, 30]\n", 1);
    folder.write("narrow.toml", &robot);
    let run = ["identify", "--robot", "narrow.toml", "--data", "coupled.csv", "--out", "narrow.json"];
    let log = folder.run(&run).ended(0).log;
    assert!(log.contains("column `j2[deg]` (2): is beyond the joint's limits"), "{log}");
    let predict = "predict --fit narrow.json --data coupled.csv --out q.csv";
    folder.run(predict).ended(0);
    let q = table(&folder.read("q.csv"));
    let names = ["x", "y", "z", "target"].map(|name| column(&q, name));
    let mut text = String::from("x[m],y[m],z[m],target\n");
    for row in &q.1 {
        text += &format!("{}\n", names.map(|k| row[k].clone()).join(","));
    }
    folder.write("t.csv", &text);
    let compensate = "compensate --fit narrow.json --poses t.csv --out c.csv";
    folder.run(compensate).ended(0);
    let commands = table(&folder.read("c.csv"));
    let status = column(&commands, "status");
    let mut ok = 0;
    for (row, value) in commands.1.iter().zip(numbers(&q, "j2")) {
        // Where it was measured within the limits, there is a command within them.
        if row[status] == "ok" {
            let j2: f64 = row[column(&commands, "j2")].parse().unwrap();
            assert!(j2.abs() <= 30f64.to_radians() + 1e-6, "{j2}");
            ok += 1;
        } else {
            assert!(row[status] == "limit" && value.abs() > 30f64.to_radians(), "{row:?} {value}");
        }
    }
    assert!(ok > 3 && ok < commands.1.len(), "{ok} of {}", commands.1.len());
}

#[test]
fn what_is_no_coupling_is_refused_with_its_place() {
    let folder = Folder::empty();
    let error = |coupling: &str| {
        folder.write("r.toml", &format!("{ROBOT}\n[[couplings]]\n{coupling}"));
        folder.run("check --robot r.toml").ended(2).log
    };
    let log = error("joint = \"j4\"\ndriver = \"j1\"\n");
    assert!(log.contains("r.toml:34:9: the robot has no moving joint `j4`"), "{log}");
    let log = error("joint = \"d3\"\ndriver = \"j1\"\n");
    assert!(log.contains("a revolute and a prismatic joint cannot be coupled"), "{log}");
    let log = error("joint = \"j1\"\ndriver = \"j1\"\nratio = 2\n");
    assert!(log.contains("ratio"), "{log}");
    let log = error("joint = \"j2\"\ndriver = \"j1\"\n\n[[couplings]]\njoint = \"j1\"\ndriver = \"j2\"\n");
    assert!(log.contains("the couplings form a circle"), "{log}");
}
