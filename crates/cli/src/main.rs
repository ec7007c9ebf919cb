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

fn main() -> ExitCode {
    let args = Args::typed();
    let threads =
        rayon::ThreadPoolBuilder::new().num_threads(args.threads.map_or(0, usize::from)).build_global();
    if let Err(error) = threads {
        terminal::log(&format!("error: {error}"));
        return ExitCode::from(2);
    }
    let done =
        watch::begin(&args).and_then(|()| verbs::files::apart(&args.verb)).and_then(|()| match &args.verb {
            Verb::Identify(verb) => verbs::identify::run(verb),
            Verb::Discover(verb) => verbs::discover::run(verb),
            Verb::Plan(verb) => verbs::plan::run(verb),
            Verb::Predict(verb) => verbs::predict::run(verb),
            Verb::Compensate(verb) => verbs::compensate::run(verb),
            Verb::Export(verb) => verbs::export::run(verb),
            Verb::Map(verb) => verbs::map::run(verb),
            Verb::Compare(verb) => verbs::compare::run(verb),
            Verb::Check(verb) => verbs::check::run(verb),
            Verb::Effects(verb) => verbs::effects::run(verb),
            Verb::Simulate(verb) => verbs::simulate::run(verb),
            Verb::Verify(verb) => verbs::verify::run(verb),
        });
    match done {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => {
            terminal::log(&failure.to_string());
            ExitCode::from(match failure {
                Failure::Criterion(_) => 1,
                Failure::Input(_) => 2,
            })
        }
    }
}
