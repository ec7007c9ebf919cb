//! What is around the program: options, outputs, streams, variables.

use super::{each, files, good, none, program, unsound};
use std::process::Stdio;

/// One run of each verb, without its outputs.
const VERBS: &[(&str, &str)] = &[
    ("identify --robot robot.toml --data data.csv --folds 0", "out.json"),
    ("discover --robot robot.toml --data data.csv --most 0 --flips 99", "out.json"),
    ("plan --fit fit.json --count 2 --pool 8", "out.csv"),
    ("predict --fit fit.json --data data.csv", "out.csv"),
    ("compensate --fit fit.json --poses poses.csv", "out.csv"),
    ("export --fit fit.json --format dh", "out.csv"),
    ("map --fit fit.json --points 2", "out.csv"),
    ("simulate --plant plant.toml", "out.csv"),
    ("transfer --fit fit.json --data data.csv", "out.json"),
    ("fleet fleet3.json fleet4.json fleet5.json fleet6.json", "out.json"),
    ("plan --fit fit.json --for monitor", "out.csv"),
    ("plan --for iso9283 --robot robot.toml", "out.csv"),
    ("identify --robot robot.toml --data data.csv --prior prior.json --folds 0", "out.json"),
];

/// Where an output cannot go, or should not; names of folders and links are made before.
const OUTPUTS: &[&str] = &[
    "robot.toml",
    "data.csv",
    "fit.json",
    "page",
    "page/",
    "no/out.csv",
    "data.csv/out",
    "/dev/full",
    "/proc/out",
    "/sys/out",
    "",
    ".",
    "..",
    "-",
    "ring",
    "dangling/out",
    "/dev/null/x",
    "\u{1b}[31m/x",
    "LONG",
];

