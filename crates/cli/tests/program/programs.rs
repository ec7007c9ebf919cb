//! A robot program in, the compensated program and the table of its corrections out.

use crate::folder::Folder;

/// With the fit of the example's heavy arm, and programs for it.
fn fitted() -> Folder {
    let folder = Folder::with_heavy_fit();
    // CR LF, and an umlaut of Windows' code page in a comment.
    std::fs::write(
        folder.file("job.src"),
        b"&ACCESS RVP\r\nDEF job( )\r\n;Greifer \xf6ffnen {X 1,Y 2}\r\nPTP XP1\r\nPTP  XP2\r\nEND\r\n",
    )
    .unwrap();
    folder.write(
        "job.dat",
        "DEFDAT job\r\nDECL E6AXIS XP1={A1 50.668,A2 -106.651,A3 81.014,A4 -25.176,A5 -53.698,A6 72.074,E1 0.0}\r\n\
         DECL E6AXIS XP2={A1 48.0,A2 -100.0,A3 85.0,A4 -20.0,A5 -60.0,A6  70.000}\r\n\
         DECL E6AXIS XHOME={A1 0,A2 -90,A3 90,A4 0,A5 0,A6 0}\r\nENDDAT\r\n",
    );
    folder
}

const ARGUMENTS: [&str; 9] =
    ["compensate", "--fit", "fit.json", "--program", "job.dat", "--with", "job.src", "--out", "new.dat"];

#[test]
fn points_are_replaced_or_the_program_is_refused() {
    let folder = fitted();
    // The home position is stretched out in the wrist: it stays.
    let run = folder.run(&[&ARGUMENTS[..], &["--report", "page"]].concat()).ended(0);
    assert!(run.out.contains("3 points: 2 corrected, 1 unchanged at a wrist singularity"), "{}", run.out);
    assert!(run.out.contains("unchanged: job.dat, line 4: XHOME: it is near a singularity"), "{}", run.out);
    let (old, new) = (folder.read("job.dat"), folder.read("new.dat"));
    let same = |k: usize| old.lines().nth(k) == new.lines().nth(k);
    assert_eq!([0, 1, 2, 3, 4].map(same), [true, false, false, true, true]);
    assert!(new.contains(",E1 0.0}\r\n") && new.contains("A6 70.0"), "{new}");
    let table = folder.read("new.dat.corrections.csv");
    assert_eq!(table.lines().count(), 4);
    assert!(table.lines().nth(1).unwrap().starts_with("XP1,2,joints,,,corrected,,"), "{table}");
    let page = folder.read("page/index.html");
    assert!(
        page.contains("XHOME")
            && page.contains("Changed lines")
            && page.contains("2 changed lines: − as it was read"),
        "{page}"
    );
    assert!(
        page.contains("<del>− DECL E6AXIS XP1={A1 50.668,")
            && page.contains("<ins>+ DECL E6AXIS XP1={A1 50.")
    );
    let json: serde_json::Value = serde_json::from_str(&folder.read("page/compensation.json")).unwrap();
    assert_eq!(json["points"][0]["outcome"], "corrected");
    assert_eq!(json["changed"][1]["line"], 3);
    let size = json["points"][0]["correction_mm"].as_f64().unwrap();
    assert!((0.05..5.0).contains(&size), "{size}");

    // Nothing that is corrected, no program.
    std::fs::remove_file(folder.file("new.dat")).unwrap();
    std::fs::remove_file(folder.file("new.dat.corrections.csv")).unwrap();
    for more in [&["--limit", "0.001"][..], &["--mark", "--limit", "0.001"]] {
        let run = folder.run(&[&ARGUMENTS[..], more].concat()).ended(2);
        assert!(run.log.contains("above the limit of 0.001 mm"), "{}", run.log);
        assert!(run.log.contains("nothing is written: 2 of 3 points cannot be compensated"), "{}", run.log);
        assert!(!folder.file("new.dat").exists() && !folder.file("new.dat.corrections.csv").exists());
    }
}

