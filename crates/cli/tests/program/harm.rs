//! What comes out is never worse than what went in, and what nobody measured is said to be so.

use crate::folder::{Folder, ROBOT};

/// The small arm, whose first joint has moved little: over 20° the cosine of an eccentric wheel is a constant.
fn narrow() -> Folder {
    let folder = Folder::empty();
    folder.write("robot.toml", &ROBOT.replace("[-170, 170]", "[-10, 10]"));
    folder.write(
        "plant.toml",
        "robot = \"robot.toml\"\nseed = 5\n[errors.geometric]\nposition_mm = 0.4\nangle_mrad = 0.5\n\
         [[errors.transmission]]\njoint = \"j1\"\namplitude_mrad = 3.0\nphase_deg = 60\n\
         [instrument]\nsd_um = 20\n[campaign]\npostures = \"random\"\nvisits = 60\n",
    );
    folder.run("simulate --plant plant.toml --out data.csv").ended(0);
    folder
}

fn json(text: &str) -> serde_json::Value {
    serde_json::from_str(text).unwrap()
}

#[test]
fn an_export_is_as_good_as_constants_alone_and_better_than_nominal() {
    let folder = narrow();
    folder.write(
        "model.toml",
        "[[effects]]\nfamily = \"geometric\"\n[[effects]]\nfamily = \"transmission\"\njoint = \"j1\"\nharmonics = [1, 2]\n\
         [[effects]]\nfamily = \"transmission\"\njoint = \"j2\"\n",
    );
    let identify = "identify --robot robot.toml --data data.csv --out";
    folder.run(&format!("{identify} constants.json")).ended(0);
    folder.run(&format!("{identify} full.json --model model.toml")).ended(0);
    let rms = |fit: &str, format: &str| {
        let export = ["export", "--fit", fit, "--format", format, "--out", "o", "--json"];
        folder.run(&export).ended(0).json()["rms"].clone()
    };
    let constants = rms("constants.json", "urdf");
    for format in ["urdf", "dh", "mdh", "ros", "iso230"] {
        let full = rms("full.json", format);
        assert_eq!(
            (&full["measured"], &full["rows"], &full["drawn_from"]),
            (&true.into(), &120.into(), &120.into())
        );
        for figure in ["aligned_mm", "as_written_mm"] {
            let of = |rms: &serde_json::Value, robot: &str| rms[robot][figure].as_f64().unwrap();
            let (nominal, file, alone) =
                (of(&full, "nominal"), of(&full, "export"), of(&constants, "export"));
            assert!(file < 1.02 * alone && file < nominal, "{format} {figure}: {nominal} {alone} {file}");
        }
    }
    let said = folder.run("export --fit full.json --format urdf --out o").ended(0).out;
    assert!(
        said.contains("base and tool best for each: nominal ") && said.contains(" → full model "),
        "{said}"
    );
    assert!(folder.read("o").contains("as written: nominal "));
}

#[test]
fn a_file_that_is_worse_than_nominal_is_refused() {
    let folder = narrow();
    folder.run("identify --robot robot.toml --data data.csv --out fit.json").ended(0);
    // A coefficient that someone has spoiled by hand.
    let fit = folder.json("fit.json");
    let found =
        fit["coefficients"].as_array().unwrap().iter().find(|c| c["value"] != 0.0 && c["unit"] == "rad");
    let found = found.unwrap()["value"].to_string();
    folder.write("fit.json", &folder.read("fit.json").replace(&found, "0.5"));
    for format in ["urdf", "dh", "mdh", "ros", "iso230"] {
        let refused = folder.run(&["export", "--fit", "fit.json", "--format", format, "--out", "o"]).ended(2);
        assert!(
            refused.log.contains("the file would be worse than the nominal robot: RMS "),
            "{}",
            refused.log
        );
        assert!(!folder.file("o").exists());
    }
}

#[test]
fn extrapolation_is_reported() {
    let folder = narrow();
    folder.run("identify --robot robot.toml --data data.csv --out fit.json").ended(0);
    let head = folder.read("data.csv").lines().next().unwrap().to_string();
    assert!(head.contains("j1[") && head.contains("target"), "{head}");
    folder.write("far.csv", "j1[deg],j2[deg],d3[mm],target\n5,10,100,T1\n50,10,100,T1\n-30,10,100,T2\n");
    let predict = "predict --fit fit.json --data far.csv --out p.csv";
    let run = folder.run(predict).ended(0);
    assert!(
        run.log.contains("warning: 2 of 3 rows beyond the data of the fit")
            && run.log.contains("j1 in 2 (by up to 4"),
        "{}",
        run.log
    );
    let p = folder.read("p.csv");
    let flags: Vec<&str> = p.lines().map(|line| line.rsplit(',').next().unwrap()).collect();
    assert_eq!(flags, ["extrapolates", "0", "1", "1"]);
    // A fit of before says that it cannot tell, and a map says how much of it is not covered.
    let map = folder.run("map --fit fit.json --out m.csv --points 4").ended(0);
    assert!(map.out.contains("within the range of the data of the fit"), "{}", map.out);
    // Out of reach is no command.
    folder.write("poses.csv", "x[m],y[m],z[m],target\n9,9,9,T1\n");
    folder.run("compensate --fit fit.json --poses poses.csv --out q.csv").ended(0);
    let q = folder.read("q.csv");
    assert!(q.lines().nth(1).unwrap().starts_with(",,,limit,"), "{q}");
}

