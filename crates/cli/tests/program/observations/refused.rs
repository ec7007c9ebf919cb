//! What is wrong with an observation.

use super::cell::{Cell, LANDMARKS, robot};
use crate::folder::Folder;

/// Exit code of what is wrong with an input.
pub const INPUT: i32 = 2;

#[test]
fn what_is_wrong_with_an_observation_is_told_where_it_stands() {
    let mut cell = Cell::new(2);
    cell.wire(8).table(8);
    let lines: Vec<String> = cell.rows.lines().map(String::from).collect();
    let with = |line: usize, from: &str, to: &str| {
        let mut lines = lines.clone();
        assert!(lines[line - 1].contains(from), "{}", lines[line - 1]);
        lines[line - 1] = lines[line - 1].replacen(from, to, 1);
        lines.join("\n") + "\n"
    };
    let wire = lines[1].split(',').nth(2).unwrap().to_owned();
    let lone = [&lines[..1], &lines[9..], &lines[1..2]].concat().join("\n") + "\n";
    let whole = cell.rows.clone();
    let plain = |from: &str, to: &str| {
        assert!(LANDMARKS.contains(from), "{from}");
        LANDMARKS.replacen(from, to, 1)
    };
    let mine = LANDMARKS.to_owned();
    let cases: Vec<(String, String, &str)> = vec![
        (
            mine.clone(),
            with(10, "plane", "plan"),
            "data.csv:10: column `kind` (1): `plan` is no kind of observation; did you mean `plane`?",
        ),
        (
            mine.clone(),
            with(2, &wire, ""),
            "data.csv:2: column `distance[mm]` (3): is empty; a row of kind `distance` has a measured number",
        ),
        (
            mine.clone(),
            with(10, "table,,", "table,7,"),
            "data.csv:10: column `distance[mm]` (3): is not used by a row of kind `plane`",
        ),
        (
            mine.clone(),
            with(1, "distance[mm]", "note"),
            "column `kind` (1): `distance` needs a column `distance[mm]`",
        ),
        (
            mine.clone(),
            with(1, "distance[mm]", "distance[kg]"),
            "[kg] is the unit of a mass, but `distance` is a length",
        ),
        (
            mine.clone(),
            with(1, "landmark", "note"),
            "`distance` needs a column `landmark`: what was observed",
        ),
        (
            mine.clone(),
            with(10, "table", ""),
            "data.csv:10: column `landmark` (2): is empty; a row of kind `plane` names what was observed",
        ),
        (
            mine.clone(),
            with(10, "table", "wire"),
            "data.csv:10: landmark `wire` is of kind `plane` here and of kind `distance` before",
        ),
        (
            mine.clone(),
            with(10, "table", "ball"),
            "data.csv:10: landmark `ball` is a `sphere` in the robot file, and the row is of kind `plane`",
        ),
        (mine.clone(), with(10, "table", "tabel"), "data.csv:10: the robot file has no landmark `tabel`"),
        (
            mine.clone(),
            lone,
            "data.csv: landmark wire: one row for its 4 unknowns says nothing about the robot",
        ),
        (
            mine.clone(),
            with(10, "table,,,,,,,,", "table,,,1,2,3,,,"),
            "a row of kind `plane` has no measured position",
        ),
        (
            plain("radius = 60", "radius = -60"),
            whole.clone(),
            "`radius` of landmark `ball` has to be above zero",
        ),
        (plain("radius = 60", "radus = 60"), whole.clone(), "radus"),
        (
            plain("kind = \"plane\"", "kind = \"plane\"\nradius = 3"),
            whole.clone(),
            "`radius` belongs to a landmark of kind `sphere`",
        ),
        (
            plain("kind = \"plane\"", "kind = \"plane\"\nknown = true"),
            whole.clone(),
            "landmark `table` is known, but has no `normal`",
        ),
        (
            plain("kind = \"plane\"", "kind = \"plane\"\nnormal = [0, 0, 0]"),
            whole.clone(),
            "a normal has a length above zero",
        ),
        (plain("[\"offset\"]", "[\"ofset\"]"), whole.clone(), "ofset"),
        (plain("free = [\"offset\"]", "gain = 0"), whole.clone(), "a gain is not zero"),
    ];
    for (landmarks, table, words) in cases {
        let folder = Folder::empty();
        folder.write("robot.toml", &robot(&landmarks));
        folder.write("data.csv", &table);
        let run = folder.run("identify --robot robot.toml --data data.csv --out fit.json");
        assert!(!folder.file("fit.json").exists(), "{words}\n{}", run.log);
        let log = run.ended(INPUT).log;
        assert!(log.contains(words), "{words}\n{log}");
    }
    // What nothing observed is told, and hurts nobody.
    cell.positions(30);
    let folder = Folder::empty();
    folder.write("robot.toml", &robot(LANDMARKS));
    folder.write("data.csv", &cell.rows);
    let log = folder.run("identify --robot robot.toml --data data.csv").ended(0).log;
    assert!(log.contains("no row observed landmark ball"), "{log}");
}

#[test]
fn a_test_set_is_not_drawn_from_rows_that_are_left_out_by_landmarks() {
    let mut cell = Cell::new(2);
    cell.wire(40).ball(40).gauge(40);
    let folder = Folder::empty();
    folder.write("robot.toml", &robot(LANDMARKS));
    folder.write("data.csv", &cell.rows);
    let words = "identify --robot robot.toml --data data.csv --holdout 0.2";
    let log = folder.run(words).ended(INPUT).log;
    assert!(log.contains("--holdout: rows that share a landmark are left out together"), "{log}");
}
