//! What is written is well-formed for whoever reads it: spreadsheets, XML, YAML, and this program.

use crate::folder::{Folder, ROBOT};

fn words(text: &str) -> Vec<&str> {
    text.split(' ').collect()
}

/// The small arm with other names, measured and fitted.
fn named(joint: &str, target: &str) -> Folder {
    let folder = Folder::with_data();
    let toml = |name: &str| format!("{name:?}");
    let robot = ROBOT.replace("\"j1\"", &toml(joint)).replace("\"T1\"", &toml(target));
    folder.write("robot.toml", &robot);
    folder.run(&words("simulate --plant plant.toml --out data.csv")).ended(0);
    folder
        .run(&words("identify --robot robot.toml --data data.csv --folds 0 --out fit.json --report page"))
        .ended(0);
    folder
}

#[test]
fn names_that_are_formulas_are_texts_in_every_table_and_read_back() {
    for (joint, target) in [("=1+1", "=cmd|' /C calc'!A0"), ("+x", "@SUM(A1)"), ("-j", "-T"), ("@j", "+T")] {
        let folder = named(joint, target);
        for more in [
            "predict --fit fit.json --data data.csv --out predicted.csv",
            "compensate --fit fit.json --poses data.csv --out commands.csv",
            "map --fit fit.json --points 2 --out map.csv",
            "plan --fit fit.json --count 3 --out plan.csv",
            "export --fit fit.json --format dh --out dh.csv",
            "export --fit fit.json --format mdh --out mdh.csv",
            "export --fit fit.json --format iso230 --entries 2 --out iso230.csv",
        ] {
            folder.run(&words(more)).ended(0);
        }
        let tables: Vec<String> = folder.names().into_iter().filter(|name| name.ends_with(".csv")).collect();
        assert_eq!(tables.len(), 8, "{tables:?}");
        for table in tables {
            let text = folder.read(&table);
            for line in text.lines().filter(|line| !line.starts_with('#')) {
                for cell in line.split(',') {
                    let cell = cell.trim_start_matches('"');
                    let formula = cell.starts_with(['=', '+', '-', '@']) && cell.parse::<f64>().is_err();
                    assert!(!formula, "{table}: {cell}");
                }
            }
        }
        // And back: simulated data, predictions and a plan are tables of this robot.
        for table in ["data.csv", "predicted.csv"] {
            folder.run(&["check", "--robot", "robot.toml", "--data", table]).ended(0);
        }
        folder.run(&words("predict --fit fit.json --data plan.csv --out p.csv")).ended(0);
    }
}

#[test]
fn a_plan_is_read_by_every_verb_that_takes_joints() {
    let folder = named("j1", "T1");
    folder.run(&words("plan --fit fit.json --count 5 --loads 0,5 --out plan.csv")).ended(0);
    assert!(folder.read("plan.csv").lines().next().unwrap().contains(",why,worth"));
    let checked = folder.run(&words("check --robot robot.toml --data plan.csv")).ended(0);
    assert!(!checked.log.contains("error"), "{}", checked.log);
    folder.run(&words("predict --fit fit.json --data plan.csv --out p.csv")).ended(0);
    folder.run(&words("plan --fit fit.json --at plan.csv --count 2 --out again.csv")).ended(0);
}

/// Everything that XML 1.0 forbids, in names that no check has refused.
#[test]
fn what_xml_and_yaml_cannot_hold_is_in_no_file() {
    let strange = ['\u{85}', '\u{2028}', '\u{2029}', '\u{feff}', '\u{fffe}', '\u{ffff}', '\u{1}', '\u{7f}'];
    let folder = Folder::with_data();
    for c in strange {
        let robot = ROBOT.replace("\"j1\"", &format!("\"j\\U{:08x}1\"", u32::from(c)));
        folder.write("strange.toml", &robot);
        let run = folder.run(&words("check --robot strange.toml")).ended(2);
        assert!(run.log.starts_with("error: strange.toml:8:8: the name `j\\u{"), "{}", run.log);
    }
    // Names of robots and of channels are free.
    let all: String = strange.iter().map(|c| format!("\\U{:08x}", u32::from(*c))).collect();
    folder.write("robot.toml", &ROBOT.replace("\"small\"", &format!("\"s--{all}---\"")));
    let channel: String = strange.iter().filter(|c| **c != '\u{1}').collect();
    let data = folder.read("data.csv");
    let row = |(k, line): (usize, &str)| match k {
        0 => format!("{line},oil{channel}\n"),
        _ => format!("{line},{}\n", k % 7),
    };
    folder.write("data.csv", &data.lines().enumerate().map(row).collect::<String>());
    let run = |text: &str| folder.run(&words(text)).ended(0);
    run("identify --robot robot.toml --data data.csv --folds 0 --out fit.json --report page");
    run("discover --robot robot.toml --data data.csv --most 0 --flips 99 --report page2");
    for (format, file) in [("urdf", "a.urdf"), ("ros", "a.yaml"), ("dh", "a.csv"), ("iso230", "i.csv")] {
        run(&format!("export --fit fit.json --format {format} --out {file}"));
    }
    let figures = ["page", "page2"].map(|page| {
        let names = std::fs::read_dir(folder.file(page)).unwrap().map(|e| e.unwrap().file_name());
        names
            .map(|n| format!("{page}/{}", n.to_string_lossy()))
            .filter(|n| n.ends_with(".svg"))
            .collect::<Vec<_>>()
    });
    let figures = figures.concat();
    assert!(figures.len() > 3);
    for file in figures.iter().map(String::as_str).chain(["a.urdf", "a.yaml"]) {
        let text = folder.read(file);
        let found =
            text.chars().find(|c| (c.is_control() && !matches!(c, '\n' | '\t')) || strange[1..6].contains(c));
        let found =
            found.filter(|c| file.ends_with(".yaml") || !matches!(c, '\u{2028}' | '\u{2029}' | '\u{feff}'));
        assert_eq!(found, None, "{file}");
    }
    let urdf = folder.read("a.urdf");
    let comment = urdf.split_once("<!--").unwrap().1.split_once("-->").unwrap().0;
    assert!(!comment.contains("--"), "{comment}");
    folder.run(&words("check --robot a.urdf")).ended(0);
}
