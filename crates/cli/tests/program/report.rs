//! Reports: one source of numbers, names that are shown and not run, runs that repeat.

use crate::folder::{Folder, ROBOT};
use serde_json::Value;
use std::sync::LazyLock;
use truepose_report::{significant, value_with_interval};

/// Names of a robot and of its first joint.
pub const PLAIN: [&str; 2] = ["small", "j1"];
/// The same, which would run where a page does not escape them.
pub const EVIL: [&str; 2] = ["<img src=x onerror=alert(1)>", "j1</script><img src=x onerror=alert(1)>"];

/// A robot with a wave in its first joint that the declared model lacks.
const PLANT: &str = r#"robot = "robot.toml"
seed = 3

[errors.geometric]
position_mm = 0.3
angle_mrad = 0.4

[[errors.transmission]]
joint = "J1"
amplitude_mrad = 0.8

[instrument]
sd_um = 20

[campaign]
postures = "random"
visits = 60
"#;

/// The small robot with an undeclared transmission error: `robot.toml`, `plant.toml` and `data.csv`.
pub fn measured(robot: &str, joint: &str) -> Folder {
    let folder = Folder::empty();
    let text = ROBOT.replace("\"small\"", &format!("{robot:?}")).replace("\"j1\"", &format!("{joint:?}"));
    folder.write("robot.toml", &text);
    folder.write("plant.toml", &PLANT.replace("\"J1\"", &format!("{joint:?}")));
    folder.run("simulate --plant plant.toml --out data.csv").ended(0);
    folder
}

/// The same with the report of a discovery in `page`, and what it printed in `printed.txt`: once for all tests of the process.
pub fn discovered(names: [&str; 2]) -> Folder {
    static BOTH: [LazyLock<Folder>; 2] =
        [LazyLock::new(|| searched(PLAIN)), LazyLock::new(|| searched(EVIL))];
    BOTH[usize::from(names == EVIL)].copied()
}

/// What the report in `page` is of.
const SEARCH: &str =
    "discover --robot robot.toml --data data.csv --spec 0.2mm --correction commands --rotations 499";

fn searched([robot, joint]: [&str; 2]) -> Folder {
    let folder = measured(robot, joint);
    let run = folder.run(&format!("{SEARCH} --report page")).ended(0);
    folder.write("printed.txt", &run.out);
    folder
}

/// As a page has a text.
fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;")
}

