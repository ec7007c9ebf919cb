//! The program prints what its README shows.

use std::process::Command;

#[test]
fn the_program_finds_the_encoder_gain() -> Result<(), Box<dyn std::error::Error>> {
    let ran = Command::new(env!("CARGO_BIN_EXE_truepose-example-downstream")).output()?;
    assert!(ran.status.success());
    let out = String::from_utf8(ran.stdout)?;
    let figures: Vec<f64> = out
        .lines()
        .filter(|line| line.starts_with("  "))
        .filter_map(|line| line.split_whitespace().last()?.parse().ok())
        .collect();
    let [drawn, constants, both] = figures[..] else { panic!("{out}") };
    assert!(drawn > 2.0 * constants, "{out}");
    // With the effect of its own the model is the arm: what is left is rounding, shown to 0.1 µm.
    assert!(constants > 0.1 && both < 1e-3, "{out}");
    assert!(out.contains("gain of q1: 0.500 mrad/rad (built: 0.500)"), "{out}");
    let readme = include_str!("../README.md");
    for line in out.lines() {
        assert!(readme.contains(line), "the README does not show: {line}");
    }
    Ok(())
}
