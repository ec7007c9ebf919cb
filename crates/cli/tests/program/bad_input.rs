//! Whatever is wrong with a file is said with its place, ends with exit code 2, and leaves nothing behind.

use crate::folder::{Folder, ROBOT};

/// One way in which input can be wrong.
struct Case {
    what: &'static str,
    /// Spoils the folder.
    spoil: fn(&Folder),
    /// Everything behind `truepose`.
    run: &'static [&'static str],
    /// The place that the message begins with: file, line, column.
    place: &'static str,
}

const IDENTIFY: &[&str] = &["identify", "--robot", "robot.toml", "--data", "data.csv", "--out", "fit.json"];

/// `data.csv` with its rows, as lists of cells, changed.
fn cells(folder: &Folder, change: impl Fn(usize, &mut Vec<String>)) {
    let changed: Vec<String> = folder
        .read("data.csv")
        .lines()
        .enumerate()
        .map(|(line, text)| {
            let mut row: Vec<String> = text.split(',').map(str::to_string).collect();
            change(line + 1, &mut row);
            row.join(",")
        })
        .collect();
    folder.write("data.csv", &(changed.join("\n") + "\n"));
}

/// Puts a text into one cell of `data.csv`; lines and columns count from 1.
fn cell(folder: &Folder, line: usize, column: usize, text: &str) {
    cells(folder, |at, row| {
        if at == line {
            row[column - 1] = text.into();
        }
    });
}

/// `data.csv` with more cells at the end of every row.
fn more_columns(folder: &Folder, header: &str, value: impl Fn(usize) -> &'static str) {
    cells(folder, |line, row| row.push(if line == 1 { header.into() } else { value(line).into() }));
}