#[test]
fn points_of_further_files_are_compensated_too() {
    let folder = fitted();
    folder.run(&[&ARGUMENTS[..], &["--mark"]].concat()).ended(0);
    let first = folder.read("new.dat");
    std::fs::remove_file(folder.file("new.dat")).unwrap();
    let as_documented =
        ["compensate", "--fit", "fit.json", "--program", "job.src", "--with", "job.dat", "--out", "out.src"];
    let run = folder.run(&as_documented).ended(0);
    assert!(run.out.contains("2 points: 2 corrected"), "{}", run.out);
    assert!(run.out.contains("out.dat of job.dat: 2 points: 2 corrected"), "{}", run.out);
    // No motion goes to the home position: it is another program's.
    assert!(run.log.contains("job.dat: 1 point stays unchanged, as no motion"), "{}", run.log);
    assert_eq!(folder.read("out.dat"), first);
    let same =
        |a: &str, b: &str| std::fs::read(folder.file(a)).unwrap() == std::fs::read(folder.file(b)).unwrap();
    assert!(same("out.src", "job.src"));
    assert_eq!(folder.read("out.src.corrections.csv").lines().count(), 1);
    assert_eq!(folder.read("out.dat.corrections.csv").lines().count(), 3);
    let json = folder.run(&[&as_documented[..], &["--json"]].concat()).ended(0).out;
    let json: serde_json::Value = serde_json::from_str(&json).unwrap();
    assert_eq!(json["points"][1]["file"], "job.dat");

    // A point in each of two files.
    folder.write("two.src", "DEF two()\nPTP {A1 48,A2 -100,A3 85,A4 -20,A5 -60,A6 70}\nPTP XP1\nEND\n");
    let words = "compensate --fit fit.json --program two.src --with job.dat --out new/two.src";
    std::fs::create_dir(folder.file("new")).unwrap();
    let run = folder.run(&words.split(' ').collect::<Vec<_>>()).ended(0);
    assert!(run.out.contains("2 points: 2 corrected") && folder.file("new/job.dat").exists(), "{}", run.out);
    assert!(!same("new/two.src", "two.src"));

    // Inputs are not written over.
    let before = folder.read("job.dat");
    let words = "compensate --fit fit.json --program two.src --with job.dat --out new.src";
    let run = folder.run(&words.split(' ').collect::<Vec<_>>()).ended(2);
    assert!(
        run.log.contains("`job.dat`, to which they would be written, is what --with reads"),
        "{}",
        run.log
    );
    assert!(run.log.contains("--out NEW/new.src") && !folder.file("new.src").exists(), "{}", run.log);
    assert_eq!(folder.read("job.dat"), before);
}

#[test]
fn a_point_without_a_value_is_no_success() {
    let folder = fitted();
    let run = |more: &str| {
        let words = format!("compensate --fit fit.json --program job.src --out new.src{more}");
        folder.run(&words.split(' ').collect::<Vec<_>>())
    };
    let log = run("").ended(2).log;
    assert!(log.contains("job.src:4: PTP XP1: XP1 has no value in the files given; add the file"), "{log}");
    assert!(log.contains("--leave XP1") && log.contains("2 of 2 points cannot be compensated"), "{log}");
    assert!(!folder.file("new.src").exists());
    // Nothing at all is compensated: no success, whatever is stated.
    for more in [" --mark", " --leave XP1 --leave XP2"] {
        let log = run(more).ended(2).log;
        assert!(
            log.contains("job.src: nothing to compensate: no point has a value in the files given"),
            "{log}"
        );
    }
    assert!(run(" --leave XP9").ended(2).log.contains("--leave: no point of the program is called `XP9`"));

    std::fs::create_dir(folder.file("half")).unwrap();
    folder.write(
        "half/job.dat",
        "DEFDAT job\nDECL E6AXIS XP1={A1 48,A2 -100,A3 85,A4 -20,A5 -60,A6 70}\nENDDAT\n",
    );
    let log = run(" --with half/job.dat").ended(2).log;
    assert!(log.contains("XP2 has no value in the files given") && !log.contains("XP1"), "{log}");
    let log = run(" --with half/job.dat --leave xp2").ended(0).log;
    assert!(
        log.contains("job.src:5: PTP XP2: XP2 has no value in the files given: it stays as it is"),
        "{log}"
    );
    let marked = run(" --with half/job.dat --mark").ended(0).out;
    assert!(marked.contains("unchanged: line 5: PTP XP2: XP2 has no value"), "{marked}");
    // Of a point with a value, too.
    let left = run(" --with half/job.dat --leave XP2 --leave XP1").ended(0).out;
    assert!(left.contains("1 point: 1 refused"), "{left}");
    assert_eq!(folder.read("half/job.dat"), folder.read("new.dat"));
}

