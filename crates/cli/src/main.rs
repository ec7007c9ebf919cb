#![doc = include_str!("../README.md")]

mod args;
mod failure;
mod progress;
mod terminal;
mod verbs;
mod watch;

use args::{Args, Verb};
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
    let done = watched(limits, move |watch| {
        verbs::files::apart(&args.verb)?;
        match &args.verb {
            Verb::Identify(verb) => verbs::identify::run(verb, watch),
            Verb::Discover(verb) => verbs::discover::run(verb, watch),
            Verb::Plan(verb) => verbs::plan::run(verb, watch),
            Verb::Predict(verb) => verbs::predict::run(verb, watch),
            Verb::Compensate(verb) => verbs::compensate::run(verb, watch),
            Verb::Export(verb) => verbs::export::run(verb),
            Verb::Map(verb) => verbs::map::run(verb, watch),
            Verb::Compare(verb) => verbs::compare::run(verb, watch),
            Verb::Check(verb) => verbs::check::run(verb),
            Verb::Effects(verb) => verbs::effects::run(verb),
            Verb::Simulate(verb) => verbs::simulate::run(verb),
            Verb::Verify(verb) => verbs::verify::run(verb),
        }
    });
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
