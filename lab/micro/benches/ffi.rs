//! Time of commands through the C interface beside the same through Rust, in turn: `cargo xtask micro ffi`.
//! Totals are of 100 000 commands, the best of five; single calls each the best of three (on a busy machine the slowest of one would be the
//! scheduler's). The C example prints the same from C.

#![allow(unsafe_code)]
#![allow(clippy::print_stdout, clippy::unwrap_used, reason = "it is what a benchmark is for")]
#![allow(clippy::undocumented_unsafe_blocks, reason = "every pointer here is of a local variable, or null")]

use std::hint::black_box;
use std::ptr::{null, null_mut};
use std::time::Instant;
use truepose_compensate::{Compensator, CompensatorOptions, Target};
use truepose_errormodel::Schema;
use truepose_ffi::*;
use truepose_kinematics::{Conditions, samples};
use truepose_micro::{elastic, latencies};

const COUNT: usize = 100_000;

fn main() {
    let fitted = elastic(&samples::ur10(), 5);
    let text = truepose_io::fit_json("fit.json", &fitted).unwrap();
    let (mut fit, mut arm) = (null_mut(), null_mut());
    unsafe {
        assert_eq!(truepose_fit_parse(text.as_ptr().cast(), text.len(), &mut fit), 0);
        assert_eq!(truepose_arm_new(fit, null(), &mut arm), 0);
    }
    let schema = Schema { load: true, time: true, approach: true, ..Schema::default() };
    let mut ours = Compensator::bind(&fitted, &schema, CompensatorOptions::default()).unwrap();
    let jobs: Vec<(Target, truepose_target, Conditions)> = (0..COUNT)
        .map(|n| {
            let middle = [0.3, -1.0, 0.9, 0.3, 0.3, 0.3];
            let q: Vec<f64> =
                (0..6).map(|k| middle[k] + 0.4 * (0.7 * n as f64 + 1.9 * k as f64).sin()).collect();
            let conditions = Conditions::at(fitted.chain(), &q);
            let pose = fitted.chain().forward(&q);
            let theirs = truepose_target {
                position: pose.translation.into(),
                quaternion: pose.quaternion(),
                has_orientation: 1,
                target: TRUEPOSE_TOOL,
            };
            (Target::at(pose.translation).turned(pose.rotation), theirs, conditions)
        })
        .collect();
    let mut rust = |(target, _, conditions): &(Target, truepose_target, Conditions)| {
        black_box(ours.command(black_box(target), conditions, Some(&conditions.joints)));
    };
    let c = |(_, target, conditions): &(Target, truepose_target, Conditions)| {
        let mut joints = [0.0; 6];
        let seed = conditions.joints.as_ptr();
        let code = unsafe {
            truepose_command(black_box(arm), target, null(), seed, joints.as_mut_ptr(), 6, null_mut())
        };
        assert!(black_box(code) == 0 && black_box(joints)[0].is_finite());
    };
    let mut totals = [f64::INFINITY; 2];
    let mut singles = [vec![f64::INFINITY; COUNT], vec![f64::INFINITY; COUNT]];
    for _ in 0..5 {
        for (side, total) in totals.iter_mut().enumerate() {
            let begun = Instant::now();
            jobs.iter().for_each(|job| if side == 0 { rust(job) } else { c(job) });
            *total = total.min(begun.elapsed().as_secs_f64());
        }
    }
    for _ in 0..3 {
        for (k, job) in jobs.iter().enumerate() {
            for (side, times) in singles.iter_mut().enumerate() {
                let begun = Instant::now();
                if side == 0 {
                    rust(job)
                } else {
                    c(job)
                }
                times[k] = times[k].min(begun.elapsed().as_secs_f64());
            }
        }
    }
    for (name, (total, times)) in ["Rust", "C   "].into_iter().zip(totals.into_iter().zip(singles)) {
        let [median, most, largest] = latencies(times);
        println!(
            "{name} {total:.3} s per 100 000; single calls: median {median:.2} µs, 99.9 % {most:.2} µs, largest {largest:.1} µs"
        );
    }
    println!("C / Rust: {:.3}", totals[1] / totals[0]);
    unsafe {
        truepose_arm_free(arm);
        truepose_fit_free(fit);
    }
}