#[test]
fn a_dry_run_writes_the_same_bytes_and_the_table() {
    let folder = fitted();
    for (file, points) in [("job.dat", 3), ("job.src", 0)] {
        let run = folder
            .run(&[
                "compensate",
                "--fit",
                "fit.json",
                "--program",
                file,
                "--dry-run",
                "--out",
                "same",
                "--json",
            ])
            .ended(0);
        assert_eq!(std::fs::read(folder.file(file)).unwrap(), std::fs::read(folder.file("same")).unwrap());
        let json: serde_json::Value = serde_json::from_str(&run.out).unwrap();
        assert_eq!(json["points"].as_array().unwrap().len(), points);
        assert_eq!(folder.read("same.corrections.csv").lines().count(), 1 + points);
    }
}

#[test]
fn what_is_not_known_is_an_error_that_names_the_option() {
    let folder = fitted();
    let pose = "LIN {X 1600,Y 200,Z 900,A 10,B 85,C 20,S 2,T 2}\n";
    folder.write("open.src", &format!("DEF a()\nBAS(#BASE,1)\nBAS(#TOOL,2)\n{pose}END\n"));
    let run = |more: &[&str]| {
        let first = ["compensate", "--fit", "fit.json", "--program", "open.src", "--out", "new.src"];
        folder.run(&[&first, more].concat()).ended(2).log
    };
    assert!(run(&[]).contains(
        "open.src:4: LIN in line 4: its frame BASE_DATA[1] has no value in the files given (--frame"
    ));
    let base = "BASE_DATA[1]=0mm,0mm,0mm,0,0,0";
    assert!(run(&["--frame", base]).contains("its tool TOOL_DATA[2] has no value"));
    assert!(
        run(&["--frame", "UF7=0mm,0mm,0mm,0,0,0"]).contains("no point of the program uses the frame `UF7`")
    );
    assert!(run(&["--frame", base, "--frame", base]).contains("given twice"));
    assert!(run(&["--frame", "nowhere"]).contains("there is no frame `nowhere`"));
    assert!(run(&["--start", "1,2"]).contains("--start: 2 values for 6 joints"));
    assert!(run(&["--language", "basic"]).contains("unknown language"));
    // With a frame and a tool the configuration is what is left: this pose has none with these turns.
    let all = run(&["--frame", base, "--tool-frame", "flange"]);
    assert!(all.contains("in the configuration that it states"), "{all}");
    for (name, words) in [("a.urp", ".script"), ("a.tp", ".ls"), ("a.txt", "--language")] {
        folder.write(name, "x");
        let log =
            folder.run(&["compensate", "--fit", "fit.json", "--program", name, "--out", "o"]).ended(2).log;
        assert!(log.contains(words), "{log}");
    }
    folder.write("bad.src", "LIN {X 1,\n");
    let log =
        folder.run(&["compensate", "--fit", "fit.json", "--program", "bad.src", "--out", "o"]).ended(2).log;
    assert!(log.contains("bad.src:1:5: an aggregate is not closed in its line"), "{log}");
    let log = folder
        .run(&["compensate", "--fit", "fit.json", "--program", "job.dat", "--out", "job.dat"])
        .ended(2)
        .log;
    assert!(log.contains("would be overwritten"), "{log}");
}

