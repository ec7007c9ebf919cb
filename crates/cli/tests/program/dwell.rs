//! Joint values that flicker, the tolerance for them on the command line, and single rows that are wrong.

use crate::folder::Folder;

/// The folder's data without its column `visit`, with flicker of some 1e-4° on the turning joints, and rows changed by `spoil` (cells by name).
fn flickering(folder: &Folder, spoil: impl Fn(usize, &mut dyn FnMut(&str, &dyn Fn(f64) -> String))) {
    let text = std::fs::read_to_string(folder.file("data.csv")).unwrap();
    let mut lines = text.lines();
    let header: Vec<&str> = lines.next().unwrap().split(',').collect();
    let at = |name: &str| header.iter().position(|cell| cell.split('[').next() == Some(name)).unwrap();
    let (visit, joints) = (at("visit"), [at("j1"), at("j2")]);
    let without = |cells: Vec<String>| {
        let kept: Vec<String> =
            cells.into_iter().enumerate().filter(|(k, _)| *k != visit).map(|(_, cell)| cell).collect();
        kept.join(",") + "\n"
    };
    let mut out = without(header.iter().map(|cell| (*cell).to_owned()).collect());
    for (row, line) in lines.enumerate() {
        let mut cells: Vec<String> = line.split(',').map(str::to_owned).collect();
        for (k, &joint) in joints.iter().enumerate() {
            let off = (((row * 7919 + 31 * k) % 41) as f64 - 20.0) / 20.0 * 1e-4;
            cells[joint] = format!("{:.7}", cells[joint].parse::<f64>().unwrap() + off);
        }
        spoil(row, &mut |name, change| {
            let cell = &mut cells[at(name)];
            *cell = change(cell.parse().unwrap());
        });
        out += &without(cells);
    }
    folder.write("data.csv", &out);
}

const CHECK: [&str; 5] = ["check", "--robot", "robot.toml", "--data", "data.csv"];

#[test]
fn what_was_grouped_is_reported_and_can_be_changed() {
    let folder = Folder::with_data();
    flickering(&folder, |_, _| ());
    let said = folder.run(&CHECK).ended(0).out;
    assert!(said.contains("data data.csv: 80 rows, 40 pose measurements, 40 configurations"), "{said}");
    assert!(
        said.contains("no column `visit`: consecutive rows with joints within 0.00057° or 10 µm are one pose measurement; joint values vary within a dwell by up to"),
        "{said}"
    );
    let exact = [&CHECK[..], &["--dwell-tolerance", "0"]].concat();
    let said = folder.run(&exact).ended(0).out;
    assert!(said.contains("80 rows, 80 pose measurements, 80 configurations"), "{said}");
    let bad = [&CHECK[..], &["--dwell-tolerance", "0.001"]].concat();
    let log = folder.run(&bad).ended(2).log;
    assert!(log.contains("a tolerance needs a unit"), "{log}");
}

#[test]
fn a_fit_of_varying_encoder_readings_is_that_of_constant_ones() {
    let still = Folder::with_data();
    let run = |folder: &Folder| {
        let words = "identify --robot robot.toml --data data.csv --json";
        folder.run(words).ended(0).json()
    };
    let before = run(&still);
    flickering(&still, |_, _| ());
    let after = run(&still);
    assert_eq!(after["visits"], before["visits"], "{after}");
    let held_out = |json: &serde_json::Value| {
        json["stages"].as_array().unwrap().last().unwrap()["held_out"]["rms_mm"].as_f64().unwrap()
    };
    // 1e-4° at a lever of a metre are 2 µm.
    assert!(
        (held_out(&after) / held_out(&before) - 1.0).abs() < 0.1,
        "{} {}",
        held_out(&before),
        held_out(&after)
    );
}

#[test]
fn check_and_identify_name_the_rows_that_are_wrong() {
    let folder = Folder::with_data();
    flickering(&folder, |row, cell| match row {
        20 => cell("y", &|y| format!("{}", y + 12.0)),
        33 => ["x", "y", "z"].into_iter().for_each(|name| cell(name, &|_| "0".into())),
        _ => (),
    });
    for words in [&CHECK[..], &["identify", "--robot", "robot.toml", "--data", "data.csv"]] {
        let run = folder.run(words).ended(0);
        let said = format!("{}{}", run.out, run.log).replace('\n', " ");
        assert!(said.contains("row 21 (line 22) disagrees with the other rows: errors up to 12"), "{said}");
        assert!(said.contains("x, y and z are all 0: read as not measured"), "{said}");
    }
}

#[test]
fn no_folder_of_a_run_takes_the_place_of_its_inputs_or_of_its_fit() {
    let folder = Folder::with_data();
    std::fs::create_dir(folder.file("deep")).unwrap();
    for name in ["deep/1-transmission-j1.json", "deep/fit.svg"] {
        std::fs::copy(folder.file("data.csv"), folder.file(name)).unwrap();
    }
    let run = |data: &str, more: &[&str]| {
        let words = [&["discover", "--robot", "robot.toml", "--data", data][..], more].concat();
        folder.run(&words).ended(2).log
    };
    for (data, more) in [
        ("deep/1-transmission-j1.json", &["--rivals", "deep"][..]),
        ("deep/fit.svg", &["--report", "deep"]),
        ("data.csv", &["--rivals", "deep", "--out", "deep/2-backlash.json"]),
    ] {
        let log = run(data, more);
        assert!(
            log.contains("may get the name of") && log.contains("name another folder"),
            "{more:?}: {log}"
        );
    }
    let log = run("deep/1-transmission-j1.json", &["--out", "deep/../deep/1-transmission-j1.json"]);
    assert!(log.contains("would be overwritten"), "{log}");
}