#[test]
fn page_json_and_terminal_have_the_same_numbers() {
    let folder = discovered(PLAIN);
    let terminal = folder.read("printed.txt");
    let json = folder.run(&format!("{SEARCH} --json")).ended(0).json();
    let result = folder.json("page/discovery.json");
    assert_eq!(json, result);

    let page = folder.read("page/index.html");
    let number = |pointer: &str| significant(result.pointer(pointer).unwrap().as_f64().unwrap(), 3);
    for pointer in ["/before/holdout/rms_mm", "/after/holdout/rms_mm"] {
        assert!(page.contains(&format!("<b>{}</b>", number(pointer))), "{pointer}");
        assert!(terminal.contains(&number(pointer)), "{pointer}");
    }
    // The terminal and the page form the same sentence of it.
    let limit = match result.pointer("/noise_floor/source").and_then(Value::as_str) {
        Some("unknown") => "Repeatability limit: unknown".to_owned(),
        _ => format!("Repeatability limit: {} mm", number("/noise_floor/rms_mm")),
    };
    assert!(page.contains(&limit) && terminal.contains(&limit), "{limit}\n{terminal}");
    // The verdict comes first, and is the same sentence.
    let verdict =
        terminal.lines().find(|line| line.contains("ndecided: ") || line.contains("explained: ")).unwrap();
    assert!(terminal.lines().nth(2) == Some(verdict) && page.contains(&escaped(verdict)), "{verdict}");
    let ends = |pointer: &str| {
        let end =
            |k: usize| significant(result.pointer(&format!("{pointer}/{k}")).unwrap().as_f64().unwrap(), 2);
        format!("({} to {})", end(0), end(1))
    };
    for pointer in ["/before/holdout/ci95_mm", "/after/holdout/ci95_mm", "/gain/ci95_mm"] {
        assert!(page.contains(&ends(pointer)) && terminal.contains(&ends(pointer)), "{pointer}\n{terminal}");
    }
    for part in result["extrapolation"].as_array().unwrap() {
        let figure = format!("): {} mm", significant(part["after"]["rms_mm"].as_f64().unwrap(), 3));
        assert!(page.contains(&figure) && terminal.contains(&figure), "{figure}\n{terminal}");
    }
    // The noise per component is that of the fit, in mm: within a factor of two of the training residual over √3.
    let noise = page.split_once("Dashed: noise of ").and_then(|(_, rest)| rest.split_once(" mm")).unwrap().0;
    let ratio = noise.parse::<f64>().unwrap() * 3f64.sqrt()
        / result.pointer("/after/train/rms_mm").unwrap().as_f64().unwrap();
    assert!((0.5..2.0).contains(&ratio), "noise of {noise} mm per component");
    let inside = format!("{} of", result.pointer("/specification/inside").unwrap());
    assert!(page.contains(&inside) && terminal.contains(&inside));
    let effects = result["effects"].as_array().unwrap();
    assert!(!effects.is_empty(), "the wave was not found:\n{terminal}");
    for (k, effect) in effects.iter().enumerate() {
        let after = significant(effect["holdout_rms_mm"]["after"].as_f64().unwrap(), 3);
        assert!(page.contains(&after) && terminal.contains(&after));
        for (key, share) in [("p_value", 1.0), ("stability", 100.0)] {
            let digits = if key == "p_value" { 2 } else { 3 };
            let shown = significant(share * effect[key].as_f64().unwrap(), digits);
            let words =
                if key == "p_value" { format!("p = {shown}") } else { format!("selected in {shown} %") };
            assert!(page.contains(&words) && terminal.contains(&words), "{words}");
        }
        for (parameter, first) in effect["parameters"].as_array().unwrap().iter().zip(0..) {
            let number = |key: &str| parameter.pointer(key).unwrap().as_f64().unwrap();
            let half = 0.5 * (number("/ci95/1") - number("/ci95/0"));
            assert!(half > 0.0, "a parameter without its interval: {parameter}");
            let (value, half, _) =
                value_with_interval(number("/value"), half, parameter["unit"].as_str().unwrap());
            let words = format!("{value} ± {half}");
            assert!(page.contains(&words), "{words}");
            assert!(terminal.contains(&words) || first >= 4, "{words}");
        }
        for (hypothesis, first) in effect["alternatives"].as_array().unwrap().iter().zip(0..) {
            let held_out = significant(hypothesis["holdout_rms_mm"].as_f64().unwrap(), 3);
            assert!(page.contains(&format!("<td>{held_out}</td>")), "{held_out}");
            assert!(terminal.contains(&format!("({held_out} mm held out)")) || first >= 2, "{held_out}");
        }
        let meaning = effect["meaning"].as_str().unwrap();
        assert!(page.contains(meaning) && terminal.contains(meaning), "{meaning}");
        assert!(folder.read(&format!("page/effect_{}.svg", k + 1)).starts_with("<svg"));
    }
}

#[cfg(feature = "slow")]
#[test]
fn page_json_and_terminal_have_the_same_nonlinear_parameters() {
    let folder = discovered(PLAIN);
    let declared = |range: &str| {
        format!(
            "[[effects]]\nfamily = \"geometric\"\n\n\
             [[effects]]\nfamily = \"transmission\"\njoint = \"j1\"\nperiod_range = {range}\n"
        )
    };
    // The wave is one turn long: the second range ends just behind it.
    for (range, cut) in [("[5.0, 8.0]", [false, false]), ("[5.0, 6.2832]", [false, true])] {
        folder.write("model.toml", &declared(range));
        let same = "identify --robot robot.toml --data data.csv --model model.toml";
        let terminal = folder.run(&format!("{same} --report shaped")).ended(0).out;
        let page = folder.read("shaped/index.html");
        let json = folder.json("shaped/identification.json");
        let [shape] = &json["shapes"].as_array().unwrap()[..] else { panic!("{json}") };
        assert_eq!(shape["cut"], serde_json::json!(cut), "{range}: {shape}");
        let number = |pointer: &str| significant(shape.pointer(pointer).unwrap().as_f64().unwrap(), 6);
        let (value, ends) = (number("/value"), format!("[{}, {}]", number("/ci95/0"), number("/ci95/1")));
        let words = if cut[1] { "upper end limited by the search range" } else { "" };
        let line = format!(" period = {value} rad  {ends}  (effect 2, transmission)");
        assert!(terminal.contains(&line) && terminal.contains(words), "{line}\n{terminal}");
        let row = format!(
            "<tr><th scope=\"row\">period</th><td>{value}</td><td>{ends}</td><td>rad</td><td>effect 2, transmission</td>"
        );
        assert!(page.contains(&row) && page.contains(words), "{row}");
        assert_eq!(
            page.contains("<th scope=\"col\">limits of the interval</th>"),
            cut[1],
            "a column of nothing"
        );
    }
    // Where nothing was looked for there is no table.
    folder.run("identify --robot robot.toml --data data.csv --report plain").ended(0);
    assert!(!folder.read("plain/index.html").contains("Nonlinear parameters"));
}

