//! Speed of commands: `cargo bench -p truepose-compensate`. An elastic 6R arm, random poses, from the nominal solution.

use std::hint::black_box;
use std::time::Instant;
use truepose_compensate::{Compensator, CompensatorOptions, Status};
use truepose_errormodel::Schema;
use truepose_kinematics::{Chain, Conditions, samples};

#[path = "../tests/fits/mod.rs"]
mod fits;

const COUNT: usize = 100_000;

fn main() {
    for chain in [samples::heavy(), samples::ur10()] {
        for (words, tolerance) in [("0.1 µm", 1e-7), ("0.1 nm", 1e-10)] {
            run(&chain, words, tolerance, true);
        }
        run(&chain, "0.1 µm", 1e-7, false);
    }
}

fn run(chain: &Chain, words: &str, tolerance: f64, seeded: bool) {
    let fit = fits::elastic(chain, 5);
    let schema = Schema { load: true, ..Schema::default() };
    let options = CompensatorOptions {
        position_tolerance: tolerance,
        orientation_tolerance: tolerance,
        ..CompensatorOptions::default()
    };
    let mut compensator = Compensator::bind(&fit, &schema, options).expect("bound");
    let mut draw = fits::Draw(1);
    let count = if seeded { COUNT } else { COUNT / 10 };
    let jobs: Vec<_> = (0..count)
        .map(|k| {
            let conditions = Conditions::at(chain, &draw.joints(chain, 0.9));
            let conditions = if k % 2 == 0 { conditions } else { conditions.with_load(fits::load(chain)) };
            // Nominal poses, well away from singularities by nature of the arm but for a few.
            let wanted = fits::target_at(&chain.forward(&conditions.joints));
            (wanted, conditions)
        })
        .collect();
    let mut best = f64::INFINITY;
    let mut singles = vec![0.0; count];
    let (mut ok, mut rounds) = (0, 0);
    for _ in 0..5 {
        (ok, rounds) = (0, 0);
        let begun = Instant::now();
        for (wanted, conditions) in &jobs {
            let seed = seeded.then_some(&conditions.joints[..]);
            let command = black_box(compensator.command(wanted, conditions, seed));
            ok += usize::from(command.status == Status::Ok);
            rounds += command.rounds;
        }
        best = best.min(begun.elapsed().as_secs_f64());
    }
    for ((wanted, conditions), single) in jobs.iter().zip(&mut singles) {
        let seed = seeded.then_some(&conditions.joints[..]);
        let begun = Instant::now();
        black_box(compensator.command(wanted, conditions, seed));
        *single = begun.elapsed().as_secs_f64();
    }
    singles.sort_by(f64::total_cmp);
    println!(
        "{:6} {words} {}: {:.3} s per 100 000, {ok} of {count} ok, {:.2} rounds; single calls: median {:.2} µs, 99.9 % {:.1} µs",
        chain.name(),
        if seeded { "from a seed " } else { "without seed" },
        best * COUNT as f64 / count as f64,
        rounds as f64 / count as f64,
        1e6 * singles[count / 2],
        1e6 * singles[count * 999 / 1000],
    );
}
