//! The program on Parquet files: the answers and the refusals of a CSV.

use crate::folder::{Folder, Run};
use std::path::Path;

/// The corpus, the table that it was made from, and its robot.
fn corpus() -> Folder {
    let folder = Folder::empty();
    let tests = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests");
    for name in ["good.parquet", "column_missing.parquet", "times.parquet"] {
        std::fs::copy(tests.join("parquet").join(name), folder.file(name)).unwrap();
    }
    for name in ["robot.toml", "good.csv"] {
        std::fs::copy(tests.join("spoiled").join(name), folder.file(name)).unwrap();
    }
    folder
}

fn identify<'a>(data: &'a str, more: &[&'a str]) -> Vec<&'a str> {
    [&["identify", "--robot", "robot.toml", "--data", data, "--folds", "4"], more].concat()
}

/// Without the lines of rows: a CSV has one more, its header.
fn without_lines(text: &str) -> String {
    let mut parts = text.split("line ");
    let first = parts.next().unwrap_or("").to_owned();
    parts.fold(first, |all, part| all + part.trim_start_matches(|c: char| c.is_ascii_digit()))
}

/// Exit code, errors and warnings of a run.
fn remarks(run: &Run) -> String {
    let warnings = run.out.lines().filter(|line| line.starts_with("warning: "));
    let all: Vec<&str> = run.log.lines().filter(|line| !line.starts_with("wrote ")).chain(warnings).collect();
    format!("[{}] {}", run.code.unwrap_or(-1), all.join("\n    "))
}

#[test]
fn the_answer_of_a_csv() {
    let folder = corpus();
    for more in [&[][..], &["--stream"]] {
        let csv = folder.run(&identify("good.csv", &[more, &["--out", "csv.json"]].concat()));
        let parquet = folder.run(&identify("good.parquet", &[more, &["--out", "parquet.json"]].concat()));
        assert_eq!((csv.code, parquet.code), (Some(0), Some(0)), "{}", remarks(&parquet));
        assert_eq!(
            without_lines(&csv.out.replace("csv", "parquet")),
            without_lines(&parquet.out),
            "{more:?}"
        );
        let written = |name: &str| std::fs::read_to_string(folder.file(name)).unwrap();
        assert_eq!(
            written("csv.json").replace("good.csv", "good.parquet"),
            written("parquet.json"),
            "{more:?}"
        );
    }
}

#[test]
fn what_is_wrong_is_reported() {
    let folder = corpus();
    let bytes = std::fs::read(folder.file("good.parquet")).unwrap();
    std::fs::write(folder.file("cut.parquet"), &bytes[..bytes.len() / 2]).unwrap();
    std::fs::create_dir(folder.file("folder.parquet")).unwrap();
    let mut said = String::new();
    for name in ["column_missing", "times", "cut", "folder"] {
        let name = format!("{name}.parquet");
        let run = folder.run(&identify(&name, &["--out", "out.json"]));
        assert_eq!(run.code, Some(2), "{name}");
        assert!(!folder.file("out.json").exists(), "{name}: a file was left behind");
        said += &format!("{}\n", remarks(&run));
    }
    insta::assert_snapshot!(said);
}
