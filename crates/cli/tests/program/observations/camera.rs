//! A camera that stands in the cell.

use super::cell::{Cell, EYE, LANDMARKS, TOOL, identified, kind, robot};
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
    let run = folder.run("identify --robot robot.toml --data data.csv").ended(INPUT);
    assert!(
        run.log.contains("landmark eye: ") && run.log.contains("the scale is not determined"),
        "{}",
        run.log
    );
}

/// A tag of known corners on a tool of unknown place, seen by a camera of unknown place: how long anything is, is known by the tag.
#[test]
fn a_tag_of_known_size_on_the_tool_gives_the_scale() {
    let mut cell = Cell::new(6);
    let corners = [[-0.04, -0.04, 0.01], [0.04, -0.04, 0.01], [0.04, 0.04, 0.01], [-0.04, 0.04, 0.01]];
    // The tool's x, y, z are y, z, x of the flange.
    let of_flange = corners.map(|[x, y, z]| [TOOL[0] + z, TOOL[1] + x, TOOL[2] + y]);
    let data = cell.images(45, &of_flange);
    let tag: String = (0..4)
        .map(|k| format!("[[targets]]\nname = \"c{k}\"\nxyz = {:?}\n", corners[k].map(|v| 1e3 * v)))
        .collect();
    let placed = robot(&(LANDMARKS.to_owned() + &tag));
    let tool = placed.split_once("[tool]\n").unwrap().1.lines().next().unwrap();
    let folder = Folder::empty();
    folder.write("robot.toml", &placed.replacen(tool, "known = false", 1));
    folder.write("data.csv", &data);
    let words = "identify --robot robot.toml --data data.csv --out fit.json";
    let run = folder.run(words).ended(0);
    assert!(run.log.contains("the targets on the tool alone determine the scale"), "{}", run.log);
    assert!(!run.log.contains("scale is not determined"), "{}", run.log);
    let found = folder.run(&format!("{words} --json")).ended(0).out;
    let found: serde_json::Value = serde_json::from_str(&found).unwrap();
    let eye = &found["kinds"]["sensors"][0]["values"];
    for (k, at) in EYE.iter().enumerate() {
        let found = eye[k][1].as_f64().unwrap();
        // In the frame of the base as described: the first joint is off by up to 3 mrad, the camera 2.2 m away.
        assert!((found - 1e3 * at).abs() < 10.0, "{found} mm for {at} m");
    }
    // A corner is seen to 0.04 px of 30 px that the tag is wide: a thousandth an image, of 45 images.
    let lengths = cell.lengths(&folder);
    assert!(lengths < 0.4, "{lengths} mm");
    // With one corner alone the scale is not determined, and the message contains that and nothing else.
    let one: Vec<&str> = data
        .lines()
        .filter(|line| !line.contains(",c1,") && !line.contains(",c2,") && !line.contains(",c3,"))
        .collect();
    folder.write("data.csv", &(one.join("\n") + "\n"));
    let log = folder.run(words).ended(INPUT).log;
    assert!(log.contains("landmark eye: the scale is not determined") && !log.contains("the base"), "{log}");
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
        let run = folder.run("identify --robot robot.toml --data data.csv --out fit.json");
        let log = run.ended(INPUT).log;
        assert!(log.contains(words), "{words}\n{log}");
    }
}
