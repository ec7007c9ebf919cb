//! A load in the columns of a file, looks with a date and a specification, and parameters that cannot be written.

use crate::folder::Folder;

/// A robot whose parameters have no table: the fit is written all the same.
#[test]
fn parameters_that_cannot_be_written_leave_the_fit() {
    let folder = Folder::with_data();
    let tree = format!(
        "{}\n[[tools]]\nname = \"A\"\njoint = \"d3\"\n[[tools]]\nname = \"B\"\njoint = \"j2\"\nxyz = [0, 0, 50]\n",
        {
            let robot = folder.read("robot.toml");
            robot.replace("[[targets]]\n", "[[targets]]\ntool = \"A\"\n")
        }
    );
    folder.write("robot.toml", &tree);
    let run = [
        "identify",
        "--robot",
        "robot.toml",
        "--data",
        "data.csv",
        "--out",
        "fit.json",
        "--parameters",
        "p.csv",
    ];
    let log = folder.run(&run).ended(2).log;
    assert!(log.contains("--parameters: ") && log.contains("wrote fit.json"), "{log}");
    assert!(folder.file("fit.json").exists() && !folder.file("p.csv").exists());
}

#[test]
fn a_wrench_is_no_channel() {
    let folder = Folder::with_data();
    let text = folder.read("data.csv");
    let mut lines = text.lines();
    let mut out = format!("{},Fx_N,Fy_N,Fz_N,Mx_Nm,My_Nm,Mz_Nm\n", lines.next().unwrap());
    lines.for_each(|line| out += &format!("{line},1,2,-30,0.1,0.2,0.3\n"));
    folder.write("data.csv", &out);
    let check = folder.run("check --robot robot.toml --data data.csv --json").ended(0);
    let words = "are a wrench by their names and are not read: a load is no channel";
    assert!(check.log.contains(words) && check.log.contains("--map \"tz=Mz_Nm\""), "{}", check.log);
    assert!(!check.out.contains("\"channel"), "{}", check.out);
    let mapped = ["fx=Fx_N", "fy=Fy_N", "fz=Fz_N", "tx=Mx_Nm", "ty=My_Nm", "tz=Mz_Nm"]
        .map(|map| ["--map", map])
        .concat();
    let run = [&["check", "--robot", "robot.toml", "--data", "data.csv"][..], &mapped].concat();
    let out = folder.run(&run).ended(0);
    assert!(!out.log.contains(words), "{}", out.log);
}

#[test]
fn a_look_has_a_specification_a_certificate_and_a_date() {
    let folder = Folder::with_data();
    folder.run("identify --robot robot.toml --data data.csv --out fit.json").ended(0);
    let plant = folder.read("plant.toml").replace("visits = 40", "visits = 12");
    folder.write("look.toml", &plant);
    folder.write("head.toml", "[certificate]\nserial = \"SN-17\"\n");
    for (seed, date) in [("7", "2026-03-02"), ("8", "2026-04-01")] {
        folder
            .run(&["simulate", "--plant", "look.toml", "--campaign-seed", seed, "--out", "look.csv"])
            .ended(0);
        let look = [
            "monitor",
            "--fit",
            "fit.json",
            "--data",
            "look.csv",
            "--date",
            date,
            "--spec",
            "0.5mm",
            "--certificate",
            "head.toml",
            "--history",
            "h.json",
            "--report",
            "r",
        ];
        folder.run(&look).ended(0);
    }
    let (page, result) = (folder.read("r/index.html"), folder.json("r/monitor.json"));
    assert_eq!(
        (&result["date"], &result["specification"]["inside"]),
        (&"2026-04-01".into(), &result["specification"]["poses"])
    );
    for words in ["SN-17", "2026-04-01", "days since 2026-03-02", "Specification 0.500 mm"] {
        assert!(page.contains(words), "{words}");
    }
    assert_eq!(folder.json("h.json")["looks"][0]["date"], "2026-03-02");
    let run = ["monitor", "--fit", "fit.json", "--data", "look.csv", "--spec", "0.001mm"];
    assert!(folder.run(&run).ended(1).log.contains("not met: Specification"));
    let bad = folder.run("monitor --fit fit.json --data look.csv --date 1.4.2026").ended(2).log;
    assert!(bad.contains("a date is year-month-day"), "{bad}");
}
