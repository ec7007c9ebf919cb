#![doc = include_str!("../README.md")]

mod args;
mod failure;
mod progress;
mod terminal;
mod verbs;
mod watch;

use args::Args;
use failure::Failure;
use std::process::ExitCode;
use watch::{Limits, watched};

fn main() -> ExitCode {
    let args = Args::typed();
    let threads =
        rayon::ThreadPoolBuilder::new().num_threads(args.threads.map_or(0, usize::from)).build_global();
    if let Err(error) = threads {
        terminal::log(&format!("error: {error}"));
        return ExitCode::from(2);
    }
    let limits = Limits { time: args.time_limit, memory: args.memory_limit };
    let done = watched(limits, move |watch| verbs::run(&args.verb, watch));
    match done {
        Ok(code) => code,
        Err(failure) => {
            terminal::log(&failure.to_string());
            ExitCode::from(match failure {
                Failure::Criterion(_) => 1,
                Failure::Input(_) => 2,
            })
        }
    }
}
