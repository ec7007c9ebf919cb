//! External axes that are joints of the fit: in programs, and held in poses.

use crate::folder::Folder;

/// An arm on a track, measured with two loads.
fn on_a_track() -> Folder {
    let folder = Folder::empty();
    let joint = |name: &str, limits: &str, xyz: &str, rpy: &str, axis: &str| {
        format!(
            "[[joints]]\nname = \"{name}\"\nlimits = {limits}\norigin = {{ xyz = {xyz}, rpy = {rpy}, axis = {axis} }}\n"
        )
    };
    let track = "[[joints]]\nname = \"rail\"\ntype = \"prismatic\"\nlimits = [-500, 4000]\norigin = { xyz = [0, 0, 0], axis = [0, 1, 0] }\n";
    let arm = [
        joint("j1", "[-170, 170]", "[0, 0, 520]", "[0, 0, 0]", "[0, 0, 1]"),
        joint("j2", "[-80, 130]", "[160, 0, 0]", "[0, 0, 0]", "[0, 1, 0]"),
        joint("j3", "[-170, 75]", "[0, 0, 870]", "[0, 0, 0]", "[0, 1, 0]"),
        joint("j4", "[-300, 300]", "[0, 0, 180]", "[0, 0, 0]", "[1, 0, 0]"),
        joint("j5", "[-120, 120]", "[940, 0, 0]", "[0, 0, 0]", "[0, 1, 0]"),
        joint("j6", "[-350, 350]", "[130, 0, 0]", "[0, 90, 0]", "[0, 0, 1]"),
    ]
    .concat();
    folder.write(
        "robot.toml",
        &format!(
            "name = \"rider\"\n[units]\nlength = \"mm\"\nangle = \"deg\"\n{track}{arm}[base]\nknown = false\n[tool]\nknown = false\n"
        ),
    );
    folder.write(
        "plant.toml",
        "robot = \"robot.toml\"\nseed = 9\n[errors.geometric]\nposition_mm = 0.4\nangle_mrad = 0.4\n[instrument]\nsd_um = 15\n\
         [repeatability]\nsd_um = 20\n[campaign]\npostures = \"random\"\nvisits = 140\npayloads_kg = [0, 40]\ncom_mm = [0, 0, 90]\n",
    );
    folder.run(&["simulate", "--plant", "plant.toml", "--out", "data.csv"]).ended(0);
    folder.run(&["identify", "--robot", "robot.toml", "--data", "data.csv", "--out", "fit.json"]).ended(0);
    folder
}