#[test]
fn a_target_that_nobody_measured_is_refused_or_remarked_upon() {
    let folder = narrow();
    let data = folder.read("data.csv");
    let seen: Vec<&str> = data.lines().filter(|line| !line.contains(",T2")).collect();
    assert!(seen.len() < data.lines().count());
    folder.write("seen.csv", &(seen.join("\n") + "\n"));
    let identify = "identify --robot robot.toml --data seen.csv --out fit.json";
    let predict = "predict --fit fit.json --data data.csv --out p.csv";
    folder.run(identify).ended(0);
    let run = folder.run(predict).ended(0);
    assert!(run.log.contains("warning: target `T2` was not measured in the data of the fit"), "{}", run.log);
    std::fs::remove_file(folder.file("p.csv")).unwrap();
    let robot = folder.read("robot.toml");
    folder.write("robot.toml", &robot.replace("xyz = [-20, 60, 0]", "known = false"));
    folder.run(identify).ended(0);
    let run = folder.run(predict).ended(2);
    assert!(
        run.log.contains("data.csv: line ") && run.log.contains("target `T2` was not measured"),
        "{}",
        run.log
    );
    assert!(!folder.file("p.csv").exists());
    let map = folder.run("map --fit fit.json --target T2 --out m.csv").ended(2);
    assert!(map.log.contains("--target: target `T2`"), "{}", map.log);
}

#[test]
fn orientations_are_not_compared_after_positions_alone() {
    let folder = narrow();
    let plant = folder.read("plant.toml");
    folder.write("plant.toml", &plant.replace("sd_um = 20\n", "sd_um = 20\norientation_urad = 40\n"));
    folder.run("simulate --plant plant.toml --out data.csv").ended(0);
    let identify = "identify --robot robot.toml --data data.csv --out fit.json";
    let predict = "predict --fit fit.json --data data.csv --out p.csv";
    folder.run(identify).ended(0);
    assert!(folder.run(predict).ended(0).out.contains("against the measured orientations: RMS "));
    folder.run(&format!("{identify} --positions-only")).ended(0);
    let run = folder.run(predict).ended(0);
    assert!(
        !run.out.contains("orientations") && run.log.contains("orientations are not compared"),
        "{} {}",
        run.out,
        run.log
    );
}

/// Twenty rows of a campaign in inches under a header in mm: that is the finding, it stands first, and nothing else is made of it.
#[test]
fn rows_in_another_unit_are_named_first_and_left_out() {
    let folder = Folder::empty();
    folder.write("robot.toml", ROBOT);
    folder.write(
        "plant.toml",
        "robot = \"robot.toml\"\nseed = 5\n[errors.geometric]\nposition_mm = 0.4\nangle_mrad = 0.5\n\
         [instrument]\nsd_um = 20\n[campaign]\npostures = \"random\"\nvisits = 60\n",
    );
    folder.run("simulate --plant plant.toml --out data.csv").ended(0);
    let table = folder.read("data.csv");
    let header: Vec<&str> = table.lines().next().unwrap().split(',').collect();
    let places: Vec<usize> =
        ["x[mm]", "y[mm]", "z[mm]"].map(|name| header.iter().position(|h| *h == name).unwrap()).to_vec();
    let spoilt = |(line, text): (usize, &str)| {
        let cells = text.split(',').enumerate().map(|(k, cell)| match places.contains(&k) {
            true if (30..50).contains(&line) => (cell.parse::<f64>().unwrap() / 25.4).to_string(),
            _ => cell.to_owned(),
        });
        cells.collect::<Vec<_>>().join(",") + "\n"
    };
    folder.write("mixed.csv", &table.lines().enumerate().map(spoilt).collect::<String>());
    let words = "Check the data first: mixed.csv: in rows 30 to 49 (lines 31 to 50), up to ";
    for verb in ["identify", "discover"] {
        let run = |more: &[&str]| {
            folder.run(&[&[verb, "--robot", "robot.toml", "--data", "mixed.csv"], more].concat()).ended(0).out
        };
        let out = run(&["--report", "page"]);
        let (before, after) = out.split_once(words).unwrap_or_else(|| panic!("{out}"));
        assert!(before.lines().filter(|line| !line.is_empty()).count() == 1, "{out}");
        assert!(
            after.contains("positions seem to be inches taken for millimetres: after scaling them"),
            "{out}"
        );
        assert!(after.contains("20 rows are left out of all that follows."), "{out}");
        assert!(folder.read("page/index.html").contains(words), "{verb}");
        let found = json(&run(&["--json"]));
        let left_out: Vec<u64> = (30..50).collect();
        assert_eq!(found["data_check"]["rows_left_out"], serde_json::json!(left_out));
        assert_eq!(found["data_check"]["in_doubt"], false);
        assert_eq!(found["rows"], 100);
    }
}

