//! `iso9283` and `plan --for iso9283`: the plan is read, filled in, assessed, and printed.

use crate::folder::Folder;
use crate::page::{axe, browser, chromium};
use serde_json::Value;

/// A robot of the library, with base and tool as described.
fn robot() -> String {
    include_str!("../../../workflow/robots/ur10e.toml").replace("known = false", "known = true")
}

/// A plan of five poses in 30 cycles, with measured positions that are off by `offset` (base frame, m) and a scatter.
fn measured(folder: &Folder) -> Vec<[f64; 4]> {
    folder.write("robot.toml", &robot());
    let plan = ["plan", "--for", "iso9283", "--robot", "robot.toml", "--out", "plan.csv", "--loads", "10"];
    folder.run(&plan).ended(0);
    let text = folder.read("plan.csv");
    let mut lines = text.lines();
    let head: Vec<&str> = lines.next().unwrap().split(',').collect();
    let at = |name: &str| head.iter().position(|cell| *cell == name).unwrap();
    let (mut out, mut deviations) = (head.join(",") + ",speed[%],time[s]\n", Vec::new());
    let mut state = 5u64;
    let mut draw = || {
        state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (state >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    };
    for (n, line) in lines.enumerate() {
        let mut cells: Vec<String> = line.split(',').map(String::from).collect();
        let pose: f64 = cells[at("pose[1]")].parse().unwrap();
        let mut deviation = [pose, 0.0, 0.0, 0.0];
        for (k, (axis, offset)) in [("x", 1e-4), ("y", -2e-4), ("z", 3e-4)].into_iter().enumerate() {
            let command: f64 = cells[at(&format!("command_{axis}[m]"))].parse().unwrap();
            let by = offset * pose + 2e-5 * draw();
            let place = command + by;
            deviation[k + 1] = place - command;
            cells[at(&format!("{axis}[m]"))] = format!("{place:?}");
        }
        deviations.push(deviation);
        out += &format!("{},100,{}\n", cells.join(","), 10 * n);
    }
    folder.write("data.csv", &out);
    deviations
}

fn figure(json: &Value, pose: usize, symbol: &str) -> f64 {
    let figures = json["before"]["poses"][pose]["figures"].as_array().unwrap();
    figures.iter().find(|figure| figure["symbol"] == symbol).unwrap()["value"].as_f64().unwrap()
}

#[test]
fn a_plan_is_read_filled_in_and_assessed() {
    let folder = Folder::empty();
    let deviations = measured(&folder);
    assert_eq!(deviations.len(), 150);
    let check = folder.run("check --robot robot.toml --data plan.csv").ended(0);
    assert!(check.out.contains("150 pose measurements, 5 configurations"), "{}", check.out);
    let run = ["iso9283", "--robot", "robot.toml", "--data", "data.csv", "--instrument", "5um"];
    let json = folder.run(&[&run[..], &["--json"]].concat()).ended(0).json();
    for pose in 0..5 {
        let own: Vec<&[f64; 4]> = deviations.iter().filter(|d| d[0] as usize == pose + 1).collect();
        let mean = |k: usize| own.iter().map(|d| 1e3 * d[k]).sum::<f64>() / own.len() as f64;
        let ap = (mean(1).powi(2) + mean(2).powi(2) + mean(3).powi(2)).sqrt();
        assert!((figure(&json, pose, "AP_p") - ap).abs() < 1e-9, "P{}", pose + 1);
        let l: Vec<f64> =
            own.iter().map(|d| (1..4).map(|k| (1e3 * d[k] - mean(k)).powi(2)).sum::<f64>().sqrt()).collect();
        let middle = l.iter().sum::<f64>() / 30.0;
        let sd = (l.iter().map(|v| (v - middle).powi(2)).sum::<f64>() / 29.0).sqrt();
        assert!((figure(&json, pose, "RP_l") - middle - 3.0 * sd).abs() < 1e-9, "P{}", pose + 1);
    }
    let remarks = json["remarks"].to_string();
    assert!(remarks.contains("too few to judge the accuracy over a workspace"), "{remarks}");
    assert!(!remarks.contains("load is not stated") && !remarks.contains("speed is not stated"), "{remarks}");
}

#[test]
fn limits_decide_the_exit_code() {
    let folder = Folder::empty();
    measured(&folder);
    let run = |limit: &str| {
        folder.run(&["iso9283", "--robot", "robot.toml", "--data", "data.csv", "--spec", limit, "--json"])
    };
    // P5 is off by 1.87 mm.
    for (limit, code, verdict) in [
        ("AP=2mm", 0, "conform"),
        ("AP=1.871mm", 0, "undecided"),
        ("1mm", 1, "not conform"),
        ("RP=1mm", 0, "conform"),
        // No path was measured.
        ("AT=1mm", 0, "undecided"),
    ] {
        let json = run(limit).ended(code).json();
        assert_eq!(json["verdict"], verdict, "{limit}");
    }
    let wrong = run("XY=1mm").ended(2);
    assert!(wrong.log.contains("is no figure with a limit"), "{}", wrong.log);
}

#[test]
fn what_cannot_be_assessed_is_refused_with_its_file() {
    let folder = Folder::with_data();
    let run = ["iso9283", "--robot", "robot.toml", "--data", "data.csv"];
    let refused = folder.run(&run).ended(2);
    assert!(refused.log.contains("error: data.csv: no pose was measured twice"), "{}", refused.log);
    let refused = folder.run(&[&run[..], &["--path"]].concat()).ended(2);
    assert!(refused.log.contains("the data has no column `cycle`"), "{}", refused.log);
    let plan = "plan --for iso9283 --robot robot.toml --out p.csv --edge 9m";
    let refused = folder.run(plan).ended(2);
    assert!(refused.log.contains("no cube with an edge of 9000 mm"), "{}", refused.log);
}

#[test]
fn the_protocol_prints_to_one_sheet_and_is_repeated() {
    let folder = Folder::empty();
    measured(&folder);
    folder.write(
        "head.toml",
        "[certificate]\nnumber = \"17\"\noperator = \"<b>N. N.</b>\"\nenvironment = \"21 degC\"\n",
    );
    let run = ["iso9283", "--robot", "robot.toml", "--data", "data.csv", "--report", "page"];
    let limits = ["--spec", "AP=1mm", "--spec", "RP=0.1mm", "--certificate", "head.toml"];
    folder.run(&[&run[..], &limits].concat()).ended(1);
    let page = folder.read("page/index.html");
    for text in
        ["<dt>environment</dt><dd>21 degC</dd>", "&lt;b&gt;N. N.&lt;/b&gt;", "not conform", "ISO 14253-1"]
    {
        assert!(page.contains(text), "{text}");
    }
    folder.run("verify page/run.json").ended(0);
    let Some(browser) = browser() else {
        println!("SKIPPED: no Chromium is installed; the protocol was not printed");
        return;
    };
    let pdf = folder.file("protocol.pdf");
    let sheets = |page: &str| {
        chromium(browser, &folder, page, &[format!("--print-to-pdf={}", pdf.display())]);
        let text = String::from_utf8_lossy(&std::fs::read(&pdf).unwrap()).into_owned();
        text.matches("/Type /Page").count() - text.matches("/Type /Pages").count()
    };
    assert_eq!(sheets("page/summary.html"), 1);
    // The first sheet, and three or four with tables and figures: none is all but empty.
    assert!((3..=5).contains(&sheets("page/index.html")));
    if let Some(axe) = axe() {
        let seen = crate::pages::asked(browser, &folder, "page/index.html", &axe, 360);
        assert_eq!(seen["violations"], serde_json::json!([]));
        assert!(seen["wanted"].as_f64() <= seen["width"].as_f64().map(|w| w + 1.0), "{seen}");
    }
}

#[test]
fn a_fit_takes_its_displacement_off() {
    let folder = Folder::empty();
    folder.write("robot.toml", &robot());
    folder.write(
        "plant.toml",
        "robot = \"robot.toml\"\nseed = 3\n[errors.geometric]\nposition_mm = 0.4\nangle_mrad = 0.5\n[instrument]\nsd_um = 10\n\
         [repeatability]\nsd_um = 10\n[campaign]\npostures = \"random\"\nvisits = 30\nrepeats = 12\n",
    );
    folder.run("simulate --plant plant.toml --out data.csv").ended(0);
    folder.run("identify --robot robot.toml --data data.csv --out fit.json").ended(0);
    let out = folder.run("iso9283 --fit fit.json --data data.csv --json").ended(0).out;
    let json: Value = serde_json::from_str(&out).unwrap();
    let largest = |state: &str| {
        let poses = json[state]["poses"].as_array().unwrap();
        poses.iter().map(|pose| pose["figures"][0]["value"].as_f64().unwrap()).fold(0.0, f64::max)
    };
    assert_eq!(json["before"]["poses"].as_array().unwrap().len(), 30);
    assert!(largest("before") > 10.0 * largest("after"), "{} {}", largest("before"), largest("after"));
    let budget = &json["budget"];
    let names: Vec<&str> =
        budget["contributions"].as_array().unwrap().iter().map(|c| c["source"].as_str().unwrap()).collect();
    assert_eq!(names, ["instrument", "repeatability", "model parameters", "unexplained by the model"]);
    // 10 µm and 10 µm in each axis.
    let repeatability = budget["contributions"][1]["total_mm"].as_f64().unwrap();
    assert!((repeatability - 6e-4f64.sqrt()).abs() < 0.1 * 6e-4f64.sqrt(), "{repeatability}");
}
