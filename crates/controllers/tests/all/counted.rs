//! Every motion statement that another counter finds is read with its points, or refused by its line: none is passed over in silence.
//!
//! `tests/corpus` has programs in the styles of pendants and offline tools; `count_motions.py` counts by the lists of the manuals.

use std::collections::{BTreeMap, BTreeSet};
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
fn counted(path: &Path) -> Option<BTreeMap<String, Vec<usize>>> {
    let run = Command::new("python3").arg(corpus().join("count_motions.py")).arg(path).output().ok()?;
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

/// What became of the motions of some programs.
pub struct Tally {
    pub motions: usize,
    /// Motions that are neither read nor refused.
    pub silent: Vec<String>,
    /// Of each program the lines that reach a point, and those that are refused.
    pub lines: Vec<(BTreeSet<usize>, BTreeSet<usize>)>,
}

/// Programs against the lines that the counter finds in their file; none without Python.
pub fn held(dialect: Dialect, path: &Path, all: &[(String, String)]) -> Option<Tally> {
    let counted = counted(path)?;
    assert_eq!(counted.len(), all.len());
    let mut tally = Tally { motions: 0, silent: Vec::new(), lines: Vec::new() };
    for (name, text) in all {
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
        let noted: BTreeSet<usize> =
            program.notes().iter().filter(|note| note.file == 0).map(|note| note.line).collect();
        // A point of another file is that file's.
        let goes = |(_, points): &(usize, &[usize])| !points.is_empty() || !others.is_empty();
        let reached: BTreeSet<usize> = program.motions().filter(goes).map(|(line, _)| line).collect();
        for &line in &counted[name] {
            tally.motions += 1;
            if !(reached.contains(&line) || noted.contains(&line)) {
                let shown = text.lines().nth(line - 1).unwrap_or("");
                tally.silent.push(format!("in silence: {dialect:?} {name}:{line}: {shown}"));
            }
        }
        tally.lines.push((reached, noted));
    }
    Some(tally)
}

#[test]
fn no_motion_is_passed_over_in_silence() {
    let mut silent = Vec::new();
    for dialect in Dialect::ALL {
        let all = programs(dialect);
        assert!(all.iter().filter(|(name, _)| !name.ends_with(".dat")).count() >= 10, "{dialect:?}");
        let path = corpus().join(format!("{}.txt", dialect.word()));
        let Some(tally) = held(dialect, &path, &all) else {
            eprintln!("SKIPPED: no python3");
            return;
        };
        assert!(tally.motions > 20, "{dialect:?}");
        silent.extend(tally.silent);
    }
    assert!(silent.is_empty(), "{} motions:\n{}", silent.len(), silent.join("\n"));
}
