//! Files with names of columns of their own: a fit remembers them for the verbs that use it.

use crate::folder::Folder;

/// Measurements whose columns have an office's names, a fit of them, and the same with our names.
fn offices() -> Folder {
    let folder = Folder::with_data();
    let text = folder.read("data.csv");
    let (header, rows) = text.split_once('\n').unwrap();
    let names = header.replacen("j1[deg]", "Axis A [deg]", 1).replacen("x[mm]", "Pos X [mm]", 1);
    assert!(names.contains("Axis A") && names.contains("Pos X"), "{header}");
    folder.write("office.csv", &format!("{names}\n{rows}"));
    folder.write("mapped.toml", &format!("{}\n[columns]\nx = \"Pos X\"\n", folder.read("robot.toml")));
    let of = [
        "identify",
        "--robot",
        "mapped.toml",
        "--data",
        "office.csv",
        "--map",
        "j1=Axis A",
        "--out",
        "fit.json",
    ];
    folder.run(&of).ended(0);
    folder
}

#[test]
fn a_fit_reads_other_files_with_the_columns_of_its_data() {
    let folder = offices();
    for (data, out) in [("office.csv", "office.out.csv"), ("data.csv", "own.out.csv")] {
        folder.run(&["predict", "--fit", "fit.json", "--data", data, "--out", out]).ended(0);
    }
    assert_eq!(folder.read("office.out.csv"), folder.read("own.out.csv"));
    for verb in ["transfer", "monitor"] {
        let mut of = vec![verb, "--fit", "fit.json", "--data", "office.csv"];
        if verb == "transfer" {
            of.extend(["--out", "there.json"]);
        }
        folder.run(&of).ended(0);
    }
    let poses = "Pos X [mm],y[mm],z[mm],target\n400,100,500,T1\n";
    folder.write("poses.csv", poses);
    folder.run("compensate --fit fit.json --poses poses.csv --out commands.csv").ended(0);
    assert!(folder.read("commands.csv").lines().count() == 2);
}

#[test]
fn a_map_of_ones_own_wins_and_has_to_be_met() {
    let folder = offices();
    let text = folder.read("office.csv").replacen("Axis A", "Achse 1", 1);
    folder.write("other.csv", &text);
    let plain = ["predict", "--fit", "fit.json", "--data", "other.csv", "--out", "p.csv"];
    let said = folder.run(&plain).ended(2).log;
    assert!(said.contains("j1"), "{said}");
    let mut mapped = plain.to_vec();
    mapped.extend(["--map", "j1=Achse 1"]);
    folder.run(&mapped).ended(0);
    let mut wrong = plain.to_vec();
    wrong.extend(["--map", "j1=Achse 9"]);
    let said = folder.run(&wrong).ended(2).log;
    assert!(said.contains("`j1` is mapped to the column `Achse 9`, which is not in this file"), "{said}");
}

#[test]
fn several_points_are_not_read_as_one() {
    let folder = Folder::with_data();
    let robot = folder.read("robot.toml");
    let (arm, _) = robot.split_once("[[targets]]").unwrap();
    folder.write("no_targets.toml", arm);
    let text = folder.read("data.csv");
    let (header, rows) = text.split_once('\n').unwrap();
    assert!(header.split(',').any(|name| name == "target"), "{header}");
    folder.write("unnamed.csv", &format!("{}\n{rows}", header.replacen("target", "Point Name", 1)));
    for verb in ["check", "identify", "discover"] {
        let of = [verb, "--robot", "no_targets.toml", "--data", "unnamed.csv"];
        let said = folder.run(&of).ended(2).log;
        assert!(said.contains("they are several points") && said.contains("target=Point Name"), "{said}");
    }
    // Named, they are what they are.
    let of = ["check", "--robot", "robot.toml", "--data", "unnamed.csv", "--map", "target=Point Name"];
    folder.run(&of).ended(0);
}
