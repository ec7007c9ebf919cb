#![doc = include_str!("../README.md")]

mod args;
mod extensions;
mod failure;
mod progress;
mod space;
mod terminal;
mod typed;
mod verbs;
mod watch;

pub use extensions::Extensions;

use args::{Args, Verb};
use failure::Failure;
use space::granted;
use std::ffi::OsString;
use std::process::ExitCode;
use watch::{Limits, watched};

/// Runs the program with what was typed, and with these effects, solvers and hypotheses beside its own; the exit code.
pub fn run(extensions: Extensions) -> ExitCode {
    ExitCode::from(code(extensions))
}

/// [`run`] with these arguments in place of those of the process, of which the first is the name of the program: for a host in another
/// language. Once in a process; ends it where the arguments are not valid.
pub fn run_with(extensions: Extensions, arguments: Vec<OsString>) -> u8 {
    typed::give(arguments);
    code(extensions)
}

fn code(extensions: Extensions) -> u8 {
    extensions::install(extensions);
    let args = Args::typed();
    terminal::quiet(args.quiet);
    if let Verb::Completions(of) = &args.verb {
        return verbs::completions(of);
    }
    match work(args) {
        Ok(code) => code,
        Err(failure) => {
            terminal::error(&failure.to_string());
            match failure {
                Failure::Criterion(_) => 1,
                Failure::Input(_) => {
                    truepose_io::remove_empty_folders();
                    2
                }
                Failure::Changed => 3,
            }
        }
    }
}

fn work(args: Args) -> Result<u8, Failure> {
    let threads = args.threads.map_or_else(available, usize::from);
    let space = granted(threads)?;
    rayon::ThreadPoolBuilder::new().num_threads(threads).build_global()?;
    let limits = Limits { time: args.time_limit, memory: args.memory_limit, space };
    watched(limits, move |watch| verbs::run(&args.verb, &args.files, watch))
}

/// As many threads as rayon takes by itself.
fn available() -> usize {
    let wanted =
        std::env::var("RAYON_NUM_THREADS").ok().and_then(|text| text.parse().ok()).filter(|&n| n > 0);
    wanted.or_else(|| std::thread::available_parallelism().ok().map(usize::from)).unwrap_or(1)
}