#[test]
fn a_kinematics_file_goes_out_and_comes_back() {
    let folder = Folder::empty();
    let row = |key: &str, n: [f64; 6]| {
        let parts: Vec<String> = ["x", "y", "z", "roll", "pitch", "yaw"]
            .iter()
            .zip(n)
            .map(|(p, v)| format!("    {p}: {v}\n"))
            .collect();
        format!("  {key}:\n{}", parts.concat())
    };
    let quarter = std::f64::consts::FRAC_PI_2;
    let maker: String = [
        row("shoulder", [0.0, 0.0, 0.1625, 0.0, 0.0, 0.0]),
        row("upper_arm", [0.0, 0.0, 0.0, quarter, 0.0, 0.0]),
        row("forearm", [-0.425, 0.0, 0.0, 0.0, 0.0, 0.0]),
        row("wrist_1", [-0.3922, 0.0, 0.1333, 0.0, 0.0, 0.0]),
        row("wrist_2", [0.0, -0.0997, 0.0, quarter, 0.0, 0.0]),
        row("wrist_3", [0.0, 0.0996, 0.0, quarter, 2.0 * quarter, 2.0 * quarter]),
    ]
    .concat();
    folder.write("default.yaml", &format!("kinematics:\n{maker}  hash: calib_12788084448423163542\n"));
    folder.write("robot.toml", "name = \"mine\"\nkinematics = \"default.yaml\"\n");
    folder.write(
        "plant.toml",
        "robot = \"robot.toml\"\nseed = 3\n[errors.geometric]\nposition_mm = 0.3\nangle_mrad = 0.3\n[instrument]\nsd_um = 10\n\
         orientation_urad = 20\n[campaign]\npostures = \"random\"\nvisits = 80\n",
    );
    folder.run(&["simulate", "--plant", "plant.toml", "--out", "data.csv"]).ended(0);
    folder.run(&["identify", "--robot", "robot.toml", "--data", "data.csv", "--out", "fit.json"]).ended(0);
    let export = ["export", "--fit", "fit.json", "--format", "ros-yaml", "--out", "mine.yaml"];
    let run = |more: &[&str], code: i32| folder.run(&[&export, more].concat()).ended(code);
    run(&["--style", "ur"], 0);
    let text = folder.read("mine.yaml");
    assert!(!text.contains("calib_") && text.contains("hash: truepose_"), "{text}");
    run(&["--style", "ur", "--hash", "calib_12788084448423163542", "--like", "default.yaml"], 0);
    assert!(folder.read("mine.yaml").contains("\n  hash: calib_12788084448423163542\n"));
    // The file is a robot: the errors are in it.
    folder.run(&["identify", "--robot", "mine.yaml", "--data", "data.csv", "--out", "again.json"]).ended(0);
    assert!(run(&["--style", "franka"], 2).log.contains("has not the joints of the style franka"));
    assert!(run(&[], 2).log.contains("--style"));
    assert!(run(&["--style", "ur", "--hash", "x y"], 2).log.contains("calib_"));
    assert!(run(&["--style", "xarm", "--hash", "calib_1"], 2).log.contains("--style ur"));
    let other =
        folder.run(&["export", "--fit", "fit.json", "--format", "ros", "--style", "ur", "--out", "o"]);
    assert!(other.ended(2).log.contains("--style: only `--format ros-yaml`"));
}