/// Options that nobody means.
const OPTIONS: &[&str] = &[
    "identify --robot robot.toml --data data.csv --folds 1",
    "identify --robot robot.toml --data data.csv --folds 18446744073709551616",
    "identify --robot robot.toml --data data.csv --folds 1e9",
    "identify --robot robot.toml --data data.csv --folds 18446744073709551615",
    "identify --robot robot.toml --data data.csv --holdout nan",
    "identify --robot robot.toml --data data.csv --holdout inf",
    "identify --robot robot.toml --data data.csv --holdout 1",
    "identify --robot robot.toml --data data.csv --prior -1",
    "identify --robot robot.toml --data data.csv --prior nan",
    "identify --robot robot.toml --data data.csv --prior 1e-300",
    "identify --robot robot.toml --data data.csv --prior 1e300 --folds 0",
    "identify --robot robot.toml --data data.csv --rounds 0",
    "identify --robot robot.toml --data data.csv --repeat 0",
    "identify --robot robot.toml --data data.csv --fold-by j1",
    "identify --robot robot.toml --data data.csv --spec 0mm",
    "identify --robot robot.toml --data data.csv --spec nanmm",
    "identify --robot robot.toml --data data.csv --spec 1deg",
    "identify --robot robot.toml --data data.csv --require 1e-300m --folds 0",
    "identify --robot robot.toml --data data.csv --dwell-tolerance 1kg",
    "identify --robot robot.toml --data data.csv --dwell-tolerance 1e300deg --folds 0",
    "identify --robot robot.toml --data data.csv --base nowhere",
    "identify --robot robot.toml --data data.csv --tip nowhere",
    "identify --robot robot.toml --data data.csv --solver",
    "identify --robot robot.toml --data data.csv --solver nothing",
    "identify --robot robot.toml --data data.csv --solver qr(",
    "identify --robot robot.toml --data data.csv --solver svd(rcond=nan)",
    "identify --robot robot.toml --data data.csv --solver ridge(lambda=inf)",
    "identify --robot robot.toml --data data.csv --solver huber(huber(qr))",
    "identify --robot robot.toml --data data.csv --solver ridge(cv,folds=1e14) --folds 0",
    "identify --robot robot.toml --data data.csv --solver tukey(qr,starts=0) --folds 0",
    "identify --robot robot.toml --data data.csv --solver tukey(qr,keep=2)",
    "identify --robot robot.toml --data data.csv --solver lasso(count=0) --folds 0",
    "identify --robot robot.toml --data data.csv --solver svd(rcond=0.999999) --folds 0",
    "identify --robot robot.toml --robot robot.toml --data data.csv",
    "identify --robot data.csv --data robot.toml",
    "identify --robot fit.json --data fit.json",
    "identify",
    "discover --robot robot.toml --data data.csv --alpha 0",
    "discover --robot robot.toml --data data.csv --alpha nan",
    "discover --robot robot.toml --data data.csv --flips 0",
    "discover --robot robot.toml --data data.csv --holdout 0.99",
    "discover --robot robot.toml --data data.csv --nested 1",
    "plan --fit fit.json --count 0 --out out.csv",
    "plan --fit fit.json --count 2 --pool 0 --out out.csv",
    "plan --fit fit.json --loads nan --out out.csv",
    "plan --fit fit.json --loads 1e300 --count 2 --pool 8 --out out.csv",
    "plan --fit fit.json --com 1,2 --out out.csv",
    "plan --fit fit.json --com nan,0,0 --loads 1 --count 2 --pool 8 --out out.csv",
    "plan --fit fit.json --com 1e300,0,0 --loads 1 --count 2 --pool 8 --out out.csv",
    "plan --fit fit.json --rival fit.json --count 2 --pool 8 --out out.csv",
    "map --fit fit.json --points 0 --out out.csv",
    "map --fit fit.json --points 1 --out out.csv",
    "map --fit fit.json --payload nan --out out.csv",
    "map --fit fit.json --payload 1e300 --points 2 --out out.csv",
    "map --fit fit.json --target T9 --out out.csv",
    "map --fit fit.json --from 0mm,0mm,0mm --out out.csv",
    "map --fit fit.json --from 1e300m,0mm,0mm --to 0m,0m,0m --points 2 --out out.csv",
    "map --fit fit.json --from nanm,0mm,0mm --to 0m,0m,0m --out out.csv",
    "map --fit fit.json --from 0m,0m,0m --to 0m,0m,0m --points 2 --out out.csv",
    "map --fit fit.json --from 0m,0m,0m --to 1m,1m,1m --rpy nan,0,0 --out out.csv",
    "export --fit fit.json --format nothing --out out.csv",
    "export --fit fit.json --format iso230 --entries 1 --out out.csv",
    "export --fit fit.json --format dh --urdf arm.urdf --out out.csv",
    "export --fit fit.json --format urdf --urdf robot.toml --out out.urdf",
    "export --fit fit.json --format urdf --target NOBODY --out out.urdf",
    "simulate --plant plant.toml --seed -1 --out out.csv",
    "simulate --plant robot.toml --out out.csv",
    "simulate --plant data.csv --out out.csv",
    "compare --robot robot.toml --data data.csv --solver nothing",
    "compare --robot robot.toml --data data.csv --folds 0",
    "verify",
    "verify nothing.json",
    "verify fit.json",
    "verify page",
    "verify /dev/null",
    "verify data.csv",
    "check --robot nothing.toml",
    "check --robot page",
    "check --robot /dev/null",
    "check --robot /dev/zero",
    "check",
    "effects --nothing",
    "nothing",
    "",
    "--threads 0 effects",
    "--threads 99999 effects",
    "effects --time-limit nan",
    "effects --memory-limit 0GB",
    "predict --fit fit.json --data nothing.csv --out out.csv",
    "compensate --fit nothing.json --poses poses.csv --out out.csv",
    "predict --fit /dev/null --data data.csv --out out.csv",
    "monitor --fit fit.json --data data.csv --alpha nan",
    "monitor --fit fit.json --data data.csv --alpha 0",
    "monitor --fit fit.json --data data.csv --alpha 2",
    "monitor --fit fit.json --data data.csv --session nobody",
    "monitor --fit fit.json --data data.csv --history page",
    "monitor --fit fit.json --data data.csv --history data.csv",
    "monitor --fit prior.json --data nothing.csv",
    "monitor --fit data.csv --data fit.json",
    "transfer --fit fit.json --data two.csv --out fit.json",
    "transfer --fit fit.json --data /dev/null --out out.csv",
    "transfer --fit robot.toml --data data.csv --out out.csv",
    "fleet --out out.csv",
    "fleet fit.json --out out.csv",
    "fleet fit.json fit.json fit.json fit.json --out out.csv",
    "fleet fleet3.json fleet4.json fleet5.json fleet6.json --out fleet3.json",
    "fleet fleet3.json fleet4.json fleet5.json robot.toml --out out.csv",
    "iso9283 --data repeats.csv",
    "iso9283 --robot robot.toml --data repeats.csv --spec AP=0mm",
    "iso9283 --robot robot.toml --data repeats.csv --spec NO=1mm",
    "iso9283 --robot robot.toml --data repeats.csv --instrument nanmm",
    "iso9283 --robot robot.toml --data repeats.csv --align nowhere",
    "iso9283 --fit fit.json --session nobody --data repeats.csv",
    "plan --for nothing --robot robot.toml --out out.csv",
    "plan --for iso9283 --robot robot.toml --cycles 0 --out out.csv",
    "plan --for iso9283 --robot robot.toml --edge 1e300mm --out out.csv",
    "plan --for iso9283 --robot robot.toml --centre nanmm,0mm,0mm --out out.csv",
    "plan --for monitor --fit fit.json --count 0 --out out.csv",
    "identify --robot robot.toml --data data.csv --prior data.csv",
    "identify --robot robot.toml --data data.csv --prior fit.json",
    "compensate --fit heavy.json --program job.dat --with job.src --mark --limit nan --out out.csv",
    "compensate --fit heavy.json --program job.dat --language nothing --out out.csv",
    "compensate --fit fit.json --program job.dat --with job.src --out out.csv",
    "compensate --fit heavy.json --program job.dat --with nothing.src --out out.csv",
    "compensate --fit fit.json --poses poses.csv --frame nowhere --out out.csv",
    "compensate --fit fit.json --poses poses.csv --tcp nan,0,0,0,0,0 --out out.csv",
    "init nothing --out out.csv",
    "init --list --out out.csv --csv out.csv",
];

