//! Each kind of file, spoiled in every way; streams and variables around each verb.

use super::table::{files, run, table};
use super::{changes, none, unsound};
use rayon::prelude::*;

const OUTPUTS: &[&str] = &[
    "out.json",
    "out.csv",
    "out.urdf",
    "out.yaml",
    "out.dat",
    "out.dat.corrections.csv",
    "out.mod",
    "out.mod.corrections.csv",
    "out.ls",
    "out.ls.corrections.csv",
    "out.script",
    "out.script.corrections.csv",
    "sheet",
];

/// One in this many pairs, of a file and a way to spoil it or of a verb and a shell, is tested: each of them is in some pair. The slow tests
/// have all pairs.
const PART: usize = if cfg!(feature = "slow") { 1 } else { 7 };

#[test]
fn every_kind_of_file_spoiled_in_every_way_is_read_or_refused() {
    let table = table();
    let run_kind = |(kind, (file, commands)): (usize, &(String, Vec<String>))| {
        let folder = table.folder("good");
        let text = std::fs::read(folder.file(file)).unwrap();
        let (above, name) = file.rsplit_once('/').unwrap_or((".", file));
        let bad = format!("{above}/bad.{}", name.rsplit_once('.').unwrap().1);
        let mut found = Vec::new();
        for (k, spoil) in table.spoils.iter().enumerate().filter(|(k, _)| (k + kind).is_multiple_of(PART)) {
            let how: Vec<&str> = spoil[1..].iter().map(String::as_str).collect();
            let spoiled = changes::changed(&text, &how).unwrap_or_else(|| panic!("{spoil:?} of {file}"));
            std::fs::write(folder.file(&bad), spoiled).unwrap();
            let line = format!("{} --time-limit 20s --threads 1", commands[k % commands.len()]);
            let before = files(&folder, false);
            let ended = run(&folder, &line, None, None, 60);
            let problem = unsound(&ended, OUTPUTS, &before, &files(&folder, false));
            found.extend(problem.map(|problem| format!("{line} with {}: {problem}", spoil[0])));
            for name in OUTPUTS {
                let _ = std::fs::remove_file(folder.file(name));
            }
            let _ = std::fs::remove_dir_all(folder.file("sheet"));
        }
        found
    };
    let found = table.kinds.par_iter().enumerate().flat_map(run_kind).collect();
    none(found, table.kinds.len() * table.spoils.len() / PART, 1955 / PART);
}

#[test]
fn streams_and_variables_change_no_result() {
    let table = table();
    let run_verb = |(verb, (line, out)): (usize, &(String, String))| {
        let folder = table.folder("good");
        let line = format!("{line} --out {out} --time-limit 20s --threads 1");
        let ended = run(&folder, &line, None, None, 60);
        assert_eq!(ended.code, Some(0), "{line}: {}", ended.log);
        let whole = folder.read(out);
        let mut found = Vec::new();
        for (_, shell) in table.shells.iter().enumerate().filter(|(k, _)| (k + verb).is_multiple_of(PART)) {
            std::fs::remove_file(folder.file(out)).unwrap_or_default();
            let ended = run(&folder, &line, Some(shell), None, 60);
            // A result that cannot be printed, or a folder that cannot be used, may be refused; a file is whole or absent.
            let written = std::fs::read_to_string(folder.file(out)).ok();
            let right = match ended.code {
                Some(0) => written.as_ref() == Some(&whole),
                Some(2) => written.is_none_or(|text| text == whole),
                _ => false,
            };
            found.extend((!right).then(|| format!("{line} with {shell}: {:?} {}", ended.code, ended.log)));
        }
        found
    };
    let found = table.verbs.par_iter().enumerate().flat_map(run_verb).collect();
    none(found, table.verbs.len() * table.shells.len() / PART, 221 / PART);
}
