//! A camera that stands in the cell.

use super::cell::{Cell, EYE, LANDMARKS, identified, kind, robot};
use super::refused::INPUT;
use crate::folder::Folder;

#[test]
fn a_camera_in_the_cell_is_found_and_adds_to_positions() {
    let mut cell = Cell::new(6);
    cell.positions(25);
    let (alone, _) = identified(&cell, LANDMARKS);
    let positions = cell.lengths(&alone);
    cell.pixels(150);
    let (together, found) = identified(&cell, LANDMARKS);
    let of = kind(&found, "pixel");
    assert_eq!((of["unit"].as_str().unwrap(), of["rows"].as_u64().unwrap()), ("px", 150));
    let sd = of["sd"].as_f64().unwrap();
    assert!((sd / 0.04).ln().abs() < 0.2, "{sd} px");
    let eye = &found["kinds"]["sensors"][0]["values"];
    for (k, at) in EYE.iter().enumerate() {
        let found = eye[k][1].as_f64().unwrap();
        assert!((found - 1e3 * at).abs() < 1.5, "{found} mm for {at} m");
    }
    let all = cell.lengths(&together);
    assert!(all < 0.8 * positions, "{all} mm, of positions alone {positions} mm");
    // Alone it says nothing of lengths.
    let mut cell = Cell::new(6);
    cell.pixels(200);
    let folder = Folder::empty();
    folder.write("robot.toml", &robot(LANDMARKS));
    folder.write("data.csv", &cell.rows);
    let run = folder.run(&["identify", "--robot", "robot.toml", "--data", "data.csv"]).ended(INPUT);
    assert!(
        run.log.contains("landmark eye: ") && run.log.contains("the scale is not determined"),
        "{}",
        run.log
    );
}

#[test]
fn what_is_wrong_with_a_camera_is_told_where_it_stands() {
    let mut cell = Cell::new(8);
    cell.pixels(12);
    let lines: Vec<String> = cell.rows.lines().map(String::from).collect();
    let first: Vec<&str> = lines[1].split(',').collect();
    let with = |from: &str, to: &str| cell.rows.replacen(from, to, 1);
    let plain = |from: &str, to: &str| {
        assert!(LANDMARKS.contains(from), "{from}");
        LANDMARKS.replacen(from, to, 1)
    };
    let mine = LANDMARKS.to_owned();
    let known = "fx = 800\nxyz = [-3000, 0, 500]\nrpy = [0, -90, 0]";
    for (landmarks, table, words) in [
        (
            mine.clone(),
            with(first[7], "1300.5"),
            "data.csv:2: column `u[px]`: 1300.5 is outside of the image of camera `eye` (1280 × 960 px)",
        ),
        (mine.clone(), with("v[px]", "note"), "`pixel` needs a column `v[px]`"),
        (
            mine.clone(),
            with(first[8], ""),
            "data.csv:2: column `v[px]` (9): is empty; a row of kind `pixel` has a measured number",
        ),
        (
            mine.clone(),
            with("v[px]", "v[mm]"),
            "[mm] is the unit of a length, but `v` is a place in an image",
        ),
        (
            plain("[[cameras]]\nname = \"eye\"", "[[cameras]]\nname = \"other\""),
            cell.rows.clone(),
            "the robot file has no landmark `eye`",
        ),
        (plain("fx = 800\n", ""), cell.rows.clone(), "lacks `fx`"),
        (plain("fx = 800", "fx = 0"), cell.rows.clone(), "`fx` of camera `eye` has to be above zero"),
        (
            plain("fx = 800", "fx = 800\nmount = \"tool\""),
            cell.rows.clone(),
            "line 2: a camera on the robot needs the point that it saw",
        ),
        (
            plain("fx = 800", "fx = 800\nknown = true"),
            cell.rows.clone(),
            "camera `eye` is known, but has no `xyz` and `rpy`",
        ),
        (
            plain("fx = 800", known),
            cell.rows.clone(),
            "landmark eye: line 2: the target cannot be observed from there: it is behind the camera",
        ),
        (plain("cx = 640", "cx = 640\nfree = [\"intrinsic\"]"), cell.rows.clone(), "intrinsics"),
    ] {
        let folder = Folder::empty();
        folder.write("robot.toml", &robot(&landmarks));
        folder.write("data.csv", &table);
        let run =
            folder.run(&["identify", "--robot", "robot.toml", "--data", "data.csv", "--out", "fit.json"]);
        let log = run.ended(INPUT).log;
        assert!(log.contains(words), "{words}\n{log}");
    }
}