#[test]
fn options_that_nobody_means_are_refused() {
    let folder = good();
    let mut found = Vec::new();
    for words in OPTIONS {
        let list: Vec<&str> = words.split(' ').filter(|word| !word.is_empty()).collect();
        let before = files(&folder);
        let mut command = program(&folder, &[]);
        // Its own arguments come first, so that the wrong one is found.
        command = {
            let mut own = std::process::Command::new(command.get_program());
            own.current_dir(folder.path()).args(&list);
            own
        };
        let output = command.stdin(Stdio::null()).output().unwrap();
        // Usage errors have a form of their own: more lines below the one with the error.
        let usage =
            output.status.code() == Some(2) && String::from_utf8_lossy(&output.stderr).contains("Usage: ");
        if !usage {
            let problem = unsound(&output, &["out.csv", "out.urdf"], &before, &folder);
            found.extend(problem.map(|problem| format!("{words}: {problem}")));
        }
        for name in ["out.csv", "out.urdf"] {
            let _ = std::fs::remove_file(folder.file(name));
        }
    }
    none(found, OPTIONS.len(), 120);
}

#[test]
fn outputs_that_cannot_be_written_leave_nothing() {
    let long = "x".repeat(300);
    let (found, cases) = each(VERBS, |(verb, _), folder| {
        std::os::unix::fs::symlink("ring", folder.file("ring")).unwrap();
        std::os::unix::fs::symlink("nowhere", folder.file("dangling")).unwrap();
        let (mut found, mut cases) = (Vec::new(), 0);
        for out in OUTPUTS {
            let out = if *out == "LONG" { &long } else { *out };
            // Only a file that the verb reads is an input.
            if ["robot.toml", "data.csv", "fit.json"].contains(&out)
                && !verb.contains(out)
                && !verb.contains("plant")
            {
                continue;
            }
            if verb.contains("plant") && ["data.csv", "fit.json"].contains(&out) {
                continue;
            }
            cases += 1;
            let words: Vec<&str> = verb.split(' ').chain(["--out", out]).collect();
            let (before, kept) =
                (files(folder), ["robot.toml", "data.csv", "fit.json"].map(|f| folder.read(f)));
            let output = program(folder, &words).output().unwrap();
            let problem = match output.status.code() {
                Some(0) => Some("success".to_owned()),
                _ => unsound(&output, &[], &before, folder),
            };
            found.extend(problem.map(|problem| format!("{}: {problem}", words.join(" "))));
            assert_eq!(["robot.toml", "data.csv", "fit.json"].map(|f| folder.read(f)), kept, "{words:?}");
        }
        (found, cases)
    });
    none(found, cases, 120);
}

