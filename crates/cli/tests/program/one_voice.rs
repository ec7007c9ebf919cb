//! Terminal, page and JSON of one run are parsed and compared: the same verdict, the same rows, the same figures.

use crate::folder::Folder;
use serde_json::Value;

/// The page as text: without tags, its entities replaced.
fn text_of(html: &str) -> String {
    let body = &html[html.find("<main>").unwrap()..];
    let mut text = String::new();
    let mut inside = false;
    for c in body.chars() {
        match c {
            '<' => inside = true,
            '>' => {
                inside = false;
                text.push(' ');
            }
            c if !inside => text.push(c),
            _ => {}
        }
    }
    for (entity, c) in [("&lt;", "<"), ("&gt;", ">"), ("&quot;", "\""), ("&#39;", "'"), ("&amp;", "&")] {
        text = text.replace(entity, c);
    }
    text.split_whitespace().collect::<Vec<_>>().join(" ")
}

/// Cells of the table with this caption.
fn table(html: &str, caption: &str) -> Vec<Vec<String>> {
    let start = html.find(&format!("<caption>{caption}")).unwrap_or_else(|| panic!("no table `{caption}`"));
    let body = &html[start..start + html[start..].find("</table>").unwrap()];
    let rows = body.split("<tr>").skip(2);
    let cells = |row: &str| {
        row.split("</t").map(|cell| cell.rsplit('>').next().unwrap().trim().to_owned()).collect::<Vec<_>>()
    };
    rows.map(|row| cells(row).into_iter().filter(|cell| !cell.is_empty()).collect()).collect()
}

/// Three digits, as texts have them.
fn three(value: &Value) -> String {
    truepose_report::significant(value.as_f64().unwrap(), 3)
}

struct Said {
    terminal: String,
    page: String,
    html: String,
    json: Value,
    folder: Folder,
    code: Option<i32>,
}

fn said(verb: &str, spec: &str) -> Said {
    let folder = Folder::with_data();
    let run =
        [verb, "--robot", "robot.toml", "--data", "data.csv", "--spec", spec, "--correction", "commands"];
    let ran = folder.run(&[&run[..], &["--report", "r", "--parameters", "p.csv"]].concat());
    let name = if verb == "identify" { "r/identification.json" } else { "r/discovery.json" };
    let json = folder.json(name);
    let html = folder.read("r/index.html");
    let mut terminal = ran.out.split_whitespace().collect::<Vec<_>>().join(" ");
    terminal.push(' ');
    Said { terminal, page: text_of(&html), html, json, code: ran.code, folder }
}

#[test]
fn an_identification_has_one_verdict() {
    for (spec, verdict, code) in [("0.001mm", "fail", 1), ("50mm", "not decided", 0)] {
        let Said { terminal, page, json, code: ended, .. } = said("identify", spec);
        assert_eq!(ended, Some(code), "{terminal}");
        let sentence = json["verdict"].as_str().unwrap();
        assert!(terminal.contains(sentence) && page.contains(sentence), "{sentence}\n{terminal}\n{page}");
        // The sentence has the figures of the JSON.
        for stage in json["stages"].as_array().unwrap() {
            let judged =
                ["locked", "held_out", "train"].into_iter().map(|key| &stage[key]).find(|s| !s.is_null());
            let shown =
                format!("{} mm ({})", three(&judged.unwrap()["rms_mm"]), stage["name"].as_str().unwrap());
            assert!(sentence.contains(&shown), "{shown}: {sentence}");
        }
        let limit = json["limit"].as_str().unwrap();
        assert!(terminal.contains(limit) && page.contains(limit), "{limit}");
        // The specification: one sentence, and its word in the JSON.
        let begin = format!(
            "Specification {} mm (if compensated): {verdict}",
            three(&json["specification"]["limit_mm"])
        );
        let of = |text: &str| {
            let start = text.find(&begin).unwrap_or_else(|| panic!("no `{begin}` in {text}"));
            text[start..].split("inside (required: 95 %).").next().unwrap().to_owned()
        };
        assert_eq!(of(&terminal), of(&page));
        let word = json["specification"]["verdict"].as_str().unwrap();
        assert_eq!(word, if verdict == "fail" { "fail" } else { "cannot_tell" });
    }
}

#[test]
fn a_budget_has_no_zero_for_what_is_not_known() {
    let Said { terminal, page, json, .. } = said("identify", "50mm");
    let instrument = &json["budget"]["contributions"][0];
    assert_eq!(instrument["source"], "instrument");
    for key in ["u_mm", "total_mm", "fraction", "freedom"] {
        assert!(instrument[key].is_null(), "{key}: {instrument}");
    }
    assert!(json["budget"]["contributions"][2]["total_mm"].as_f64().unwrap() > 0.0);
    for text in [terminal, page] {
        assert!(text.contains("instrument B – – – – – – "), "{text}");
        assert!(text.contains("instrument: not stated (columns sx, sy, sz)"), "{text}");
    }
}

