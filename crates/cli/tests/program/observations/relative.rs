//! Positions in frames that nobody knows: two series of an instrument that was moved between them.

use super::cell::{Cell, identified, kind, robot};
use super::refused::INPUT;
use crate::folder::Folder;

const SERIES: &str = "[[landmarks]]\nname = \"morning\"\nkind = \"relative\"\n\n[[landmarks]]\nname = \"evening\"\nkind = \"relative\"\n";
/// Axes and origins of the two frames, in the robot's.
const FRAMES: [[[f64; 3]; 4]; 2] = [
    [[0.6, 0.8, 0.0], [0.0, 0.0, 1.0], [0.8, -0.6, 0.0], [3.0, -1.0, 0.5]],
    [[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [-2.0, 4.0, 1.0]],
];

fn measured(seed: u64, rows: usize) -> Cell {
    let mut cell = Cell::new(seed);
    cell.series("morning", rows, &FRAMES[0], 5e-5).series("evening", rows, &FRAMES[1], 5e-5);
    cell
}

#[test]
fn series_in_frames_of_their_own_calibrate_the_arm() {
    let cell = measured(11, 60);
    let (folder, found) = identified(&cell, SERIES);
    let of = kind(&found, "relative");
    let number = |key: &str| of[key].as_f64().unwrap();
    assert_eq!((of["rows"].as_u64().unwrap(), of["unit"].as_str().unwrap()), (120, "mm"));
    assert!((number("sd") / 0.05).ln().abs() < 0.2, "{of:#}");
    assert!(number("before") > 5.0 * number("held_out") && number("held_out") < 0.15, "{of:#}");
    let lengths = cell.lengths(&folder);
    assert!(lengths < 0.06, "{lengths} mm");
    let words = "identify --robot robot.toml --data data.csv";
    let log = folder.run(words).ended(0).log;
    assert!(
        log.contains("the base is not determined") && !log.contains("the scale is not determined"),
        "{log}"
    );
    folder.run("check --robot robot.toml --data data.csv").ended(0);
    folder.run("predict --fit fit.json --data data.csv --out q.csv").ended(0);
    folder.run("discover --robot robot.toml --data data.csv --out d.json --report r").ended(0);
}

#[test]
fn what_is_wrong_with_a_series_is_told_where_it_stands() {
    let cell = measured(12, 4);
    let first: Vec<&str> = cell.rows.lines().nth(1).unwrap().split(',').collect();
    let with = |from: &str, to: &str| cell.rows.replacen(from, to, 1);
    let lone: String = cell.rows.lines().take(6).map(|line| format!("{line}\n")).collect();
    for (landmarks, table, words) in [
        (
            SERIES.to_owned(),
            with(first[5], ""),
            "data.csv:2: column `y[mm]` (6): is empty; a row of kind `relative` has a whole position",
        ),
        (
            SERIES.replacen("kind = \"relative\"", "kind = \"relative\"\nxyz = [1, 2, 3]", 1),
            cell.rows.clone(),
            "the frame of series `morning` is found from its rows",
        ),
        (
            SERIES.to_owned(),
            lone,
            "landmark evening: one row for its 6 unknowns says nothing about the robot",
        ),
        (
            SERIES.replacen("morning", "mourning", 1),
            cell.rows.clone(),
            "the robot file has no landmark `morning`",
        ),
    ] {
        let folder = Folder::empty();
        folder.write("robot.toml", &robot(&landmarks));
        folder.write("data.csv", &table);
        let log = folder.run("identify --robot robot.toml --data data.csv").ended(INPUT).log;
        assert!(log.contains(words), "{words}\n{log}");
    }
}