#[test]
fn streams_and_variables_change_no_result() {
    let (found, cases) = each(VERBS, |(verb, out), folder| {
        let (mut found, mut cases) = (Vec::new(), 0);
        let words: Vec<&str> = verb.split(' ').chain(["--out", out]).collect();
        assert!(program(folder, &words).output().unwrap().status.success(), "{words:?}");
        let whole = folder.read(out);
        let quoted = |redirect: &str| format!("exec \"$0\" \"$@\" {redirect}");
        let shells = [
            quoted(">&-"),
            quoted("2>&-"),
            quoted("<&-"),
            quoted(">&- 2>&- <&-"),
            quoted(">/dev/full"),
            "\"$0\" \"$@\" | true".to_owned(),
            "umask 777; exec \"$0\" \"$@\"".to_owned(),
        ];
        let variables: [&[(&str, &str)]; 9] = [
            &[("HOME", "")],
            &[("HOME", "/nowhere")],
            &[("LC_ALL", "tr_TR.UTF-8")],
            &[("LC_ALL", "de_DE"), ("LC_NUMERIC", "de_DE")],
            &[("LANG", "\u{1b}")],
            &[("TMPDIR", "/nowhere")],
            &[("TERM", "nothing"), ("COLUMNS", "0")],
            &[("RUST_BACKTRACE", "full")],
            &[("RAYON_NUM_THREADS", "-3"), ("NO_COLOR", "")],
        ];
        let mut judge = |what: String, output: std::process::Output| {
            cases += 1;
            let code = output.status.code();
            // A result that cannot be printed, or a folder that cannot be used, may be refused; a file is whole or absent.
            let written = std::fs::read_to_string(folder.file(out)).ok();
            if !(matches!(code, Some(0 | 2))
                && written.as_ref().is_none_or(|text| *text == whole)
                && (code != Some(0) || written.is_some()))
            {
                found.push(format!(
                    "{verb} with {what}: {code:?} {}",
                    String::from_utf8_lossy(&output.stderr)
                ));
            }
            let _ = std::fs::remove_file(folder.file(out));
        };
        let _ = std::fs::remove_file(folder.file(out));
        for script in &shells {
            let mut command = std::process::Command::new("sh");
            command
                .current_dir(folder.path())
                .args(["-c", script, env!("CARGO_BIN_EXE_truepose")])
                .args(&words);
            judge(script.clone(), command.output().unwrap());
        }
        for set in variables {
            judge(format!("{set:?}"), program(folder, &words).envs(set.iter().copied()).output().unwrap());
        }
        judge("no variables".into(), program(folder, &words).env_clear().output().unwrap());
        (found, cases)
    });
    none(found, cases, 130);
}
