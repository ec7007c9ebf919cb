//! Robots of the library, as a new user gets one.

use crate::folder::Folder;

#[test]
fn a_robot_and_a_table_to_fill_in() {
    let folder = Folder::empty();
    let listed = folder.run(&["init", "--list"]).ended(0).out;
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
    folder.run(&["check", "--robot", "my.toml", "--data", "my.csv"]).ended(0);

    // Nothing is written over.
    let log = folder.run(&run).ended(2).log;
    assert!(log.contains("my.toml: the file exists"), "{log}");
    let log = folder.run(&["init", "kr6"]).ended(2).log;
    assert!(log.contains("did you mean kr6-r900-2?"), "{log}");
    assert_eq!(folder.names(), ["my.csv", "my.toml"]);
    folder.run(&["init"]).ended(2);
}
