//! How much of the libraries the tests run: `cargo xtask coverage`.
//!
//! The crates of the workspace are compiled with counters (`-C instrument-coverage`) in the usual target folder, their dependencies as they
//! are: this program stands in for rustc, which cargo lets it do for members alone. Tests write their counters to `target/coverage`, and the
//! tools of the toolchain (`rustup component add llvm-tools`), or those in the folder `TRUEPOSE_LLVM`, of the same version of LLVM, sum them up. What is told is the part of the lines of each library that any
//! test has run; tests themselves, and programs for developers, are left out.

use crate::finished;
use anyhow::{Context, Result, bail};
use std::collections::BTreeMap;
use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode};

/// Set in the environment of the compiler that this program stands in for.
const STANDS_IN: &str = "TRUEPOSE_COVERAGE";

/// Crates whose figures are not told: programs for developers.
const LEFT_OUT: [&str; 2] = ["bench", "studies"];

/// What rustc does, with counters; none where this is not asked for.
pub fn compiler() -> Option<ExitCode> {
    std::env::var_os(STANDS_IN)?;
    let mut arguments = std::env::args_os().skip(1);
    let status = Command::new(arguments.next()?).args(arguments).arg("-Cinstrument-coverage").status();
    Some(match status {
        Ok(status) if status.success() => ExitCode::SUCCESS,
        _ => ExitCode::FAILURE,
    })
}

/// Runs the tests of these packages (all where none is named), and tells what they have run.
pub fn run(root: &Path, packages: &[String]) -> Result<()> {
    let folder = root.join("target/coverage");
    if folder.exists() {
        std::fs::remove_dir_all(&folder)?;
    }
    std::fs::create_dir_all(&folder)?;
    let tools = tools()?;
    let chosen: Vec<&str> = match packages {
        [] => vec!["--workspace"],
        some => some.iter().flat_map(|package| ["--package", package]).collect(),
    };
    let test = |more: &[&str]| -> Result<Command> {
        let mut command = Command::new("cargo");
        command
            .arg("test")
            .args(&chosen)
            .args(more)
            .current_dir(root)
            .env("RUSTC_WORKSPACE_WRAPPER", std::env::current_exe()?)
            .env(STANDS_IN, "1")
            .env("CARGO_INCREMENTAL", "0")
            .env("LLVM_PROFILE_FILE", folder.join("%4m.profraw"));
        Ok(command)
    };
    let built = test(&["--no-run", "--message-format=json"])?.output().context("cargo test --no-run")?;
    if !built.status.success() {
        bail!("the tests do not build: {}", String::from_utf8_lossy(&built.stderr));
    }
    let binaries = binaries(&String::from_utf8_lossy(&built.stdout));
    if let Err(error) = finished(&mut test(&["--no-fail-fast"])?) {
        println!("── the lines of failing tests count all the same: {error}");
    }
    let raw = std::fs::read_dir(&folder)?.filter_map(|entry| Some(entry.ok()?.path().into_os_string()));
    let merged = folder.join("all.profdata");
    let list = folder.join("list.txt");
    let names: Vec<String> = raw.map(|name| name.to_string_lossy().into_owned()).collect();
    std::fs::write(&list, names.join("\n"))?;
    let merge = ["merge", "--sparse", "-f"];
    finished(Command::new(tools.join("llvm-profdata")).args(merge).arg(&list).arg("-o").arg(&merged))?;
    let mut export = Command::new(tools.join("llvm-cov"));
    export.args(["export", "--summary-only", "--instr-profile"]).arg(&merged);
    for (k, binary) in binaries.iter().enumerate() {
        if k > 0 {
            export.arg("--object");
        }
        export.arg(binary);
    }
    let told = export.output().context("llvm-cov")?;
    if !told.status.success() {
        bail!("llvm-cov: {}", String::from_utf8_lossy(&told.stderr));
    }
    let told: serde_json::Value = serde_json::from_slice(&told.stdout)?;
    std::fs::write(folder.join("files.json"), serde_json::to_string_pretty(&told)?)?;
    let files = lines(&told, root);
    print!("{}", table(&files));
    println!("\nfiles: {}", folder.join("files.json").display());
    Ok(())
}