/// Rows with x alone, as of an interferometer: there is no 3-D error, and a gate does not pass on it.
#[test]
fn rows_of_one_component_are_judged_by_it() {
    let folder = narrow();
    let table = folder.read("data.csv");
    let header: Vec<&str> = table.lines().next().unwrap().split(',').collect();
    let open: Vec<usize> =
        ["y[mm]", "z[mm]"].map(|name| header.iter().position(|h| *h == name).unwrap()).to_vec();
    let without = |(line, text): (usize, &str)| {
        let cells = text.split(',').enumerate().map(|(k, cell)| match line > 0 && open.contains(&k) {
            true => "",
            false => cell,
        });
        cells.collect::<Vec<_>>().join(",") + "\n"
    };
    folder.write("x.csv", &table.lines().enumerate().map(without).collect::<String>());
    let run = |gate: &[&str], code: i32| {
        let identify = ["identify", "--robot", "robot.toml", "--data", "x.csv"];
        folder.run(&[&identify[..], gate].concat()).ended(code)
    };
    let words = "Position error (RMS over the measured components) on held-out configurations";
    let out = run(&[], 0).out;
    assert!(out.contains(words) && out.contains("x alone in ") && !out.contains("axis y"), "{out}");
    let found = run(&["--json"], 0).json();
    let declared = &found["stages"].as_array().unwrap().last().unwrap()["train"];
    let rms = declared["rms_mm"].as_f64().unwrap();
    assert!(rms > 0.001 && declared["count"] == found["rows"], "{declared}");
    assert!((rms - found["axes"][0]["rms_mm"].as_f64().unwrap()).abs() < 1e-12, "{declared}");
    assert_eq!(found["partial_rows"]["rows"], serde_json::json!([["x", found["rows"]]]));
    assert!(run(&["--require", "0.001mm"], 1).log.contains("is above the required"));
    run(&["--spec", "0.001mm"], 1);
    run(&["--require", "100mm", "--spec", "100mm"], 0);
}

/// An exact arm and too few poses for its model without a prior: unseen poses are predicted much worse than by base and tool alone.
#[test]
fn a_contradicted_fit_is_refused_until_it_is_accepted() {
    let folder = Folder::empty();
    folder.write("robot.toml", ROBOT);
    let simulated = |visits: usize| {
        folder.write(
            "plant.toml",
            &format!(
                "robot = \"robot.toml\"\nseed = 5\n[instrument]\nsd_um = 20\n[campaign]\npostures = \"random\"\nvisits = {visits}\n"
            ),
        );
        folder.run("simulate --plant plant.toml --out data.csv").ended(0);
        let identify = "identify --robot robot.toml --data data.csv --prior none --out fit.json";
        folder.run(identify).ended(0);
        folder.json("fit.json")["provenance"]["verdict"]["contradicted"].clone()
    };
    let predict = "predict --fit fit.json --data data.csv --out p.csv";
    assert_eq!(simulated(60), false);
    folder.run(predict).ended(0);
    assert_eq!(simulated(5), true);
    let refused = folder.run(predict).ended(2).log;
    assert!(refused.contains("it predicts unseen poses worse than base and tool alone"), "{refused}");
    folder.run(&format!("{predict} --accept")).ended(0);
}

