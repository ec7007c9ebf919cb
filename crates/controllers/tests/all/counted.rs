//! Every motion statement that another counter finds is read with its points, or refused by its line: none is passed over in silence.
//!
//! `tests/corpus` has programs in the styles of pendants and offline tools; `count_motions.py` counts by the lists of the manuals.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::Command;
use truepose_controllers::{Dialect, Program};

fn corpus() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/corpus")
}

/// Programs by their names: `=== name`, then the text.
fn programs(dialect: Dialect) -> Vec<(String, String)> {
    let text = std::fs::read_to_string(corpus().join(format!("{}.txt", dialect.word()))).expect("a corpus");
    let one = |part: &str| part.split_once('\n').map(|(name, text)| (name.to_owned(), text.to_owned()));
    text.split("=== ").skip(1).filter_map(one).collect()
}

/// Lines by program; none without Python.
fn counted(dialect: Dialect) -> Option<BTreeMap<String, Vec<usize>>> {
    let run = Command::new("python3")
        .arg(corpus().join("count_motions.py"))
        .arg(corpus().join(format!("{}.txt", dialect.word())))
        .output()
        .ok()?;
    assert!(run.status.success(), "{}", String::from_utf8_lossy(&run.stderr));
    // `{"name": [1, 2], …}`
    let text = String::from_utf8(run.stdout).expect("text");
    let one = |part: &str| {
        let (name, lines) = part.split_once("\": [")?;
        let lines = lines.trim_end_matches([']', '}', '\n']).split(", ").filter(|line| !line.is_empty());
        Some((
            name.trim_start_matches(['{', '"']).to_owned(),
            lines.map(|line| line.parse().expect("a line")).collect(),
        ))
    };
    Some(text.split("], \"").filter_map(one).collect())
}

#[test]
fn no_motion_is_passed_over_in_silence() {
    let mut silent = Vec::new();
    for dialect in Dialect::ALL {
        let Some(counted) = counted(dialect) else {
            eprintln!("SKIPPED: no python3");
            return;
        };
        let all = programs(dialect);
        assert_eq!(counted.keys().collect::<Vec<_>>().len(), all.len());
        assert!(all.iter().filter(|(name, _)| !name.ends_with(".dat")).count() >= 10, "{dialect:?}");
        let (mut motions, mut refused) = (0, 0);
        for (name, text) in &all {
            let stem = |name: &str| name.split('.').next().map(str::to_owned);
            let others: Vec<&[u8]> = all
                .iter()
                .filter(|(other, _)| other != name && stem(other) == stem(name))
                .map(|(_, text)| text.as_bytes())
                .collect();
            let program = match Program::read(text.as_bytes(), &others, dialect) {
                Ok(program) => program,
                Err(error) => panic!("{name}: {error}"),
            };
            let noted = |line: usize| program.notes().iter().any(|note| note.file == 0 && note.line == line);
            for &line in &counted[name] {
                motions += 1;
                let mut visits = program.motions().filter(|(at, _)| *at == line).peekable();
                let reached = visits.peek().is_some() && visits.any(|(_, points)| !points.is_empty());
                refused += usize::from(noted(line));
                // A point of another file is that file's.
                let elsewhere = !others.is_empty() && program.motions().any(|(at, _)| at == line);
                if !(reached || noted(line) || elsewhere) {
                    let shown = text.lines().nth(line - 1).unwrap_or("");
                    silent.push(format!("{dialect:?} {name}:{line}: {shown}"));
                }
            }
        }
        println!("{dialect:?}: {} programs, {motions} motions, {refused} refused by line", all.len());
        assert!(motions > 20, "{dialect:?}");
    }
    assert!(silent.is_empty(), "{} motions in silence:\n{}", silent.len(), silent.join("\n"));
}