#[test]
fn an_external_axis_is_a_joint_that_stays() {
    let folder = on_a_track();
    let place =
        |x: f64, y: f64| format!("[[{x:.3},{y:.3},850.000],[0,0,1,0],[0,0,0,0],[1300,9E9,9E9,9E9,9E9,9E9]]");
    folder.write(
        "job.mod",
        &format!(
            "MODULE M\nPERS tooldata grip:=[TRUE,[[0,0,140],[1,0,0,0]],[38,[0,0,80],[1,0,0,0],0,0,0]];\n\
             PERS wobjdata table:=[FALSE,TRUE,\"\",[[200,0,0],[1,0,0,0]],[[0,0,0],[1,0,0,0]]];\nPROC main()\nConfL\\Off;\nConfJ\\Off;\n\
             MoveAbsJ [[0,5,5,0,40,0],[1300,9E9,9E9,9E9,9E9,9E9]],v100,fine,grip;\n\
             MoveJ {},v100,fine,grip\\WObj:=table;\nMoveL {},v100,fine,grip\\WObj:=table;\nENDPROC\nENDMODULE\n",
            place(850.0, 1350.0),
            place(850.0, 1200.0)
        ),
    );
    let run = |more: &str| {
        let words = format!("compensate --fit fit.json --program job.mod --out new.mod{more}");
        folder.run(&words.split(' ').collect::<Vec<_>>())
    };
    let log = run("").ended(2).log;
    assert!(
        log.contains("external axis eax_a is at 1300") && log.contains("--external eax_a=JOINT"),
        "{log}"
    );
    assert!(run(" --external eax_a=cart").ended(2).log.contains("the joint `cart`, which the fit has not"));
    let run = run(" --external eax_a=rail --tool-frame UT7=0mm,0mm,9mm,0,0,0").ended(0);
    assert!(run.out.contains("3 points: 3 corrected"), "{} {}", run.out, run.log);
    let new = folder.read("new.mod");
    assert_eq!(new.matches(",[1300,9E9,9E9,9E9,9E9,9E9]]").count(), 3, "{new}");
    let table = folder.read("new.mod.corrections.csv");
    let names: Vec<&str> = table.lines().next().unwrap().split(',').collect();
    let column = |name: &str| names.iter().position(|other| *other == name).unwrap();
    for line in table.lines().skip(1) {
        let value = |name: &str| line.split(',').nth(column(name)).unwrap().parse::<f64>().unwrap();
        assert!((value("nominal_rail[m]") - 1.3).abs() < 1e-12, "{line}");
        assert!((value("corrected_rail[m]") - 1.3).abs() < 1e-12, "{line}");
        assert!(value("within_95[m]") < 5e-4, "{line}");
    }
    // What the program states besides its points.
    assert!(run.log.contains("frames are taken as they are (TABLE)"), "{}", run.log);
    assert!(
        run.log.contains(
            "loads are those that the program states (--payload for another): GRIP of 38 kg (3 points)"
        ),
        "{}",
        run.log
    );
    assert!(run.log.contains("note: no point of the program uses the tool `UT7`"), "{}", run.log);

    // The same of poses: without --hold the track helps.
    folder.write(
        "poses.csv",
        "x[mm],y[mm],z[mm],qw,qx,qy,qz,rail[mm],j1[deg],j2[deg],j3[deg],j4[deg],j5[deg],j6[deg]\n1000,1350,900,0,0,1,0,1300,0,20,10,0,60,0\n",
    );
    let hold = |more: &str| {
        let words = format!("compensate --fit fit.json --poses poses.csv --out q.csv{more}");
        folder.run(&words.split(' ').collect::<Vec<_>>())
    };
    let rail = || -> f64 {
        let table = folder.read("q.csv");
        let names: Vec<&str> = table.lines().next().unwrap().split(',').collect();
        let at = names.iter().position(|name| name.starts_with("rail")).unwrap();
        table.lines().nth(1).unwrap().split(',').nth(at).unwrap().parse().unwrap()
    };
    hold("").ended(0);
    let free = rail();
    hold(" --hold rail").ended(0);
    assert!((rail() - 1300.0).abs() < 1e-9 && (free - 1300.0).abs() > 1e-3, "{free} {}", rail());
    assert!(hold(" --hold cart").ended(2).log.contains("--hold: poses.csv: the robot has no joint `cart`"));
    folder.write("bare.csv", "x[mm],y[mm],z[mm]\n1000,1350,900\n");
    let words = "compensate --fit fit.json --poses bare.csv --hold rail --out q.csv";
    let log = folder.run(&words.split(' ').collect::<Vec<_>>()).ended(2).log;
    assert!(log.contains("joint columns are needed"), "{log}");
}

#[test]
fn programs_of_a_backup_carry_what_those_that_they_call_select() {
    let folder = on_a_track();
    std::fs::create_dir(folder.file("b")).unwrap();
    let place = "P[1]{\n   GP1:\n\tUF : 0, UT : 0,\n\tJ1=    10.000 deg,\tJ2=    15.000 deg,\tJ3=     5.000 deg,\n\tJ4=    10.000 deg,\tJ5=    50.000 deg,\tJ6=    20.000 deg,\n\t\
                 E1=  1300.000  mm\n};\n";
    folder.write(
        "b/job.ls",
        &format!("/PROG  JOB\n/MN\n   1:  CALL GRIP ;\n   2:J P[1] 10% FINE ;\n/POS\n{place}/END\n"),
    );
    folder.write("b/grip.ls", "/PROG  GRIP\n/MN\n   1:  PAYLOAD[2] ;\n/POS\n/END\n");
    let field = |part: &str, value: f64| {
        format!("     Field: $PLST_GRP1[2].$PAYLOAD{part} Access: RW: REAL = {value:e}\n")
    };
    folder.write(
        "b/symotn.va",
        &[field("", 38.0), field("_X", 0.0), field("_Y", 0.0), field("_Z", 8.0)].concat(),
    );
    let run = |words: &str| folder.run(&words.split(' ').collect::<Vec<_>>()).ended(0);
    let said = run("compensate --fit fit.json --program b --external E1=rail --out new");
    assert!(said.log.contains("PAYLOAD[2] of 38 kg (1 point)"), "{} {}", said.out, said.log);
    assert!(said.out.contains("not written: no points: grip.ls"), "{}", said.out);
    let alone = run("compensate --fit fit.json --program b/job.ls --external E1=rail --out alone.ls").log;
    assert!(alone.contains("GRIP is called in line 3, which may change PAYLOAD"), "{alone}");
}
