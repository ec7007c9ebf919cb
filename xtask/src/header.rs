//! The header of the C interface: made by cbindgen from `crates/ffi`, and compared with the one in the repository.

use anyhow::{Context, Result, bail};
use std::path::Path;
use std::process::Command;

const VERSION: &str = "0.29.4";
const HEADER: &str = "crates/ffi/include/truepose.h";

/// Compares the header, or writes it. Without cbindgen, which is built into target/tools once, that is said and is no failure.
pub fn run(root: &Path, write: bool) -> Result<()> {
    let Some(cbindgen) = tool(root) else {
        println!("── SKIPPED: cbindgen is not installed, and could not be; the C header was not compared");
        return Ok(());
    };
    let made = Command::new(cbindgen)
        .args(["--quiet", "--config", "crates/ffi/cbindgen.toml", "crates/ffi"])
        .current_dir(root)
        .output()
        .context("cannot start cbindgen")?;
    if !made.status.success() {
        bail!("cbindgen: {}", String::from_utf8_lossy(&made.stderr));
    }
    let file = root.join(HEADER);
    if write {
        return std::fs::write(&file, &made.stdout).context(HEADER);
    }
    if std::fs::read(&file).context(HEADER)? != made.stdout {
        bail!("{HEADER} is not what cbindgen makes of crates/ffi; run `cargo xtask header --write`");
    }
    println!("{HEADER} is what cbindgen makes of crates/ffi");
    Ok(())
}

/// cbindgen of this version, installed or built.
fn tool(root: &Path) -> Option<String> {
    let built = root.join("target/tools/bin/cbindgen").to_string_lossy().into_owned();
    let known = || ["cbindgen", &built].into_iter().find(|name| right(name)).map(String::from);
    known().or_else(|| {
        let installed = Command::new("cargo")
            .args(["install", "--locked", "--debug", "--root", "target/tools"])
            .args(["--target-dir", "target/tools/build-cbindgen"])
            .arg(format!("cbindgen@{VERSION}"))
            .env("CARGO_PROFILE_DEV_DEBUG", "0")
            .current_dir(root)
            .status();
        let _ = std::fs::remove_dir_all(root.join("target/tools/build-cbindgen"));
        installed.is_ok_and(|status| status.success()).then(known).flatten()
    })
}

fn right(name: &str) -> bool {
    let shown = Command::new(name).arg("--version").output();
    shown.is_ok_and(|out| String::from_utf8_lossy(&out.stdout).trim() == format!("cbindgen {VERSION}"))
}
