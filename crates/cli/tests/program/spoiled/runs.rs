//! What is asked for, where nothing is wrong with a file: to write over what is read, more than any memory holds, less than nothing.

use super::remarks;
use crate::folder::Folder;
use std::time::{Duration, Instant};

/// What is run, in words of a shell without quotes; FIT is what `identify` made of the data.
const REFUSED: &[&str] = &[
    // Over what is read, or twice.
    "identify --robot robot.toml --data data.csv --out data.csv",
    "identify --robot robot.toml --data data.csv --out ./deep/../robot.toml",
    "identify --robot robot.toml --data data.csv --model model.toml --out link.toml",
    "identify --robot robot.toml --data data.csv --report page --out page",
    "identify --robot robot.toml --data data.csv --report page --out page/run.json",
    "discover --robot robot.toml --data data.csv --out data.csv",
    "predict --fit FIT --data data.csv --out FIT",
    "predict --fit FIT --data data.csv --out data.csv",
    "compensate --fit FIT --poses data.csv --out data.csv",
    "plan --fit FIT --rival other.json --out other.json",
    "map --fit FIT --out FIT",
    "export --fit FIT --format urdf --out FIT",
    "simulate --plant plant.toml --out plant.toml",
    "simulate --plant plant.toml --out robot.toml",
    "identify --robot robot.toml --data -",
    "identify --robot robot.toml --data data.csv --out -",
    // Less than nothing.
    "identify --robot robot.toml --data data.csv --seed -1",
    "identify --robot robot.toml --data data.csv --folds -2",
    "identify --robot robot.toml --data data.csv --holdout -0.1",
    "identify --robot robot.toml --data data.csv --spec -1mm",
    "identify --robot robot.toml --data data.csv --threads -1",
    "discover --robot robot.toml --data data.csv --alpha -1",
    "discover --robot robot.toml --data data.csv --rotations -1",
    "plan --fit FIT --count -3 --out out.csv",
    "check --robot robot.toml --time-limit -1s",
    "check --robot robot.toml --memory-limit -1GB",
    // More than there is.
    "identify --robot robot.toml --data data.csv --holdout 0.999",
    "identify --robot robot.toml --data data.csv --fold-by zone",
    "discover --robot robot.toml --data data.csv --rotations 1000000000000",
    "plan --fit FIT --pool 1000000000 --out out.csv",
    "plan --fit FIT --count 1000000000 --out out.csv",
    "map --fit FIT --points 1000 --out out.csv",
    "simulate --plant many.toml --out out.csv",
    "simulate --plant grid.toml --out out.csv",
    "discover --robot robot.toml --data few.csv",
    "discover --robot robot.toml --data one.csv",
    "compare --robot robot.toml --data one.csv",
    // What a model needs and the rows lack.
    "identify --robot robot.toml --data data.csv --model warm.toml",
    "discover --robot robot.toml --data data.csv --model warm.toml",
    "predict --fit warm.json --data data.csv --out out.csv",
    "compensate --fit warm.json --poses poses.csv --out out.csv",
    "predict --fit warm.json --data radians.csv --out out.csv",
    // Files that are something else.
    "simulate --plant nothing.toml --out out.csv",
    "simulate --plant none.toml --out out.csv",
    "simulate --plant negative.toml --out out.csv",
    "simulate --plant unknown.toml --out out.csv",
    "verify data.csv",
    "verify other.json",
    "identify --robot robot.toml --data data.csv --model frames.toml",
    "identify --robot robot.toml --data data.csv --model joints.toml",
    "map --fit variance.json --out out.csv",
    "map --fit noise.json --out out.csv",
    "compensate --fit long.json --poses poses.csv --out out.csv",
];

