//! Robots of the library, as a new user gets one.

use crate::folder::Folder;

#[test]
fn a_robot_and_a_table_to_fill_in() {
    let folder = Folder::empty();
    let listed = folder.run("init --list").ended(0).out;
    assert!(listed.lines().count() > 30 && listed.contains("Universal Robots UR10e"), "{listed}");

    let run = ["init", "UR10e", "--out", "my.toml", "--csv", "my.csv"];
    let out = folder.run(&run).ended(0).out;
    // As the pendant shows it: see the tests of the library.
    assert!(out.contains("flange at all zeros: xyz -1184.25 -290.70 60.85 mm"), "{out}");
    assert!(out.contains("truepose check --robot my.toml --data my.csv"), "{out}");
    let header = folder.read("my.csv").lines().find(|line| !line.starts_with('#')).unwrap().to_owned();
    assert_eq!(header, "j1[deg],j2[deg],j3[deg],j4[deg],j5[deg],j6[deg],x[mm],y[mm],z[mm]");

    // Once filled in, it is checked. All poses but one joint are the same: nothing can be said about the robot.
    let mut table = folder.read("my.csv");
    table += "0,0,0,0,0,0,1000,200,300\n";
    folder.write("my.csv", &table);
    folder.run("check --robot my.toml --data my.csv").ended(0);

    // Nothing is written over.
    let log = folder.run(&run).ended(2).log;
    assert!(log.contains("my.toml: the file exists"), "{log}");
    let log = folder.run("init kr6").ended(2).log;
    assert!(log.contains("did you mean kr6-r900-2?"), "{log}");
    assert_eq!(folder.names(), ["my.csv", "my.toml"]);
    folder.run("init").ended(2);
}

#[test]
fn a_robot_that_is_not_in_the_library_has_rows_to_fill_in() {
    let folder = Folder::empty();
    let out = folder.run("init --dh 4 --csv d.csv").ended(0).out;
    assert!(out.contains("4 revolute joints, written to robot.toml"), "{out}");
    assert!(out.contains("truepose check --robot robot.toml --data d.csv"), "{out}");
    let header = folder.read("d.csv").lines().find(|line| !line.starts_with('#')).unwrap().to_owned();
    assert_eq!(header, "j1[deg],j2[deg],j3[deg],j4[deg],x[mm],y[mm],z[mm]");
    // A SCARA, filled in: two links of 300 and 250 mm, a slide, and a turn about its axis.
    let mut text = folder.read("robot.toml");
    for (row, filled) in [
        (1, "dh = { theta = 0, d = 400, a = 300, alpha = 0 }"),
        (2, "dh = { theta = 0, d = 0, a = 250, alpha = 180 }"),
        (3, "type = \"prismatic\"\ndh = { theta = 0, d = 100, a = 0, alpha = 0 }"),
    ] {
        let empty = format!(
            "name = \"j{row}\"\n# limits = [-180, 180]\ndh = {{ theta = 0, d = 0, a = 0, alpha = 0 }}"
        );
        assert!(text.contains(&empty), "{text}");
        text = text.replace(&empty, &format!("name = \"j{row}\"\n{filled}"));
    }
    folder.write("robot.toml", &text);
    let checked = folder.run("check --robot robot.toml").ended(0).out;
    assert!(checked.contains("flange at all zeros: xyz 550.00 0.00 300.00 mm"), "{checked}");
    // Modified parameters are the same rows by another word, and columns of other names are mapped in the same file.
    let other = text
        .replace("dh =", "mdh =")
        .replace("# [columns]\n# j1 = \"A1 [deg]\"", "[columns]\nj1 = \"A1 [deg]\"");
    folder.write("mdh.toml", &other);
    folder.run("check --robot mdh.toml").ended(0);
    assert!(folder.run("init --dh 4").ended(2).log.contains("robot.toml: the file exists"));
    folder.run("init --dh 0 --out none.toml").ended(2);
    folder.run("init ur5 --dh 6").ended(2);
}