/// The folder of the toolchain's tools.
fn tools() -> Result<PathBuf> {
    if let Some(folder) = std::env::var_os("TRUEPOSE_LLVM").map(PathBuf::from) {
        if !folder.join("llvm-cov").exists() {
            bail!("TRUEPOSE_LLVM: there is no llvm-cov in {}", folder.display());
        }
        return Ok(folder);
    }
    let said = |arguments: &[&str]| -> Result<String> {
        let output = Command::new("rustc").args(arguments).output().context("rustc")?;
        Ok(String::from_utf8(output.stdout)?)
    };
    let version = said(&["-vV"])?;
    let host = version.lines().find_map(|line| line.strip_prefix("host: ")).context("rustc tells no host")?;
    let folder =
        PathBuf::from(said(&["--print", "sysroot"])?.trim()).join("lib/rustlib").join(host).join("bin");
    if !folder.join("llvm-cov").exists() {
        bail!(
            "the toolchain has no llvm-cov: rustup component add llvm-tools, or TRUEPOSE_LLVM=FOLDER with those of the LLVM that rustc -vV tells"
        );
    }
    Ok(folder)
}

/// Programs and tests that cargo has made.
fn binaries(messages: &str) -> Vec<OsString> {
    let parsed = messages.lines().filter_map(|line| serde_json::from_str::<serde_json::Value>(line).ok());
    let mut all: Vec<OsString> =
        parsed.filter_map(|message| Some(message["executable"].as_str()?.into())).collect();
    all.sort();
    all.dedup();
    all
}

/// (Lines, lines that were run) of each source file of a library, by its path from the root.
fn lines(told: &serde_json::Value, root: &Path) -> BTreeMap<String, (u64, u64)> {
    let files = told["data"][0]["files"].as_array().into_iter().flatten();
    let own = files.filter_map(|file| {
        let name = Path::new(file["filename"].as_str()?).strip_prefix(root).ok()?.to_str()?.to_owned();
        let summary = &file["summary"]["lines"];
        let (crates, rest) = name.strip_prefix("crates/")?.split_once('/')?;
        let wanted = rest.starts_with("src/") && !LEFT_OUT.contains(&crates);
        wanted.then_some((name.clone(), (summary["count"].as_u64()?, summary["covered"].as_u64()?)))
    });
    own.collect()
}

/// A line for each crate, the whole, and the files with the most lines that no test runs.
fn table(files: &BTreeMap<String, (u64, u64)>) -> String {
    let part = |(count, covered): (u64, u64)| 100.0 * covered as f64 / count.max(1) as f64;
    let mut crates: BTreeMap<&str, (u64, u64)> = BTreeMap::new();
    for (name, (count, covered)) in files {
        let sum = crates.entry(name.split('/').nth(1).unwrap_or_default()).or_default();
        *sum = (sum.0 + count, sum.1 + covered);
    }
    let row = |name: &str, sum: (u64, u64)| format!("{name:14} {:6} lines {:5.1} %\n", sum.0, part(sum));
    let whole = crates.values().fold((0, 0), |a, b| (a.0 + b.0, a.1 + b.1));
    let mut out: String = crates.iter().map(|(name, sum)| row(name, *sum)).collect();
    out += &row("all", whole);
    let mut worst: Vec<_> = files.iter().map(|(name, (count, covered))| (count - covered, name)).collect();
    worst.sort_by(|a, b| b.cmp(a));
    out += "\nlines that no test runs:\n";
    out + &worst.iter().take(15).map(|(left, name)| format!("{left:6} {name}\n")).collect::<String>()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_are_summed_by_crate_without_tests_and_studies() {
        let file = |name: &str, count: u64, covered: u64| serde_json::json!({"filename": format!("/w/{name}"), "summary": {"lines": {"count": count, "covered": covered}}});
        let files = [
            file("crates/io/src/a.rs", 10, 9),
            file("crates/io/src/b/c.rs", 30, 11),
            file("crates/io/tests/all.rs", 100, 0),
            file("crates/studies/src/main.rs", 100, 0),
            file("crates/cli/src/lib.rs", 4, 4),
        ];
        let told = serde_json::json!({"data": [{"files": files}]});
        let lines = lines(&told, Path::new("/w"));
        assert_eq!(lines.len(), 3);
        let table = table(&lines);
        assert!(table.contains("io                 40 lines  50.0 %\n"), "{table}");
        assert!(table.contains("all                44 lines  54.5 %\n"), "{table}");
        assert!(table.contains("    19 crates/io/src/b/c.rs\n"), "{table}");
    }
}
