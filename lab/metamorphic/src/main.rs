#![doc = include_str!("../README.md")]
#![allow(clippy::unwrap_used, clippy::print_stdout, reason = "a program for developers")]

#[path = "../../../tests/metamorphic/mod.rs"]
mod metamorphic;

use metamorphic::case::Case;
use metamorphic::found::{Found, same_inputs};
use metamorphic::relations::{RELATIONS, Relation};
use serde_json::{Value, json};
use std::cell::OnceCell;
use std::collections::BTreeMap;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::time::Instant;
use truepose_discover::DiscoverOptions;

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let value = |key: &str| arguments.iter().position(|a| a == key).and_then(|k| arguments.get(k + 1));
    let cases = value("--cases").map_or_else(beside, PathBuf::from);
    let (only, relation) = (value("--only"), value("--relation"));
    let part = value("--part").map(|text| text.split_once('/').expect("a part, as in 1/2"));
    let (part, parts): (usize, usize) =
        part.map_or((1, 1), |(a, b)| (a.parse().unwrap(), b.parse().unwrap()));
    let Ok(entries) = std::fs::read_dir(&cases) else {
        println!("SKIPPED: {} is not there", cases.display());
        return;
    };
    let mut names: Vec<String> = entries
        .map(|entry| entry.unwrap())
        .filter(|entry| entry.path().join("declared.toml").exists())
        .map(|entry| entry.file_name().into_string().unwrap())
        .collect();
    names.sort();
    let journal = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../target/metamorphic.jsonl");
    let mut known = read(&journal);
    let wanted = names
        .iter()
        .enumerate()
        .filter(|(k, name)| k % parts == part - 1 && only.is_none_or(|word| name.contains(word.as_str())));
    for (_, name) in wanted {
        let text = |file: &str| std::fs::read_to_string(cases.join(name).join(file)).unwrap();
        let plain = Case::of(&text("robot.toml"), &text("declared.toml"), &text("train.csv"));
        let run = |relation: Option<&Relation>| {
            let mut case = plain.clone();
            relation.iter().for_each(|relation| (relation.change)(&mut case));
            let found = Found::of(&case, &DiscoverOptions::default());
            if arguments.iter().any(|a| a == "--show") {
                println!("{name}: {}: {found:#?}", relation.map_or("as it is", |relation| relation.name));
            }
            found
        };
        let missing = |relation: &str, known: &BTreeMap<(String, String), Value>| {
            !known.contains_key(&(name.clone(), relation.to_owned()))
        };
        let chosen = RELATIONS.iter().filter(|r| relation.is_none_or(|word| r.name.contains(word.as_str())));
        let chosen: Vec<&Relation> = chosen.filter(|r| missing(r.name, &known)).collect();
        if chosen.is_empty() {
            continue;
        }
        let reference = OnceCell::new();
        for relation in chosen {
            let began = Instant::now();
            let mut changed = plain.clone();
            (relation.change)(&mut changed);
            let differs = if same_inputs(&plain, &changed) {
                None
            } else {
                match run(Some(relation)) {
                    Ok(found) => reference.get_or_init(|| run(None).unwrap()).differs(&found, relation),
                    Err(words) => Some(words),
                }
            };
            let seconds = began.elapsed().as_secs_f64();
            let line =
                json!({"case": name, "relation": relation.name, "differs": differs, "seconds": seconds});
            let mut file = std::fs::OpenOptions::new().create(true).append(true).open(&journal).unwrap();
            writeln!(file, "{line}").unwrap();
            println!("{name}: {}: {}", relation.name, differs.as_deref().unwrap_or("holds"));
            known.insert((name.clone(), relation.name.to_owned()), line);
        }
    }
    table(&known);
}

fn beside() -> PathBuf {
    let named = std::env::var_os("TRUEPOSE_SHARED").map(PathBuf::from);
    named.unwrap_or_else(|| Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared")).join("cases")
}

/// Results by case and relation.
fn read(journal: &Path) -> BTreeMap<(String, String), Value> {
    let text = std::fs::read_to_string(journal).unwrap_or_default();
    let lines = text.lines().filter_map(|line| serde_json::from_str::<Value>(line).ok());
    let word = |value: &Value| value.as_str().unwrap().to_owned();
    lines.map(|line| ((word(&line["case"]), word(&line["relation"])), line)).collect()
}

fn table(known: &BTreeMap<(String, String), Value>) {
    println!("\n{:32} holds", "relation");
    let mut failures = String::new();
    for relation in &RELATIONS {
        let of = known.iter().filter(|((_, name), _)| name == relation.name);
        let (mut all, mut held) = (0, 0);
        for ((case, _), line) in of {
            all += 1;
            match line["differs"].as_str() {
                None => held += 1,
                Some(words) => failures += &format!("{}: {case}: {words}\n", relation.name),
            }
        }
        println!("{:32} {held} of {all}", relation.name);
    }
    print!("\n{failures}");
}