const CASES: &[Case] = &[
    Case {
        what: "unknown unit",
        spoil: |f| cell(f, 1, 4, "x[furlong]"),
        run: IDENTIFY,
        place: "data.csv:1: column `x[furlong]` (4): ",
    },
    Case {
        what: "a unit of something else",
        spoil: |f| cell(f, 1, 1, "j1[mm]"),
        run: IDENTIFY,
        place: "data.csv:1: column `j1[mm]` (1): ",
    },
    Case {
        what: "missing joint column",
        spoil: |f| cells(f, |_, row| drop(row.remove(1))),
        run: IDENTIFY,
        place: "data.csv:1: ",
    },
    Case {
        what: "text in a number",
        spoil: |f| cell(f, 7, 5, "12.5mm"),
        run: IDENTIFY,
        place: "data.csv:7: column `y[mm]` (5): ",
    },
    Case {
        what: "NaN",
        spoil: |f| cell(f, 3, 6, "NaN"),
        run: IDENTIFY,
        place: "data.csv:3: column `z[mm]` (6): ",
    },
    Case {
        what: "infinity",
        spoil: |f| cell(f, 9, 2, "-inf"),
        run: IDENTIFY,
        place: "data.csv:9: column `j2[deg]` (2): ",
    },
    Case {
        what: "a number too large for a float",
        spoil: |f| cell(f, 9, 2, "1e999"),
        run: IDENTIFY,
        place: "data.csv:9: column `j2[deg]` (2): ",
    },
    Case {
        what: "degrees under a [rad] header",
        spoil: |f| cell(f, 1, 1, "j1[rad]"),
        run: IDENTIFY,
        place: "data.csv:2: column `j1[rad]` (1): ",
    },
    Case {
        what: "millimetres under an [m] header",
        spoil: |f| cell(f, 1, 3, "d3[m]"),
        run: IDENTIFY,
        place: "data.csv:2: column `d3[m]` (3): ",
    },
    Case {
        what: "a row with too few cells",
        spoil: |f| {
            cells(f, |line, row| {
                if line == 5 {
                    row.truncate(4)
                }
            })
        },
        run: IDENTIFY,
        place: "data.csv:5: ",
    },
    Case {
        what: "the approach of a joint that the robot lacks",
        spoil: |f| more_columns(f, "approach_j4", |_| "1"),
        run: IDENTIFY,
        place: "data.csv:1: column `approach_j4` ",
    },
    Case {
        what: "a model with a joint that the robot lacks",
        spoil: |f| {
            f.write("model.toml", "[[effects]]\nfamily = \"joint_compliance\"\njoints = [\"j2\", \"j3\"]\n")
        },
        run: &[
            "identify",
            "--robot",
            "robot.toml",
            "--data",
            "data.csv",
            "--model",
            "model.toml",
            "--out",
            "fit.json",
        ],
        place: "model.toml:3:",
    },
    Case {
        what: "a target that is not declared",
        spoil: |f| cell(f, 4, 7, "T3"),
        run: IDENTIFY,
        place: "data.csv:4: column `target` (7): ",
    },
    Case {
        what: "a quaternion that is not of unit length",
        spoil: |f| {
            for (k, name) in ["qw", "qx", "qy", "qz"].into_iter().enumerate() {
                more_columns(f, name, |line| match (line, k) {
                    (6, 0) => "0.7",
                    (_, 0) => "1",
                    _ => "0",
                });
            }
        },
        run: IDENTIFY,
        place: "data.csv:6: column `qw` ",
    },
    Case {
        what: "a column that stands twice",
        spoil: |f| more_columns(f, "x[m]", |_| "1"),
        run: IDENTIFY,
        place: "data.csv:1: column `x[m]` ",
    },
    Case { what: "an empty file", spoil: |f| f.write("data.csv", ""), run: IDENTIFY, place: "data.csv: " },
    Case {
        what: "only a header",
        spoil: |f| f.write("data.csv", f.read("data.csv").lines().next().unwrap()),
        run: IDENTIFY,
        place: "data.csv: ",
    },
    Case {
        what: "nothing measured",
        spoil: |f| {
            cells(f, |line, row| {
                if line > 1 {
                    row[3..6].iter_mut().for_each(String::clear)
                }
            })
        },
        run: IDENTIFY,
        place: "data.csv: ",
    },
    Case {
        what: "no such file",
        spoil: |f| std::fs::remove_file(f.file("data.csv")).unwrap(),
        run: IDENTIFY,
        place: "data.csv: ",
    },
    Case {
        what: "a URDF with several leaves",
        spoil: |f| f.write("arm.urdf", URDF_WITH_TWO_LEAVES),
        run: &["identify", "--robot", "arm.urdf", "--data", "data.csv", "--out", "fit.json"],
        place: "arm.urdf:1:1: ",
    },
    Case {
        what: "a typing error in a robot",
        spoil: |f| f.write("robot.toml", &ROBOT.replacen("limits", "limit", 1)),
        run: IDENTIFY,
        place: "robot.toml:10:1: ",
    },
    Case {
        what: "a typing error in a model",
        spoil: |f| f.write("model.toml", "[[effects]]\nfamily = \"geometrc\"\n"),
        run: &[
            "identify",
            "--robot",
            "robot.toml",
            "--data",
            "data.csv",
            "--model",
            "model.toml",
            "--out",
            "fit.json",
        ],
        place: "model.toml:2:",
    },
    Case {
        what: "a text that is no TOML",
        spoil: |f| f.write("robot.toml", &ROBOT.replacen("limits = [-120, 120]", "limits = [-120, 120", 1)),
        run: IDENTIFY,
        place: "robot.toml:",
    },
    Case {
        what: "a fit from a newer format",
        spoil: |f| {
            f.run(&["identify", "--robot", "robot.toml", "--data", "data.csv", "--out", "old.json"]).ended(0);
            let version = concat!("truepose ", env!("CARGO_PKG_VERSION"));
            let text = f.read("old.json").replacen("\"format\": 1", "\"format\": 2", 1);
            f.write("newer.json", &text.replace(version, "truepose 99.1.0"));
        },
        run: &["predict", "--fit", "newer.json", "--data", "data.csv", "--out", "fit.json"],
        place: "newer.json",
    },
    Case {
        what: "a fit that is cut off",
        spoil: |f| {
            f.run(&["identify", "--robot", "robot.toml", "--data", "data.csv", "--out", "old.json"]).ended(0);
            let text = f.read("old.json");
            let end = text.find("\"format\": 1").unwrap() + 11;
            f.write("cut.json", &text[..end]);
        },
        run: &["predict", "--fit", "cut.json", "--data", "data.csv", "--out", "fit.json"],
        place: "cut.json:",
    },
    Case {
        what: "an output folder that does not exist",
        spoil: |_| (),
        run: &["identify", "--robot", "robot.toml", "--data", "data.csv", "--out", "results/fit.json"],
        place: "results/fit.json: ",
    },
    Case {
        what: "an output folder that is a file",
        spoil: |_| (),
        run: &["identify", "--robot", "robot.toml", "--data", "data.csv", "--out", "data.csv/fit.json"],
        place: "data.csv/fit.json: ",
    },
    Case {
        what: "an output file that is a folder",
        spoil: |f| std::fs::create_dir(f.file("results")).unwrap(),
        run: &["identify", "--robot", "robot.toml", "--data", "data.csv", "--out", "results"],
        place: "results: ",
    },
];

