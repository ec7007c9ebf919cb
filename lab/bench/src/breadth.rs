//! How `discover` grows with joints and channels: arms of 3 to 30 joints, without channels and beside fifty thermometers of which none matters,
//! with a gear error in the middle joint that the model lacks.

use crate::workload::Failure;
use crate::{clock, say};
use std::fmt::Write;
use truepose_discover::{DiscoverOptions, diagnose};
use truepose_errormodel::effects::Geometric;
use truepose_errormodel::{AnyEffect, Channel, Dataset};
use truepose_io::{RobotOptions, robot_from_text};
use truepose_simulate::PlantDescription;
use truepose_solvers::PivotedQr;

const JOINTS: [usize; 4] = [3, 6, 12, 30];
const CHANNELS: [usize; 2] = [0, 50];
const POSES: usize = 2_000;

/// Measures, searches and prints one after the other.
pub fn run(most: usize, threads: usize) -> Result<(), Failure> {
    let load = clock::load();
    for joints in JOINTS.into_iter().filter(|joints| *joints <= most) {
        for channels in CHANNELS {
            say(&one(joints, channels)?);
        }
    }
    let (processor, after) = (clock::processor(), clock::load());
    say(&format!("{processor}, {threads} threads; load {load:.1} at the beginning, {after:.1} at the end"));
    Ok(())
}

fn one(joints: usize, channels: usize) -> Result<String, Failure> {
    let (chain, _) = robot_from_text("snake.toml", &snake(joints)?, &RobotOptions::default())?;
    let hidden = format!("j{}", joints / 2 + 1);
    let plant = format!(
        "seed = 1\n[campaign]\nvisits = {POSES}\nvisit_s = 30\n[errors.geometric]\nposition_mm = 0.3\nangle_mrad = 0.3\n\
         [[errors.transmission]]\njoint = \"{hidden}\"\namplitude_mrad = 0.3\ncycles = 3\n\
         [instrument]\nsd_um = 20\n"
    );
    let description = PlantDescription::from_toml(&plant)?;
    let seed = description.seed;
    let mut data = description.plant(&chain)?.measure(&description.campaign.on(&chain, seed)?, seed)?;
    wander(&mut data, channels);
    let declared: Vec<Box<dyn AnyEffect>> = vec![Box::new(Geometric::default())];
    let (solver, options) = (PivotedQr::default(), DiscoverOptions::default());
    let (cpu, wall, found) = clock::timed(|| diagnose(&chain, &declared, &data, &solver, &options, &|_| ()));
    let names: Vec<String> = found?.findings.iter().map(|finding| finding.candidate.words()).collect();
    // The largest comes last, so that the peak of the process is mostly that of the run before it.
    Ok(format!(
        "{joints:>3} joints, {channels:>2} channels: {cpu:.1} s CPU, {wall:.1} s, {:.0} MB; hidden in {hidden}: {}",
        clock::memory_mb("VmHWM:"),
        if names.is_empty() { "nothing found".into() } else { names.join(", ") },
    ))
}

/// An arm whose axes are across each other in turn.
fn snake(joints: usize) -> Result<String, std::fmt::Error> {
    let mut text = "name = \"snake\"\n[units]\nlength = \"mm\"\nangle = \"deg\"\n".to_owned();
    for k in 0..joints {
        let (d, a, alpha) = (30 * (k % 3), 120 + 10 * (k % 4), [90, -90, 0][k % 3]);
        writeln!(
            text,
            "[[joints]]\nname = \"j{}\"\ndh = {{ theta = 0, d = {d}, a = {a}, alpha = {alpha} }}\nlimits = [-85, 85]",
            k + 1
        )?;
    }
    Ok(text)
}

/// Temperatures that wander, each by itself.
fn wander(data: &mut Dataset, channels: usize) {
    let mut state = 0x9e37_79b9_u32;
    let mut step = || {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        0.2 * (f64::from(state >> 8) / f64::from(1_u32 << 24) - 0.5)
    };
    for channel in 0..channels {
        let mut at = 20.0;
        let column = (0..data.len()).map(|_| {
            at += step();
            at
        });
        data.channels.push(column.collect());
        let (name, unit) = (format!("T{}", channel + 1), "degC".into());
        data.schema.channels.push(Channel { name, unit, temperature: true });
    }
}
