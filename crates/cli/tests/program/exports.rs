//! Columns under an office's names, as `check` and `compensate` take them.

use crate::folder::Folder;

/// The measurements with other names for the columns.
fn renamed(folder: &Folder, names: &[(&str, &str)]) -> String {
    let text = folder.read("data.csv");
    let (header, rows) = text.split_once('\n').unwrap();
    let header = names.iter().fold(header.to_owned(), |header, (ours, theirs)| {
        assert!(header.contains(ours), "{header}");
        header.replacen(ours, theirs, 1)
    });
    format!("{header}\n{rows}")
}

#[test]
fn check_says_that_nothing_was_measured_and_what_may_be() {
    let folder = Folder::with_data();
    let names = [("x[mm]", "Mess. X [mm]"), ("y[mm]", "Mess. Y [mm]"), ("z[mm]", "Mess. Z [mm]")];
    folder.write("d.csv", &renamed(&folder, &names));
    let check = ["check", "--robot", "robot.toml", "--data", "d.csv"];
    let said = folder.run(&check).ended(2).log;
    assert!(said.contains("identify will refuse"), "{said}");
    assert!(said.contains("--map \"x=Mess. X [mm]\"") && said.contains("x = \"Mess. X [mm]\""), "{said}");
    let mut mapped = check.to_vec();
    mapped.extend(["--map", "x=Mess. X [mm]", "--map", "y=Mess. Y [mm]", "--map", "z=Mess. Z [mm]"]);
    folder.run(&mapped).ended(0);
}

#[test]
fn capitals_are_read_with_a_warning() {
    let folder = Folder::with_data();
    folder
        .write("d.csv", &renamed(&folder, &[("x[mm]", "X (mm)"), ("y[mm]", "Y (mm)"), ("z[mm]", "Z (mm)")]));
    let said = folder.run("check --robot robot.toml --data d.csv").ended(0).log;
    assert!(said.contains("`X (mm)`, `Y (mm)`, `Z (mm)` are read as x, y, z"), "{said}");
}

#[test]
fn compensate_takes_names_of_columns() {
    let folder = Folder::with_data();
    folder.run("identify --robot robot.toml --data data.csv --out fit.json").ended(0);
    folder.write("poses.csv", "East [mm],y[mm],z[mm],target,Remark\n400,100,500,T1,3\n");
    let plain = ["compensate", "--fit", "fit.json", "--poses", "poses.csv", "--out", "commands.csv"];
    folder.run(&plain).ended(2);
    let mut mapped = plain.to_vec();
    mapped.extend(["--map", "x=East [mm]", "--ignore", "Remark", "--orientation", "abc"]);
    let said = folder.run(&mapped).ended(0).log;
    assert!(said.contains("orientation left free in 1 pose"), "{said}");
}
