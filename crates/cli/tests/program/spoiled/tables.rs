//! Mistakes that no cell shows: the whole table does, and the likely cause is said.

use super::remarks;
use crate::folder::Folder;

const ARM: &str = r#"name = "six"

[units]
length = "mm"
angle = "deg"

[base]
xyz = [300, -200, 500]
rpy = [0, 0, 30]

[[joints]]
name = "a1"
type = "revolute"
mdh = { alpha = 0, a = 0, theta = 0, d = 400 }

[[joints]]
name = "a2"
type = "revolute"
mdh = { alpha = -90, a = 180, theta = -90, d = 0 }

[[joints]]
name = "a3"
type = "revolute"
mdh = { alpha = 0, a = 600, theta = 0, d = 0 }

[[joints]]
name = "a4"
type = "revolute"
mdh = { alpha = -90, a = 120, theta = 0, d = 640 }

[[joints]]
name = "a5"
type = "revolute"
mdh = { alpha = 90, a = 0, theta = 0, d = 0 }

[[joints]]
name = "a6"
type = "revolute"
mdh = { alpha = -90, a = 0, theta = 0, d = 100 }

[[targets]]
name = "T1"
xyz = [90, 0, 120]

[[targets]]
name = "T2"
xyz = [-40, 110, 60]
"#;

const PLANT: &str = r#"robot = "robot.toml"
seed = 5

[errors.geometric]
position_mm = 0.5
angle_mrad = 0.8

[instrument]
sd_um = 20

[campaign]
postures = "random"
visits = 60
"#;

/// A change of all rows: numbers of a1 … a6, x, y, z, and the target.
type Change = fn(&mut Vec<Vec<f64>>, &mut Vec<String>);

fn column(rows: &mut [Vec<f64>], k: usize, change: impl Fn(f64) -> f64) {
    rows.iter_mut().for_each(|row| row[k] = change(row[k]));
}

const MISTAKES: &[(&str, Change)] = &[
    ("nothing is wrong", |_, _| ()),
    ("x and y swapped", |rows, _| rows.iter_mut().for_each(|r| r.swap(6, 7))),
    ("y and z swapped", |rows, _| rows.iter_mut().for_each(|r| r.swap(7, 8))),
    ("wrong handedness", |rows, _| column(rows, 8, |z| -z)),
    ("metres as millimetres", |rows, _| (6..9).for_each(|k| column(rows, k, |v| v * 1e-3))),
    ("micrometres as millimetres", |rows, _| (6..9).for_each(|k| column(rows, k, |v| v * 1e3))),
    ("inches as millimetres", |rows, _| (6..9).for_each(|k| column(rows, k, |v| v / 25.4))),
    ("radians as degrees", |rows, _| (0..6).for_each(|k| column(rows, k, f64::to_radians))),
    ("joints one place late", |rows, _| rows.iter_mut().for_each(|r| r[..6].rotate_right(1))),
    ("joints one place early", |rows, _| rows.iter_mut().for_each(|r| r[..6].rotate_left(1))),
    ("joints from tip to base", |rows, _| rows.iter_mut().for_each(|r| r[..6].reverse())),
    ("two joints swapped", |rows, _| rows.iter_mut().for_each(|r| r.swap(1, 2))),
    ("a joint that counts the other way", |rows, _| column(rows, 2, |q| -q)),
    ("a zero that is elsewhere", |rows, _| column(rows, 1, |q| q + 90.0)),
    ("joints of the visit before", |rows, _| {
        // Two rows a visit.
        let joints: Vec<Vec<f64>> = rows.iter().map(|r| r[..6].to_vec()).collect();
        for k in 2..rows.len() {
            rows[k][..6].copy_from_slice(&joints[k - 2]);
        }
    }),
    ("targets swapped", |_, names| {
        for name in names {
            *name = if name == "T1" { "T2".into() } else { "T1".into() };
        }
    }),
    ("one wild row", |rows, _| rows[30][7] += 1000.0),
    ("three rows with two targets' names exchanged", |_, names| {
        [10, 40, 70].into_iter().for_each(|k| names.swap(k, k + 1))
    }),
    ("a base that stands elsewhere", |rows, _| {
        for row in rows {
            (row[6], row[7]) = (-row[7] + 4000.0, row[6]);
        }
    }),
];

#[test]
fn the_likely_cause_is_reported() {
    let folder = Folder::empty();
    folder.write("robot.toml", ARM);
    folder.write("lost.toml", &ARM.replace("[base]", "[base]\nknown = false"));
    folder.write("plant.toml", PLANT);
    folder.run(&["simulate", "--plant", "plant.toml", "--out", "simulated.csv"]).ended(0);
    let table = folder.read("simulated.csv");
    let cells: Vec<Vec<&str>> = table.lines().skip(1).map(|line| line.split(',').collect()).collect();
    assert!(
        table.starts_with("a1[deg],a2[deg],a3[deg],a4[deg],a5[deg],a6[deg],x[mm],y[mm],z[mm],target,visit")
    );
    let mut said = String::new();
    for (what, change) in MISTAKES {
        let mut rows: Vec<Vec<f64>> =
            cells.iter().map(|row| row[..9].iter().map(|cell| cell.parse().unwrap()).collect()).collect();
        let mut names: Vec<String> = cells.iter().map(|row| row[9].to_owned()).collect();
        change(&mut rows, &mut names);
        let mut text =
            "a1[deg],a2[deg],a3[deg],a4[deg],a5[deg],a6[deg],x[mm],y[mm],z[mm],target\n".to_owned();
        for (row, name) in rows.iter().zip(&names) {
            text += &row.iter().map(|v| format!("{v:.5},")).collect::<String>();
            text += &format!("{name}\n");
        }
        folder.write("data.csv", &text);
        for (robot, place) in [("robot.toml", "base known"), ("lost.toml", "base unknown")] {
            let told = remarks(&folder.run(&["check", "--robot", robot, "--data", "data.csv"]).ended(0));
            said += &format!("{what}, {place}\n    {told}\n");
            let silent = *what == "nothing is wrong" || (robot == "lost.toml" && what.starts_with("a base"));
            assert_eq!(told == "[0] ", silent, "{what}, {place}: {told}");
        }
    }
    insta::assert_snapshot!(said);
}
