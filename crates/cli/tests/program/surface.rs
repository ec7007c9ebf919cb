//! Completions, the manual page, quiet runs, colours.

use crate::folder::Folder;

#[test]
fn completions_and_the_manual_know_every_verb() {
    let folder = Folder::empty();
    let help = folder.run("--help").ended(0).out;
    assert!(!help.contains("completions"), "{help}");
    for shell in ["bash", "zsh", "fish", "powershell", "elvish", "man"] {
        let run = folder.run(&["completions", shell]).ended(0);
        assert_eq!(run.log, "", "{shell}");
        for word in ["identify", "compensate", "verify"] {
            assert!(run.out.contains(word), "{shell}: no {word}");
        }
    }
    let manual = folder.run("completions man").ended(0).out;
    assert!(manual.starts_with(".ie") || manual.contains(".TH truepose 1"), "{}", &manual[..200]);
    folder.run("completions tcsh").ended(2);
}

#[test]
fn quiet_leaves_out_remarks_and_keeps_results_and_errors() {
    let folder = Folder::with_data();
    let identify = ["identify", "--robot", "robot.toml", "--data", "data.csv", "--out", "fit.json"];
    let plain = folder.run(&identify).ended(0);
    let quiet = folder.run(&[&identify[..], &["--quiet"]].concat()).ended(0);
    assert!(plain.log.contains("wrote fit.json"), "{}", plain.log);
    assert_eq!((quiet.log.as_str(), quiet.out), ("", plain.out));
    let failed = folder.run("--quiet identify --robot robot.toml --data none.csv").ended(2);
    assert!(failed.log.starts_with("error: none.csv"), "{}", failed.log);
    // No terminal, no colours.
    assert!(!failed.log.contains('\u{1b}') && !plain.log.contains('\u{1b}'));
}
