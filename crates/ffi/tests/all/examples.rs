//! The C and the C++ example, compiled with the system's compiler against the static and the shared library, and run.
//!
//! Skipped, and said so, where there is no compiler.

#![allow(
    clippy::unwrap_used,
    clippy::print_stdout,
    reason = "a test says what it skipped, and fails by panicking"
)]

use std::path::{Path, PathBuf};
use std::process::Command;
use truepose_kinematics::samples;

/// A compiler that this system has: what the variable names, or one of these.
fn compiler(variable: &str, usual: &[&'static str]) -> Option<String> {
    let named = std::env::var(variable).ok().into_iter();
    named
        .chain(usual.iter().map(ToString::to_string))
        .find(|name| Command::new(name).arg("--version").output().is_ok_and(|out| out.status.success()))
}

/// The folder of the static and the shared library, which cargo has built for this test and put beside it.
fn library() -> PathBuf {
    let here = std::env::current_exe().unwrap();
    let folder = here.parent().unwrap();
    assert!(folder.join("libtruepose_ffi.a").exists(), "no static library in {}", folder.display());
    folder.to_path_buf()
}

fn ran(command: &mut Command) -> String {
    let out = command.output().unwrap();
    let text = String::from_utf8_lossy(&out.stdout).into_owned() + &String::from_utf8_lossy(&out.stderr);
    assert!(out.status.success(), "{command:?}\n{text}");
    text
}

#[test]
fn the_examples_compile_and_run() {
    let c = compiler("CC", &["cc", "gcc", "clang"]);
    let cpp = compiler("CXX", &["c++", "g++", "clang++"]);
    if c.is_none() && cpp.is_none() {
        println!("SKIPPED: there is no C compiler; the examples of the C interface were not compiled");
        return;
    }
    let here = Path::new(env!("CARGO_MANIFEST_DIR"));
    let (include, examples) = (here.join("include"), here.join("../../examples/06_c_controller"));
    let built = library();
    let folder = tempfile::tempdir().unwrap();
    let fit = folder.path().join("fit.json");
    truepose_io::write_fit(&fit, &crate::fits::elastic(&samples::ur10())).unwrap();

    let warnings = ["-Wall", "-Wextra", "-Wpedantic", "-Werror", "-O1"];
    let system = ["-lpthread", "-ldl", "-lm"];
    match c {
        None => println!("SKIPPED: there is no C compiler; controller.c was not compiled"),
        Some(c) => {
            let program = folder.path().join("controller");
            ran(Command::new(&c)
                .args(warnings)
                .arg("-std=c99")
                .arg("-I")
                .arg(&include)
                .arg(examples.join("controller.c"))
                .arg(built.join("libtruepose_ffi.a"))
                .args(system)
                .arg("-o")
                .arg(&program));
            let text = ran(Command::new(&program).arg(&fit).arg("200"));
            assert!(text.contains("6 joints, 0 channels"), "{text}");
            assert!(text.contains("200 of 200 poses reached"), "{text}");
            assert!(text.contains("without a pose: a pointer that is required is null"), "{text}");
            let out = Command::new(&program).arg(include.join("truepose.h")).output().unwrap();
            assert_eq!(out.status.code(), Some(1));
            let text = String::from_utf8_lossy(&out.stderr).into_owned();
            assert!(text.contains("is not a fit file"), "{text}");
        }
    }
    match cpp {
        None => println!("SKIPPED: there is no C++ compiler; threads.cpp was not compiled"),
        Some(cpp) => {
            let program = folder.path().join("threads");
            let mut command = Command::new(&cpp);
            command.args(warnings).arg("-std=c++14").arg("-I").arg(&include);
            command.arg(examples.join("threads.cpp")).arg("-L").arg(&built).arg("-ltruepose_ffi");
            ran(command.arg(format!("-Wl,-rpath,{}", built.display())).args(system).arg("-o").arg(&program));
            let text = ran(Command::new(&program).arg(&fit));
            assert!(text.contains("2000 commands, 0 not reached; all threads agree"), "{text}");
        }
    }
}