/// A heavy arm that stands upright, seen by cameras whose frame has y upwards; its description does not state where gravity points.
#[test]
fn gravity_that_is_not_declared_is_found_and_named() {
    let example = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../examples/01_identify");
    let read = |name: &str| std::fs::read_to_string(example.join(name)).unwrap();
    let folder = Folder::empty();
    let robot = read("robot.toml");
    let (standing, unknown) = ("rpy = [0.0, 0.0, 35.0]", "xyz = [1600.0, 250.0, 420.0]\n");
    assert!(robot.contains(standing) && robot.contains(unknown));
    folder.write("robot.toml", &robot.replace(unknown, "").replacen(standing, "known = false", 1));
    let frames = [("base", "measurement"), ("measurement", "base")];
    for &(frame, other) in if cfg!(feature = "slow") { &frames[..] } else { &frames[..1] } {
        let turned = robot.replacen(standing, "rpy = [90.0, 0.0, 35.0]", 1);
        let declared = format!("gravity_frame = \"{frame}\"\n");
        folder.write("true.toml", &(declared.clone() + &turned));
        folder.write("plant.toml", &read("plant.toml").replace("\"robot.toml\"", "\"true.toml\""));
        folder.run("simulate --plant plant.toml --out data.csv").ended(0);
        let model = example.join("model.toml").display().to_string();
        let run = |robot: &str| {
            let words = ["identify", "--robot", robot, "--data", "data.csv", "--model", &model, "--json"];
            folder.run(&[&words[..], &["--out", "fit.json"]].concat()).ended(0).json()
        };
        let rms = |found: &serde_json::Value| {
            found["stages"].as_array().unwrap().last().unwrap()["held_out"]["rms_mm"].as_f64().unwrap()
        };
        let found = run("robot.toml");
        let words = found["data_check"]["suspected"][0].as_str().unwrap();
        assert!(words.contains(&format!("that of the {frame}")) && words.contains("is used, which explains"));
        assert!(!words.contains(&format!("declare `gravity_frame = \"{other}\"`")), "{words}");
        assert_eq!(folder.json("fit.json")["robot"]["gravity"]["frame"], frame);
        folder.write("declared.toml", &(declared + &folder.read("robot.toml")));
        let right = run("declared.toml");
        assert!(right["data_check"].is_null() && (rms(&right) - rms(&found)).abs() < 1e-9);
    }
}

/// A positioner, whose two axes meet, with base and tool of unknown place: at the size of a thousandth it would fit as well.
#[test]
fn two_axes_that_meet_are_no_mistake_of_a_unit() {
    let folder = Folder::empty();
    let joints = "name = \"positioner\"\n[[joints]]\nname = \"j1\"\nlimits = [-0.6, 0.6]\ndh = { theta = 0, d = 0, a = 0, alpha = -1.5707963 }\n\
                  [[joints]]\nname = \"j2\"\nlimits = [0, 5.9]\ndh = { theta = -1.5707963, d = -0.52, a = 0, alpha = 0 }\n";
    folder.write("robot.toml", &format!("{joints}[base]\nknown = false\n[tool]\nknown = false\n"));
    let placed = "[base]\nxyz = [0.1, -0.4, 0.6]\nrpy = [0.02, 0.01, 1.2]\n[tool]\nxyz = [0.4, 0.1, 0.25]\n";
    folder.write("true.toml", &format!("{joints}{placed}"));
    folder.write(
        "plant.toml",
        "robot = \"true.toml\"\nseed = 4\n[errors.geometric]\nposition_mm = 0.1\n[instrument]\nsd_um = 200\n\
         [campaign]\npostures = \"random\"\nvisits = 50\n",
    );
    folder.run("simulate --plant plant.toml --out data.csv").ended(0);
    for verb in ["check", "identify"] {
        let run = folder.run(&[verb, "--robot", "robot.toml", "--data", "data.csv"]).ended(0);
        assert!(!(run.out + &run.log).contains("seem"), "{verb}");
    }
}

/// A target of unknown place in two rows alone: no other row determines it.
#[test]
fn rows_that_alone_determine_a_point_are_not_suspected() {
    let folder = Folder::empty();
    let third =
        |xyz: &str, known: bool| format!("\n[[targets]]\nname = \"T3\"\nxyz = {xyz}\nknown = {known}\n");
    folder.write("robot.toml", &(ROBOT.to_owned() + &third("[0, 0, 0]", false)));
    folder.write("true.toml", &(ROBOT.to_owned() + &third("[310, -180, 120]", true)));
    folder.write(
        "plant.toml",
        "robot = \"true.toml\"\nseed = 4\n[errors.geometric]\nposition_mm = 0.3\nangle_mrad = 0.5\n[instrument]\nsd_um = 20\n\
         [campaign]\npostures = \"random\"\nvisits = 40\n",
    );
    folder.run("simulate --plant plant.toml --out data.csv").ended(0);
    let mut seen = 0;
    let table = folder.read("data.csv");
    let kept = table.lines().filter(|line| {
        seen += usize::from(line.contains(",T3,"));
        !line.contains(",T3,") || seen <= 2
    });
    let kept: Vec<String> = kept.map(str::to_owned).collect();
    folder.write("data.csv", &(kept.join("\n") + "\n"));
    let run = folder.run("check --robot robot.toml --data data.csv").ended(0);
    assert!(!run.log.contains("warning"), "{}", run.log);
}
