//! `truepose verify`: repeat a run from its record, and compare.

use super::repeated::Repeated;
use crate::args::{NamedFile, Verify};
use crate::failure::Failure;
use crate::terminal;
use crate::watch::Watch;
use serde_json::Value;
use std::path::Path;
use truepose_io::{ScratchFolder, file_digest, read_text};
use truepose_report::{RunRecord, count};

/// Largest relative difference of numbers that count as equal.
const SAME: f64 = 1e-9;

/// Runs the verb.
pub fn run(args: &Verify, watch: &Watch) -> Result<(), Failure> {
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
    let own = ScratchFolder::create()?;
    let repeated = Repeated::of(&record.arguments, own.path())
        .map_err(|words| Failure::Input(format!("{file}: {words}")))?;
    if record.result.file != repeated.result {
        let words = format!("the result of this run is `{}`, not `{}`", repeated.result, record.result.file);
        return Err(Failure::Input(format!("{file}: {words}")));
    }
    for NamedFile { option, path, .. } in &repeated.files.read {
        if !record.inputs.iter().any(|input| Path::new(&input.file) == path) {
            let words = format!("`{}`, which {option} reads, is not among the inputs", path.display());
            return Err(Failure::Input(format!("{file}: {words}")));
        }
    }
    for input in &record.inputs {
        let special = std::fs::metadata(&input.file).is_ok_and(|found| !found.is_file());
        if special || input.sha256.is_empty() {
            let words = format!("`{}` is not a regular file, and cannot be read again", input.file);
            return Err(Failure::Input(format!("{file}: {words}")));
        }
        let (_, now) = file_digest(&input.file)?;
        if now != input.sha256 {
            return Err(Failure::Criterion(format!("{} is not the file that the run read", input.file)));
        }
    }
    if record.program != super::reporting::PROGRAM {
        terminal::log(&format!("the run was made by {}", record.program));
    }
    let then = args.run.parent().unwrap_or(Path::new(".")).join(repeated.result);
    if file_digest(&then)?.1 != record.result.sha256 {
        return Err(Failure::Criterion(format!("{} was changed since the run", then.display())));
    }
    let differences = repeat(&repeated, &then, watch)?;
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

/// Runs the recorded verb again, with its outputs in an empty folder of our own, and lists what differs.
fn repeat(repeated: &Repeated, then: &Path, watch: &Watch) -> Result<Vec<String>, Failure> {
    watch.doing("repeating the run");
    let now = repeated.report.join(repeated.result);
    // Its findings so far are of no use to anyone: a watch of its own keeps them from being written where the run is ended.
    let done = terminal::silently(|| super::run(&repeated.verb, &repeated.files, &Watch::default()));
    // A requirement that is not met ends a run after its result was written.
    if let (Err(Failure::Input(message)), _) | (Err(Failure::Criterion(message)), false) =
        (done, now.is_file())
    {
        return Err(Failure::Input(format!("the run could not be repeated: {message}")));
    }
    let (then, now): (Value, Value) =
        (serde_json::from_str(&read_text(then)?)?, serde_json::from_str(&read_text(now)?)?);
    let mut differences = Vec::new();
    compare("", &then, &now, &mut differences);
    Ok(differences)
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
}