#[test]
fn rows_have_one_number_and_one_line() {
    let Said { terminal, html, json, folder, .. } = said("identify", "50mm");
    let data = folder.read("data.csv");
    let header: Vec<&str> = data.lines().next().unwrap().split(',').collect();
    let visit = header.iter().position(|name| *name == "visit").unwrap();
    let shown = table(&html, "Pose measurements with the largest errors");
    let worst = json["worst"].as_array().unwrap();
    assert_eq!(worst.len(), shown.len());
    for (k, (error, cells)) in worst.iter().zip(&shown).enumerate() {
        let (pose, row, line) =
            (error["pose"].as_str().unwrap(), &error["row"], error["line"].as_u64().unwrap());
        assert_eq!(cells[..3], [pose.to_owned(), row.to_string(), line.to_string()]);
        assert_eq!(cells[4], three(&error["error_mm"]));
        assert_eq!(cells.last().unwrap() == "yes", error["held_out"].as_bool().unwrap());
        // The line of the file is that of the row, and of the pose measurement.
        assert_eq!(line, row.as_u64().unwrap() + 1);
        let cell = data.lines().nth(line as usize - 1).unwrap().split(',').nth(visit).unwrap();
        assert_eq!(cell, pose);
        let text = format!("line {line}: {} mm", three(&error["error_mm"]));
        assert_eq!(terminal.contains(&text), k < 5, "{text}\n{terminal}");
    }
}

#[test]
fn parameters_are_the_same_in_four_places() {
    for verb in ["identify", "discover"] {
        let Said { terminal, html, json, folder, .. } = said(verb, "50mm");
        let list = json["parameters"]["parameters"].as_array().unwrap();
        let csv = folder.read("p.csv");
        let rows = table(&html, "Parameters in the convention");
        assert_eq!(rows.len(), list.len());
        for ((parameter, cells), line) in list.iter().zip(&rows).zip(csv.lines().skip(1)) {
            let (part, name) =
                (parameter["part"].as_str().unwrap(), parameter["parameter"].as_str().unwrap());
            assert_eq!(cells[..2], [part, name]);
            assert!(terminal.contains(&format!("{} ", cells.join(" "))), "{cells:?}");
            let calibrated = parameter["calibrated"].as_f64().unwrap();
            let decimals = cells[5].split('.').nth(1).map_or(0, str::len);
            assert!(
                (cells[5].parse::<f64>().unwrap() - calibrated).abs() <= 0.51 * 0.1f64.powi(decimals as i32)
            );
            assert!(
                line.starts_with(&format!("{part},{name},")) && line.contains(&format!(",{calibrated:?},"))
            );
        }
    }
}

#[test]
fn a_discovery_has_one_verdict() {
    let Said { terminal, page, html, json, code, .. } = said("discover", "0.001mm");
    assert_eq!(code, Some(1));
    let sentence = html.split("<p class=\"verdict\">").nth(1).unwrap().split("</p>").next().unwrap();
    assert!(terminal.contains(&text_of(&format!("<main>{sentence}"))), "{sentence}\n{terminal}");
    let word = json["verdict"].as_str().unwrap();
    let first = sentence.split([':', ' ']).next().unwrap().to_lowercase();
    assert_eq!(if word == "unexplained" { "not" } else { word }, first);
    let begin =
        format!("Specification {} mm (if compensated): fail", three(&json["specification"]["limit_mm"]));
    assert!(terminal.contains(&begin) && page.contains(&begin), "{begin}");
    for part in ["before", "after"] {
        let rms = three(&json[part]["holdout"]["rms_mm"]);
        assert!(terminal.contains(&format!("{rms} ")) && page.contains(&format!("{rms} ")), "{rms}");
    }
}

#[test]
fn nothing_is_a_number_that_was_not_measured() {
    let folder = Folder::with_data();
    folder.run("identify --robot robot.toml --data data.csv --out fit.json").ended(0);
    folder.write("t.csv", "x[mm],y[mm],z[mm]\n# far away\n9000,0,0\n400,100,200\n");
    let run = ["compensate", "--fit", "fit.json", "--poses", "t.csv", "--out", "c.csv", "--report", "r"];
    folder.run(&run).ended(0);
    let json = folder.json("r/compensation.json");
    let far = &json["commands"][0];
    assert_eq!((far["row"].as_u64(), far["line"].as_u64()), (Some(1), Some(3)));
    assert_ne!(far["status"], "ok");
    for key in ["correction_mm", "within_95_mm", "extrapolates", "joints"] {
        assert!(far[key].is_null(), "{key}: {far}");
    }
    // A box out of reach has no errors, neither before nor after.
    let outside = ["--from=9m,9m,9m", "--to=9.1m,9.1m,9.1m", "--points", "2", "--json"];
    let said =
        folder.run(&[&["map", "--fit", "fit.json", "--out", "m.csv"][..], &outside].concat()).ended(0).out;
    let json: Value = serde_json::from_str(&said).unwrap();
    for quantity in ["before", "before_95", "after_95"] {
        assert!(json[quantity]["rms_mm"].is_null() && json["within"][quantity]["max_mm"].is_null(), "{json}");
    }
    // Terminal and JSON have the same figures of a map.
    let map = "map --fit fit.json --out m.csv --points 3";
    let text = folder.run(map).ended(0).out;
    let json = folder.run(&format!("{map} --json")).ended(0).json();
    for quantity in ["before_95", "after_95"] {
        let shown = format!(
            "RMS {} mm, max {} mm",
            three(&json[quantity]["rms_mm"]),
            three(&json[quantity]["max_mm"])
        );
        assert!(text.contains(&shown), "{shown}\n{text}");
    }
}
