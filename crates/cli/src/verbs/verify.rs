//! `truepose verify`: repeat a run from its record, and compare.

use crate::args::Verify;
use crate::failure::Failure;
use crate::terminal;
use serde_json::Value;
use std::path::Path;
use std::process::{Command, Stdio};
use truepose_io::{file_digest, read_text};
use truepose_report::{RunRecord, count};

/// Largest relative difference of numbers that count as equal.
const SAME: f64 = 1e-9;

/// Runs the verb.
pub fn run(args: &Verify) -> Result<(), Failure> {
    let file = args.run.display();
    let text = read_text(&args.run)?;
    let record: RunRecord =
        serde_json::from_str(&text).map_err(|error| Failure::Input(no_record(&args.run, &error)))?;
    if record.format != RunRecord::FORMAT || record.version != 1 {
        return Err(Failure::Input(format!(
            "{file}: `{}` version {} is not a record that this program reads",
            record.format, record.version
        )));
    }
    for input in &record.inputs {
        let (_, now) = file_digest(&input.file)?;
        if now != input.sha256 {
            return Err(Failure::Criterion(format!("{} is not the file that the run read", input.file)));
        }
    }
    if record.program != super::reporting::PROGRAM {
        terminal::log(&format!("the run was made by {}", record.program));
    }
    let folder = args.run.parent().unwrap_or(Path::new("."));
    let result = Path::new(&record.result.file);
    if result.components().count() != 1 {
        return Err(Failure::Input(format!(
            "{file}: the result `{}` is not a file beside it",
            record.result.file
        )));
    }
    let then = folder.join(result);
    if file_digest(&then)?.1 != record.result.sha256 {
        return Err(Failure::Criterion(format!("{} was changed since the run", then.display())));
    }
    let own = std::env::temp_dir().join(format!("truepose-verify-{}", std::process::id()));
    std::fs::create_dir(&own)?;
    let compared = repeat(&record, &own, &then);
    std::fs::remove_dir_all(&own)?;
    let differences = compared?;
    if differences.is_empty() {
        terminal::print(&format!(
            "{}: reproduced ({} unchanged)\n",
            then.display(),
            count(record.inputs.len(), "file")
        ));
        return Ok(());
    }
    for difference in differences.iter().take(10) {
        terminal::print(&format!("{difference}\n"));
    }
    Err(Failure::Criterion(format!("{} in the repeated run", count(differences.len(), "difference"))))
}

/// What is wrong with a file that should be a record, and where.
fn no_record(file: &Path, error: &serde_json::Error) -> String {
    let words = error.to_string();
    let words = words.split(" at line ").next().unwrap_or(&words);
    let (line, column) = (error.line().max(1), error.column().max(1));
    format!(
        "{}:{line}:{column}: is not a record of a run ({words}); `--report DIR` writes one, DIR/run.json",
        file.display()
    )
}

/// Runs the program again, with its outputs in a folder of our own, and lists what differs.
fn repeat(record: &RunRecord, own: &Path, then: &Path) -> Result<Vec<String>, Failure> {
    let arguments = redirected(&record.arguments, own)?;
    let child = Command::new(std::env::current_exe()?).args(&arguments).stdout(Stdio::null()).output()?;
    let now = own.join(&record.result.file);
    if !now.is_file() {
        let message = String::from_utf8_lossy(&child.stderr);
        return Err(Failure::Input(format!("the run could not be repeated: {}", message.trim())));
    }
    let (then, now): (Value, Value) =
        (serde_json::from_str(&read_text(then)?)?, serde_json::from_str(&read_text(now)?)?);
    let mut differences = Vec::new();
    compare("", &then, &now, &mut differences);
    Ok(differences)
}

/// The arguments with outputs in this folder.
fn redirected(arguments: &[String], own: &Path) -> Result<Vec<String>, Failure> {
    let repeatable = ["discover", "identify", "compare", "compensate"];
    let Some(verb) = arguments.iter().find(|a| repeatable.contains(&a.as_str())).cloned() else {
        return Err(Failure::Input(format!("only {} can be repeated", repeatable.join(", "))));
    };
    let rivals = || ["--rivals".to_owned(), own.join("rivals").to_string_lossy().into_owned()];
    let mut kept = Vec::new();
    let mut rest = arguments.iter();
    while let Some(argument) = rest.next() {
        match argument.as_str() {
            "--report" | "--out" => {
                rest.next();
            }
            "--rivals" => {
                rest.next();
                kept.extend(rivals());
            }
            a if a.starts_with("--rivals=") => kept.extend(rivals()),
            a if a.starts_with("--report=") || a.starts_with("--out=") => {}
            _ => kept.push(argument.clone()),
        }
    }
    kept.extend(["--report".into(), own.to_string_lossy().into_owned()]);
    if verb == "compensate" {
        kept.extend(["--out".into(), own.join("commands.csv").to_string_lossy().into_owned()]);
    }
    Ok(kept)
}

/// Places at which two values differ; wall times always do.
fn compare(at: &str, then: &Value, now: &Value, differences: &mut Vec<String>) {
    match (then, now) {
        (Value::Object(a), Value::Object(b)) => {
            for key in a.keys().chain(b.keys().filter(|key| !a.contains_key(*key))) {
                if key != "seconds" {
                    let none = Value::Null;
                    let (a, b) = (a.get(key).unwrap_or(&none), b.get(key).unwrap_or(&none));
                    compare(&format!("{at}/{key}"), a, b, differences);
                }
            }
        }
        (Value::Array(a), Value::Array(b)) if a.len() == b.len() => {
            for (k, (a, b)) in a.iter().zip(b).enumerate() {
                compare(&format!("{at}/{k}"), a, b, differences);
            }
        }
        (Value::Number(a), Value::Number(b)) => {
            let (x, y) = (a.as_f64().unwrap_or(f64::NAN), b.as_f64().unwrap_or(f64::NAN));
            let same = (x - y).abs() <= SAME * x.abs().max(y.abs());
            if !same {
                differences.push(format!("{at}: {a} in the record, {b} now"));
            }
        }
        _ if then == now => {}
        _ => differences.push(format!("{at}: {then} in the record, {now} now")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn differences_are_named_by_their_place() {
        let mut found = Vec::new();
        let then = json!({"a": [1.0, 2.0], "seconds": 1.0, "name": "x"});
        compare("", &then, &json!({"a": [1.0, 2.5], "seconds": 9.0, "name": "x"}), &mut found);
        assert_eq!(found, ["/a/1: 2.0 in the record, 2.5 now"]);
        found.clear();
        compare("", &then, &json!({"a": [1.0], "name": "y", "more": 1}), &mut found);
        assert_eq!(found.len(), 3, "{found:?}");
    }

    #[test]
    fn outputs_are_redirected() {
        let words = ["discover", "--out", "fit.json", "--report=r", "--seed", "3"].map(String::from);
        let now = redirected(&words, Path::new("own")).unwrap();
        assert_eq!(now, ["discover", "--seed", "3", "--report", "own"]);
        for words in [&["discover", "--rivals", "mine"][..], &["discover", "--rivals=mine"]] {
            let words: Vec<String> = words.iter().map(ToString::to_string).collect();
            let now = redirected(&words, Path::new("own")).unwrap();
            assert_eq!(now, ["discover", "--rivals", "own/rivals", "--report", "own"]);
        }
        assert!(redirected(&["simulate".into()], Path::new("own")).is_err());
    }
}
