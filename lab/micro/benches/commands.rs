//! Speed of commands: `cargo xtask micro commands`. Totals are the thread's own time; single calls are
//! on the wall, each the best of three: on a busy machine the slowest of one would be the scheduler's.
//! An elastic 6R arm, random poses, from the nominal solution.

#![allow(clippy::print_stdout)] // it is what a benchmark is for

use std::hint::black_box;
use std::time::Instant;
use truepose_compensate::{CommandRequest, Compensator, CompensatorOptions, Status};
use truepose_errormodel::Schema;
use truepose_kinematics::{Chain, Conditions, PostureBuffer, joint_jacobian, samples};
use truepose_micro::clock::timed_on_thread;
use truepose_micro::{Draw, elastic, latencies, load, target_at};

const COUNT: usize = 100_000;
/// As the program takes them.
const CHUNK: usize = 64;

fn main() {
    if std::env::args().any(|a| a == "heavy") {
        return run(&samples::heavy(), "0.1 µm", 1e-7, true);
    }
    for chain in [samples::heavy(), samples::ur10(), samples::seven()] {
        for (words, tolerance) in [("0.1 µm", 1e-7), ("0.1 nm", 1e-10)] {
            run(&chain, words, tolerance, true);
        }
        run(&chain, "0.1 µm", 1e-7, false);
    }
}

/// The smallest singular value of the joint Jacobian is above 0.05.
fn regular(chain: &Chain, conditions: &Conditions) -> bool {
    let mut buffer = PostureBuffer::new(chain);
    let posture = buffer.update(chain, conditions);
    let jacobian = joint_jacobian(&posture, &posture.tool().translation.clone());
    let gram = &jacobian * jacobian.transpose();
    gram.symmetric_eigenvalues().min() > 0.05 * 0.05
}

fn run(chain: &Chain, words: &str, tolerance: f64, seeded: bool) {
    let fit = elastic(chain, 5);
    let schema = Schema { load: true, ..Schema::default() };
    let options = CompensatorOptions {
        position_tolerance: tolerance,
        orientation_tolerance: tolerance,
        ..CompensatorOptions::default()
    };
    let mut compensator = Compensator::bind(&fit, &schema, options).expect("bound");
    let mut draw = Draw(1);
    let count = if seeded { COUNT } else { COUNT / 10 };
    let mut jobs = Vec::with_capacity(count);
    while jobs.len() < count {
        // Nominal poses, well away from singularities, as the peers' workload has them.
        let conditions = Conditions::at(chain, &draw.joints(chain, 0.9));
        if !regular(chain, &conditions) {
            continue;
        }
        let loaded = jobs.len() % 2 == 1;
        let conditions = if loaded { conditions.with_load(load(chain)) } else { conditions };
        jobs.push((target_at(&chain.forward(&conditions.joints)), conditions));
    }
    let mut best = f64::INFINITY;
    let mut singles = vec![0.0; count];
    let (mut ok, mut rounds) = (0, 0);
    for _ in 0..5 {
        (ok, rounds) = (0, 0);
        let (seconds, ()) = timed_on_thread(|| {
            for (wanted, conditions) in &jobs {
                let seed = seeded.then_some(&conditions.joints[..]);
                let command = black_box(compensator.command(wanted, conditions, seed));
                ok += usize::from(command.status == Status::Ok);
                rounds += command.rounds;
            }
        });
        best = best.min(seconds);
    }
    let list: Vec<CommandRequest<'_>> = jobs
        .iter()
        .map(|(target, conditions)| CommandRequest {
            target: *target,
            conditions,
            seed: seeded.then_some(&conditions.joints[..]),
        })
        .collect();
    let (mut together, mut answers) = (f64::INFINITY, Vec::with_capacity(CHUNK));
    for _ in 0..5 {
        let (seconds, ()) = timed_on_thread(|| {
            for chunk in list.chunks(CHUNK) {
                answers.clear();
                compensator.commands(black_box(chunk), &mut answers);
                black_box(&answers);
            }
        });
        together = together.min(seconds);
    }
    for ((wanted, conditions), single) in jobs.iter().zip(&mut singles) {
        let seed = seeded.then_some(&conditions.joints[..]);
        // The best of three: what the scheduler takes is not the call's.
        *single = f64::INFINITY;
        for _ in 0..3 {
            let begun = Instant::now();
            black_box(compensator.command(wanted, conditions, seed));
            *single = single.min(begun.elapsed().as_secs_f64());
        }
    }
    let [median, most, _] = latencies(singles);
    println!(
        "{:6} {words} {}: {:.3} s per 100 000, {:.3} s as a list, {ok} of {count} ok, {:.2} rounds; single calls: median {median:.2} µs, 99.9 % {most:.1} µs",
        chain.name(),
        if seeded { "from a seed " } else { "without seed" },
        best * COUNT as f64 / count as f64,
        together * COUNT as f64 / count as f64,
        rounds as f64 / count as f64,
    );
}