fn folder() -> Folder {
    let folder = Folder::with_data();
    let identify = "identify --robot robot.toml --data data.csv --folds 0 --out fit.json";
    folder.run(&words(identify)).ended(0);
    let fit = folder.read("fit.json");
    folder.write("other.json", &fit);
    folder.write("model.toml", "[[effects]]\nfamily = \"geometric\"\n");
    folder.write("frames.toml", "[[effects]]\nfamily = \"geometric\"\nframes = []\n");
    folder.write("joints.toml", "[[effects]]\nfamily = \"joint_compliance\"\njoints = []\n");
    std::fs::create_dir(folder.file("deep")).unwrap();
    std::os::unix::fs::symlink("model.toml", folder.file("link.toml")).unwrap();
    let plant = folder.read("plant.toml");
    for (name, from, to) in [
        ("many.toml", "visits = 40", "visits = 100000000"),
        ("grid.toml", "postures = \"random\"\nvisits = 40", "postures = \"grid\"\npoints = 100000"),
        ("none.toml", "visits = 40", "visits = 0"),
        ("negative.toml", "visits = 40", "visits = -3"),
        ("unknown.toml", "[instrument]", "[[errors.transmission]]\njoint = \"j9\"\n\n[instrument]"),
    ] {
        assert!(plant.contains(from), "{name}");
        folder.write(name, &plant.replace(from, to));
    }
    folder.write("nothing.toml", "");
    let mut value: serde_json::Value = serde_json::from_str(&fit).unwrap();
    value["covariance"][0][0] = (-1.0).into();
    folder.write("variance.json", &value.to_string());
    let mut value: serde_json::Value = serde_json::from_str(&fit).unwrap();
    value["noise"]["position_sd"] = (-1e-5).into();
    folder.write("noise.json", &value.to_string());
    folder.write("poses.csv", "x[mm],y[mm],z[mm]\n500,0,300\n");
    long(&folder);
    let data = folder.read("data.csv");
    let with = |name: &str, unit: &str| {
        let row = |(k, line): (usize, &str)| match k {
            0 => format!("{line},oil[{unit}]\n"),
            _ => format!("{line},{}\n", 20 + k % 7),
        };
        folder.write(name, &data.lines().enumerate().map(row).collect::<String>());
    };
    with("warm.csv", "degC");
    with("radians.csv", "rad");
    let thermal = "family = \"thermal\"\njoint = \"j1\"\nchannel = \"oil\"\nlag = 60\n";
    folder.write("warm.toml", &format!("[[effects]]\n{thermal}"));
    let identify = "identify --robot robot.toml --data warm.csv --model warm.toml --folds 0 --out warm.json";
    folder.run(&words(identify)).ended(0);
    let first = |lines: usize| data.lines().take(lines).map(|line| format!("{line}\n")).collect::<String>();
    folder.write("few.csv", &first(9));
    folder.write("one.csv", &first(3));
    folder
}

/// Writes `long.json`, a fit of a robot with more joints than a command has room for.
fn long(folder: &Folder) {
    let joint = |k: usize| {
        format!(
            "[[joints]]\nname = \"a{k}\"\ntype = \"revolute\"\ndh = {{ theta = 0, d = 0.1, a = 0.1, alpha = 0.7 }}\n"
        )
    };
    folder.write("long.toml", &format!("name = \"long\"\n{}", (0..20).map(joint).collect::<String>()));
    folder
        .write("plant_long.toml", "robot = \"long.toml\"\n[campaign]\npostures = \"random\"\nvisits = 30\n");
    folder.run(&words("simulate --plant plant_long.toml --out long.csv")).ended(0);
    folder.run(&words("identify --robot long.toml --data long.csv --folds 0 --out long.json")).ended(0);
}

fn words(line: &str) -> Vec<&str> {
    line.split(' ').map(|word| if word == "FIT" { "fit.json" } else { word }).collect()
}

/// Seconds in which each of these is refused on a slow machine: most take hundredths.
const SECONDS: u64 = 10;

#[test]
fn what_cannot_be_meant_is_refused() {
    let folder = folder();
    let contents = || -> Vec<Option<Vec<u8>>> {
        folder.names().iter().map(|name| std::fs::read(folder.file(name)).ok()).collect()
    };
    let (names, before) = (folder.names(), contents());
    let mut said = String::new();
    for line in REFUSED {
        let began = Instant::now();
        let run = folder.run(&words(line)).ended(2);
        assert!(began.elapsed() < Duration::from_secs(SECONDS), "{line} took {:?}", began.elapsed());
        assert_eq!(run.out, "", "{line}");
        assert_eq!(folder.names(), names, "{line}: a file was left behind");
        assert!(contents() == before, "{line}: a file was changed");
        // What is there to be typed stands in other snapshots.
        let told = remarks(&run);
        said += &format!("{line}\n    {}\n", told.split("\n    \n").next().unwrap_or(&told));
    }
    insta::assert_snapshot!(said);
}