#[test]
fn corrections_as_offsets_of_a_frame() {
    let folder = fitted();
    let places = [[620, 940, 2530], [660, 900, 2500], [580, 960, 2480], [600, 920, 2560]];
    let lines: String = places
        .iter()
        .map(|[x, y, z]| format!("LIN {{X {x},Y {y},Z {z},A -70.8,B -24.0,C -0.6}}\n"))
        .collect();
    let text = format!(
        "DEF job()\n$BASE=BASE_DATA[1]\n$TOOL=TOOL_DATA[1]\nPTP {{A1 50.668,A2 -106.651,A3 81.014,A4 -25.176,A5 -53.698,A6 72.074}}\n{lines}END\n"
    );
    folder.write("frames.src", &text);
    let frames =
        ["--frame", "BASE_DATA[1]=0mm,0mm,0mm,0,0,0.5", "--tool-frame", "TOOL_DATA[1]=40mm,0mm,230mm,0,0,0"];
    let own =
        ["compensate", "--fit", "fit.json", "--program", "frames.src", "--offsets", "--out", "offsets.csv"];
    let run = folder.run(&[&own[..], &frames].concat()).ended(0);
    assert!(run.out.starts_with("frame BASE_DATA[1]: 4 points: "), "{}", run.out);
    assert!(
        run.log.contains("points in joint values have no frame: no offset corrects them (1)"),
        "{}",
        run.log
    );
    let table = folder.read("offsets.csv");
    assert!(
        table.starts_with("name,kind,X,Y,Z,A,B,C,points,rms_before[m],rms_after[m]\nBASE_DATA[1],frame,"),
        "{table}"
    );
    let points = folder.read("offsets.csv.points.csv");
    assert!(
        points.lines().count() == 5 && points.contains("frames.src,LIN in line 5,5,BASE_DATA[1],"),
        "{points}"
    );
    // The same points in two programs of a folder: one value, of both.
    std::fs::create_dir(folder.file("b")).unwrap();
    let halves = [(&lines[..lines.len() / 2], "one"), (&lines[lines.len() / 2..], "two")];
    for (lines, name) in halves {
        let head = text.split("LIN").next().unwrap().replace("job()", &format!("{name}()"));
        folder.write(&format!("b/{name}.src"), &format!("{head}{lines}END\n"));
    }
    let words = "compensate --fit fit.json --program b --offsets --out all.csv --report page";
    let run = folder.run(&[&words.split(' ').collect::<Vec<_>>()[..], &frames].concat()).ended(0);
    assert!(run.out.starts_with("frame BASE_DATA[1]: 4 points: "), "{} {}", run.out, run.log);
    let (one, all) = (folder.read("offsets.csv"), folder.read("all.csv"));
    let numbers = |table: &str| -> Vec<f64> {
        table.lines().nth(1).unwrap().split(',').skip(2).map(|cell| cell.parse().unwrap()).collect()
    };
    assert!(numbers(&one).iter().zip(numbers(&all)).all(|(a, b)| (a - b).abs() < 1e-6), "{one} {all}");
    let points = folder.read("all.csv.points.csv");
    assert!(
        points.contains("one.src,LIN in line 5,5,") && points.contains("two.src,LIN in line 6,6,"),
        "{points}"
    );
    assert!(folder.read("page/index.html").contains("No program was written."));
    assert!(!folder.file("all.csv").is_dir() && !folder.file("new").exists());
}

#[test]
fn pulses_of_a_job_are_held_against_the_controllers_parameters() {
    let folder = fitted();
    folder.write(
        "job.jbi",
        "/JOB\n//NAME JOB\n//POS\n///NPOS 1,0,0,0,0,0\n///TOOL 0\n///POSTYPE PULSE\n///PULSE\nC00000=81300,-106651,81014,-25176,-53698,72074\n\
         //INST\n///DATE 2020/01/01 10:00\nNOP\nMOVJ C00000 VJ=0.78\nEND\n",
    );
    // 4096 · n/(360 · d): 1604.267 of the first axis, 1000 of the others.
    let line = |k: usize| match k {
        109 => "1,512,512,512,512,512,1,1\n",
        110 => "141,45000,45000,45000,45000,45000,1,1\n",
        _ => "0,0,0,0,0,0,0,0\n",
    };
    folder.write("RC.PRM", &format!("//RC\n///RC1G\n{}", (0..220).map(line).collect::<String>()));
    let run = |more: &str, status| {
        let words = format!("compensate --fit fit.json --program job.jbi --with RC.PRM --out new.jbi{more}");
        folder.run(&words.split(' ').collect::<Vec<_>>()).ended(status)
    };
    let log = run("", 2).log;
    assert!(
        log.contains("by the controller's parameters 1604.267,1000.000,") && log.contains("--pulses"),
        "{log}"
    );
    let log = run(" --pulses 1604.267,1000,-1000,1000,1000,900", 2).log;
    assert!(log.contains("axis 6 has 900.000 pulses per degree as stated, 1000.000 by"), "{log}");
    let run = run(" --pulses 1604.267,1000,1000,1000,1000,1000", 0);
    assert!(run.out.contains("1 point: 1 corrected"), "{} {}", run.out, run.log);
}