const URDF_WITH_TWO_LEAVES: &str = r#"<robot name="arm">
  <link name="base"/>
  <link name="upper"/>
  <link name="gripper"/>
  <link name="camera"/>
  <joint name="j1" type="revolute">
    <parent link="base"/><child link="upper"/><axis xyz="0 0 1"/>
    <limit lower="-1" upper="1" effort="1" velocity="1"/>
  </joint>
  <joint name="j2" type="fixed"><parent link="upper"/><child link="gripper"/></joint>
  <joint name="j3" type="fixed"><parent link="upper"/><child link="camera"/></joint>
</robot>
"#;

#[test]
fn every_kind_of_bad_input_is_refused_with_its_place() {
    let mut said = String::new();
    for case in CASES {
        let folder = Folder::with_data();
        folder.write("fit.json", "an older result");
        (case.spoil)(&folder);
        let before = folder.names();
        let run = folder.run(case.run).ended(2);
        let expected = format!("error: {}", case.place);
        let message = run.log.lines().rfind(|line| line.starts_with("error: ")).unwrap_or_default();
        assert!(
            message.starts_with(&expected),
            "{}: {:?} does not begin with {expected:?}",
            case.what,
            run.log
        );
        assert_eq!(run.out, "", "{}: a result was printed", case.what);
        assert_eq!(folder.names(), before, "{}: a file was left behind", case.what);
        assert_eq!(folder.read("fit.json"), "an older result", "{}", case.what);
        said += &format!("{}\n  {}\n\n", case.what, run.log.trim_end().replace('\n', "\n  "));
    }
    let mut settings = insta::Settings::clone_current();
    settings.add_filter(concat!(r"\btruepose ", env!("CARGO_PKG_VERSION"), r"\b"), "truepose [version]");
    settings.bind(|| insta::assert_snapshot!(said));
}

#[test]
fn fewer_rows_than_unknowns_is_answered_with_a_warning() {
    let folder = Folder::with_data();
    let few: Vec<String> = folder.read("data.csv").lines().take(9).map(str::to_string).collect();
    folder.write("data.csv", &(few.join("\n") + "\n"));
    let run = folder.run(IDENTIFY).ended(0);
    let warnings: Vec<&str> = run.out.lines().filter(|line| line.starts_with("warning: ")).collect();
    insta::assert_snapshot!(warnings.join("\n"));
    assert!(folder.names().contains(&"fit.json".to_string()));
}

#[test]
fn wrong_usage_is_refused() {
    let folder = Folder::with_data();
    let before = folder.names();
    let base = ["identify", "--robot", "robot.toml", "--data", "data.csv", "--out", "fit.json"];
    for (arguments, said) in [
        (&["--folds", "1"][..], "--folds: one fold leaves no data to fit"),
        (&["--solver", "magic"], "magic"),
        (&["--require", "0.15"], "a length needs a unit"),
        (&["--require=-1mm"], "a length above 0 is needed"),
        (
            &["--prior", "much"],
            "expected `evidence`, `none`, a number above 0, or a file of `truepose fleet`",
        ),
        (&["--holdout", "1.5"], "option `holdout` is 1.5"),
        (&["--threads", "0"], "0 is not in 1..=1024"),
        (&["--robot", "other.toml"], "--robot"),
        (&["--tip", "flange"], "tip"),
        (&["--unheard-of"], "--unheard-of"),
    ] {
        let run = folder.run(&[&base[..], arguments].concat()).ended(2);
        assert!(run.log.contains(said), "{arguments:?}: {}", run.log);
        assert_eq!(run.out, "");
        assert_eq!(folder.names(), before, "{arguments:?}");
    }
    folder.run(&[]).ended(2);
    folder.run(&["calibrate"]).ended(2);
}