#[cfg(target_os = "linux")]
#[test]
fn names_that_are_no_text_are_names() {
    use std::ffi::OsStr;
    use std::os::unix::ffi::OsStrExt;
    let folder = Folder::with_data();
    let (data, fit, page) =
        (OsStr::from_bytes(b"m\xe4.csv"), OsStr::from_bytes(b"f\xe4.json"), OsStr::from_bytes(b"r\xe4"));
    std::fs::rename(folder.file("data.csv"), folder.path().join(data)).unwrap();
    let run = |arguments: &[&OsStr]| {
        let program = std::process::Command::new(env!("CARGO_BIN_EXE_truepose"))
            .current_dir(folder.path())
            .args(arguments)
            .output()
            .unwrap();
        (program.status.code(), String::from_utf8_lossy(&program.stderr).into_owned())
    };
    let s = OsStr::new;
    let identify = [
        s("identify"),
        s("--robot"),
        s("robot.toml"),
        s("--data"),
        data,
        s("--out"),
        fit,
        s("--report"),
        page,
    ];
    let (code, log) = run(&identify);
    assert_eq!(code, Some(0), "{log}");
    assert!(log.contains("is not UTF-8: `truepose verify` cannot repeat this run"), "{log}");
    let (code, log) =
        run(&[s("predict"), s("--fit"), fit, s("--data"), data, s("--out"), s("p.csv"), s("--json")]);
    assert_eq!(code, Some(0), "{log}");
    let (code, log) = run(&[s("verify"), folder.path().join(page).join("run.json").as_os_str()]);
    assert_eq!(code, Some(2), "{log}");
    assert!(log.starts_with("error: m\u{fffd}.csv: cannot be read"), "{log}");
}

#[test]
fn names_that_would_steer_a_terminal_are_shown() {
    let folder = Folder::with_data();
    let name = "\u{1b}[31mred.csv";
    folder.write(name, "x\n1\n");
    let run = folder.run(&["identify", "--robot", "robot.toml", "--data", name]).ended(2);
    assert!(run.log.starts_with("error: \\u{1b}[31mred.csv:1: "), "{}", run.log);
}

/// Between one range and the next the search steps over neither end.
#[test]
fn a_range_of_periods_may_begin_near_nothing() {
    let folder = Folder::with_data();
    folder.write(
        "model.toml",
        "[[effects]]\nfamily = \"transmission\"\njoint = \"j1\"\nperiod_range = [1e-9, 1.0]\n",
    );
    folder
        .run(&["identify", "--robot", "robot.toml", "--data", "data.csv", "--model", "model.toml"])
        .ended(0);
}

#[test]
fn folds_are_of_what_is_not_locked_away() {
    let folder = Folder::with_data();
    let few: String = folder.read("data.csv").lines().take(13).map(|line| format!("{line}\n")).collect();
    folder.write("data.csv", &few);
    let run = folder.run(&words("identify --robot robot.toml --data data.csv --holdout 0.5")).ended(0);
    assert!(run.log.contains("warning: 3 configurations make at most 3 folds"), "{}", run.log);
}

#[test]
fn positions_that_stand_still_while_the_robot_moves_are_remarked_upon() {
    let folder = Folder::with_data();
    let data = folder.read("data.csv");
    let row = |(k, line): (usize, &str)| {
        let mut cells: Vec<&str> = line.split(',').collect();
        if k > 0 {
            cells[3..6].fill("12.5");
        }
        cells.join(",") + "\n"
    };
    folder.write("data.csv", &data.lines().enumerate().map(row).collect::<String>());
    let run = folder.run(&words("identify --robot robot.toml --data data.csv --folds 0")).ended(0);
    let told =
        "data.csv:1: column `x[mm]` (4): never changes, nor do the other two, although the robot moves: ";
    assert!(run.log.contains(told), "{}", run.log);
}
