//! What is written is well-formed for its readers: spreadsheets, XML and YAML.

use super::table::files;
use crate::folder::{Folder, ROBOT};

fn run(folder: &Folder, line: &str) {
    folder.run(&line.split(' ').collect::<Vec<_>>()).ended(0);
}

#[test]
fn names_that_are_formulas_are_texts_in_every_table_and_read_back() {
    for (joint, target) in [("=1+1", "=cmd|' /C calc'!A0"), ("+x", "@SUM(A1)"), ("-j", "-T"), ("@j", "+T")] {
        let folder = Folder::with_data();
        let robot = ROBOT.replace("\"j1\"", &format!("{joint:?}")).replace("\"T1\"", &format!("{target:?}"));
        folder.write("robot.toml", &robot);
        for line in [
            "simulate --plant plant.toml --out data.csv",
            "identify --robot robot.toml --data data.csv --folds 0 --out fit.json --report page",
            "predict --fit fit.json --data data.csv --out predicted.csv",
            "compensate --fit fit.json --poses data.csv --out commands.csv",
            "map --fit fit.json --points 2 --out map.csv",
            "plan --fit fit.json --count 3 --out plan.csv",
            "export --fit fit.json --format dh --out dh.csv",
            "export --fit fit.json --format mdh --out mdh.csv",
            "export --fit fit.json --format iso230 --entries 2 --out iso230.csv",
        ] {
            run(&folder, line);
        }
        let tables: Vec<String> = folder.names().into_iter().filter(|name| name.ends_with(".csv")).collect();
        assert_eq!(tables.len(), 8, "{tables:?}");
        for table in tables {
            for line in folder.read(&table).lines().filter(|line| !line.starts_with('#')) {
                for cell in line.split(',').map(|cell| cell.trim_start_matches('"')) {
                    let formula = cell.starts_with(['=', '+', '-', '@']) && cell.parse::<f64>().is_err();
                    assert!(!formula, "{table}: {cell}");
                }
            }
        }
        // And back: simulated data, predictions and a plan are tables of this robot.
        run(&folder, "check --robot robot.toml --data data.csv");
        run(&folder, "check --robot robot.toml --data predicted.csv");
        run(&folder, "predict --fit fit.json --data plan.csv --out p.csv");
    }
}

/// Everything that XML 1.0 forbids, in names of robots and channels, which are free.
#[test]
fn what_xml_and_yaml_cannot_hold_is_in_no_file() {
    let strange = ['\u{85}', '\u{2028}', '\u{2029}', '\u{feff}', '\u{fffe}', '\u{ffff}', '\u{1}', '\u{7f}'];
    let folder = Folder::with_data();
    let all: String = strange.iter().map(|c| format!("\\U{:08x}", u32::from(*c))).collect();
    folder.write("robot.toml", &ROBOT.replace("\"small\"", &format!("\"s--{all}---\"")));
    let channel: String = strange.iter().filter(|c| **c != '\u{1}').collect();
    let cell = |k: usize| if k == 0 { format!("oil{channel}") } else { (k % 7).to_string() };
    let data = folder.read("data.csv");
    let rows = data.lines().enumerate().map(|(k, line)| format!("{line},{}\n", cell(k)));
    folder.write("data.csv", &rows.collect::<String>());
    run(&folder, "identify --robot robot.toml --data data.csv --folds 0 --out fit.json --report page");
    run(&folder, "discover --robot robot.toml --data data.csv --most 0 --flips 99 --report page2");
    for (format, file) in [("urdf", "a.urdf"), ("ros", "a.yaml"), ("dh", "a.csv"), ("iso230", "i.csv")] {
        run(&folder, &format!("export --fit fit.json --format {format} --out {file}"));
    }
    let all = files(&folder, true)
        .into_iter()
        .filter_map(|(name, text)| Some((name, String::from_utf8(text?).ok()?)));
    let all = all.filter(|(name, _)| [".svg", ".urdf", ".yaml"].iter().any(|ending| name.ends_with(ending)));
    let mut count = 0;
    for (name, text) in all {
        let yaml = name.ends_with(".yaml");
        let forbidden = |c: &char| match c {
            '\n' | '\t' => false,
            '\u{2028}' | '\u{2029}' | '\u{feff}' => yaml,
            c => c.is_control() || matches!(c, '\u{fffe}' | '\u{ffff}'),
        };
        assert_eq!(text.chars().find(forbidden), None, "{name}");
        count += 1;
    }
    assert!(count > 5, "{count} files");
    let urdf = folder.read("a.urdf");
    let comment = urdf.split_once("<!--").unwrap().1.split_once("-->").unwrap().0;
    assert!(!comment.contains("--"), "{comment}");
    run(&folder, "check --robot a.urdf");
}