#[test]
fn names_are_shown_and_not_run() {
    const FILE: &str = "<img src=x onerror=alert(1)>.csv";
    const POSES: &str = "<img src=x onerror=alert(1)> poses.csv";
    const CHANNEL: &str = "<img src=y onerror=alert(2)>";
    let folder = discovered(EVIL);
    let robot = folder.read("robot.toml").replace("\"T1\"", &format!("{:?}", EVIL[0]));
    folder.write("robot.toml", &robot);
    // A channel and a file of that name as well.
    let rows: Vec<String> = folder
        .read("data.csv")
        .lines()
        .zip(0..)
        .map(|(line, k)| match k {
            0 => format!("{line},{CHANNEL}[degC]"),
            _ => format!("{},{}", line.replace(",T1,", &format!(",{},", EVIL[0])), 20 + k % 7),
        })
        .collect();
    folder.write(FILE, &(rows.join("\n") + "\n"));
    let inputs = ["--robot", "robot.toml", "--data", FILE];
    let with = |verb: &'static str, more: &[&'static str]| [&[verb], &inputs[..], more].concat();
    folder.run(&with("discover", &["--report", "d", "--rotations", "499"])).ended(0);
    folder.run(&with("identify", &["--report", "i", "--out", "fit.json"])).ended(0);
    folder.run(&with("compare", &["--solver", "qr", "--solver", "svd", "--report", "c"])).ended(0);
    folder.run(&["predict", "--fit", "fit.json", "--data", FILE, "--out", POSES]).ended(0);
    folder
        .run(&["compensate", "--fit", "fit.json", "--poses", POSES, "--out", "q.csv", "--report", "k"])
        .ended(0);
    for page in ["page", "d", "i", "c", "k"] {
        let html = folder.read(&format!("{page}/index.html"));
        assert!(html.matches("&lt;img src=x onerror=alert(1)&gt;").count() > 2, "{page}");
        for name in std::fs::read_dir(folder.file(page)).unwrap().map(|e| e.unwrap().path()) {
            if name.extension().is_some_and(|e| e == "svg" || e == "html") {
                assert!(!std::fs::read_to_string(&name).unwrap().contains("<img"), "{}", name.display());
            }
        }
    }
    let html = folder.read("d/index.html");
    let label = format!("against {CHANNEL}").replace('<', "&lt;").replace('>', "&gt;");
    assert!(html.contains(&label), "the channel is shown");
}

#[test]
fn a_run_repeats_and_a_changed_file_is_detected() {
    let folder = discovered(PLAIN);
    let said = folder.run("verify page/run.json").ended(0).out;
    assert!(said.contains("reproduced"), "{said}");
    let before = folder.names();

    let result = folder.read("page/discovery.json");
    folder.write("page/discovery.json", &result.replacen("\"rows\": ", "\"rows\": 1", 1));
    assert!(folder.run("verify page/run.json").ended(1).log.contains("was changed since the run"));
    folder.write("page/discovery.json", &result);

    let data = folder.read("data.csv");
    folder.write("data.csv", &format!("{data}\n"));
    assert!(folder.run("verify page/run.json").ended(1).log.contains("data.csv is not the file"));
    folder.write("data.csv", &data);

    folder.write("page/run.json", "{\"format\": 3}");
    assert!(folder.run("verify page/run.json").ended(2).log.contains("page/run.json"));
    assert_eq!(folder.names(), before);
}

#[test]
fn every_verb_with_a_report_writes_one_that_repeats() {
    let folder = Folder::with_data();
    let inputs = ["--robot", "robot.toml", "--data", "data.csv"];
    let with = |verb: &'static str, more: &[&'static str]| [&[verb], &inputs[..], more].concat();
    folder
        .run(&with(
            "identify",
            &["--out", "fit.json", "--report", "i", "--spec", "0.2mm", "--correction", "constants"],
        ))
        .ended(0);
    folder.run(&with("compare", &["--solver", "qr", "--solver", "svd", "--report", "c"])).ended(0);
    folder.run("predict --fit fit.json --data data.csv --out poses.csv").ended(0);
    folder.run("compensate --fit fit.json --poses poses.csv --out commands.csv --report k").ended(0);
    for (page, result) in [("i", "identification"), ("c", "comparison"), ("k", "compensation")] {
        let html = folder.read(&format!("{page}/index.html"));
        assert!(html.contains("<svg") && !html.contains("NaN"), "{page}");
        assert!(serde_json::from_str::<Value>(&folder.read(&format!("{page}/{result}.json"))).is_ok());
        folder.run(&["verify", &format!("{page}/run.json")]).ended(0);
    }
    let judged = folder.json("i/identification.json");
    assert_eq!(judged["specification"]["poses"], 40);
}
