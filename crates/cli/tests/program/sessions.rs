//! A campaign in three installations of one arm: the rows of the second half stand in frames that this test made up.

use crate::folder::Folder;

/// Exit code of what is wrong with an input.
const INPUT: i32 = 2;

/// Rows of the campaign of the tests, cut in three, each but the first seen from elsewhere: turned about the vertical and moved.
fn in_three_frames(text: &str) -> (String, String) {
    let mut lines = text.lines();
    let header = lines.next().unwrap();
    let at = |name: &str| header.split(',').position(|cell| cell.starts_with(&format!("{name}["))).unwrap();
    let (x, y, z) = (at("x"), at("y"), at("z"));
    let rows: Vec<Vec<String>> = lines.map(|line| line.split(',').map(String::from).collect()).collect();
    let count = rows.len();
    let (mut fit, mut held) = (format!("{header},session\n"), format!("{header},session\n"));
    for (row, mut cells) in rows.into_iter().enumerate() {
        let session = (row >= count / 2) as usize + (row >= count * 3 / 4) as usize;
        let (yaw, shift) =
            [(0.0, [0.0; 3]), (1.1_f64, [1500.0, -700.0, 300.0]), (-2.0, [-2000.0, 900.0, -150.0])][session];
        let value = |k: usize| cells[k].parse::<f64>().unwrap();
        let (px, py, pz) = (value(x), value(y), value(z));
        let moved = [yaw.cos() * px - yaw.sin() * py, yaw.sin() * px + yaw.cos() * py, pz];
        for (k, (value, by)) in [x, y, z].into_iter().zip(moved.iter().zip(shift)) {
            cells[k] = (value + by).to_string();
        }
        let line = format!("{},{}\n", cells.join(","), ["north", "2", "hall B"][session]);
        if row % 7 == 3 { held += &line } else { fit += &line }
    }
    (fit, held)
}

fn folder() -> Folder {
    let folder = Folder::with_data();
    let (fit, held) = in_three_frames(&folder.read("data.csv"));
    folder.write("fit.csv", &fit);
    folder.write("held.csv", &held);
    folder
}

fn rms(folder: &Folder, words: &[&str]) -> f64 {
    let out = folder.run(words).ended(0).out;
    let text = out.split("RMS ").nth(1).unwrap_or_else(|| panic!("{out}"));
    text.split(' ').next().unwrap().parse().unwrap()
}

#[test]
fn three_installations_are_as_good_as_one() {
    let folder = folder();
    let told = folder.run("identify --robot robot.toml --data fit.csv --out fit.json").ended(0);
    for name in ["north", "2", "hall B"] {
        assert!(told.out.contains(&format!("\n  {name} ")), "{}", told.out);
    }
    let predict = ["predict", "--fit", "fit.json", "--data", "held.csv", "--out", "p.csv"];
    let apart = rms(&folder, &predict);
    // Predictions say whose they are.
    let column = |text: &str| -> Vec<String> {
        let mut lines = text
            .lines()
            .filter(|line| !line.starts_with('#'))
            .map(|line| line.split(',').collect::<Vec<_>>());
        let at = lines.next().unwrap().iter().position(|cell| *cell == "session").unwrap();
        lines.map(|cells| cells[at].to_owned()).collect()
    };
    assert_eq!(column(&folder.read("p.csv")), column(&folder.read("held.csv")));
    // The same rows in one installation.
    let plain = folder.read("data.csv");
    let rows: Vec<&str> = plain.lines().skip(1).collect();
    let part = |held: bool| -> String {
        let those = rows.iter().enumerate().filter(|(row, _)| (row % 7 == 3) == held).map(|(_, line)| *line);
        std::iter::once(plain.lines().next().unwrap()).chain(those).map(|line| format!("{line}\n")).collect()
    };
    folder.write("one.csv", &part(false));
    folder.write("one-held.csv", &part(true));
    folder.run("identify --robot robot.toml --data one.csv --out one.json").ended(0);
    let together =
        rms(&folder, &["predict", "--fit", "one.json", "--data", "one-held.csv", "--out", "q.csv"]);
    assert!(apart < 1.15 * together, "{apart} mm apart, {together} mm together");
}

#[test]
fn what_is_not_known_of_a_session_is_asked_for() {
    let folder = folder();
    folder.run("identify --robot robot.toml --data fit.csv --out fit.json").ended(0);
    let predict = |data: &str, more: &[&str]| {
        let words = ["predict", "--fit", "fit.json", "--data", data, "--out", "p.csv"];
        folder.run(&[&words, more].concat())
    };
    let error = predict("data.csv", &[]).ended(INPUT).log;
    assert!(error.contains("several sessions (north, 2, hall B)") && error.contains("--session"), "{error}");
    predict("data.csv", &["--session", "north"]).ended(0);
    let error = predict("data.csv", &["--session", "south"]).ended(INPUT).log;
    assert!(error.contains("no session `south` (its sessions: north, 2, hall B)"), "{error}");
    folder.write("other.csv", &folder.read("held.csv").replace(",hall B\n", ",hall C\n"));
    let error = predict("other.csv", &[]).ended(INPUT).log;
    assert!(error.contains("line ") && error.contains("no session `hall C`"), "{error}");
    // One pose says nothing about a base.
    let mut lines: Vec<String> = folder.read("fit.csv").lines().map(String::from).collect();
    let first = lines.iter().position(|line| line.ends_with(",hall B")).unwrap();
    lines.truncate(first + 1);
    folder.write("few.csv", &(lines.join("\n") + "\n"));
    let identify = folder.run("identify --robot robot.toml --data few.csv --out few.json");
    let error = identify.ended(INPUT).log;
    assert!(error.contains("session hall B: ") && error.contains("it has 1 pose"), "{error}");
    assert!(!folder.file("few.json").exists());
    // Blocks know nothing of the others.
    let words = "identify --robot robot.toml --data fit.csv --stream --out s.json";
    let error = folder.run(words).ended(INPUT).log;
    assert!(error.contains("a column `session` needs the whole file"), "{error}");
    // An empty name.
    folder.write("empty.csv", &folder.read("fit.csv").replacen(",north\n", ",\n", 1));
    let error = folder.run("check --robot robot.toml --data empty.csv").ended(INPUT).log;
    assert!(error.contains("empty.csv:2: column `session`"), "{error}");
}
